"""Simulate an own bilinear plant beside three observer forms with sensor noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine.observers import BilinearForm, BilinearRun

from .input_signals import Signal, form_index, joined, noise_values, promised, signal, together
from .own_plant import Here, Wanted, error_matrix
from .run_record import Record, Setting, end_to_end, fed_of, kicked_at, whole

HELD_SHARE = 1e-4  # of the largest |ĝ| and |g|: an error below this is compared with that, for digits' sake


@dataclass(frozen=True, eq=False)
class Run(Record):
    """A record of r numbers g, (n_t, r) and (n_t, 3, r). gap: how far ε leaves the law ẇ = A_L w, relative to its peak.

    promised (3, r): the rms of what the sensors' noise makes of each estimate at rest and u = 0.
    """

    gap: float
    promised: np.ndarray


def forms_at(wanted: Wanted, L: np.ndarray) -> tuple[BilinearForm, BilinearForm]:
    """(17) with (13), and (18) with (19), for the gain in use."""
    return wanted.solved.forms(L)


def deviations(here: Here, design: Design) -> np.ndarray:
    """Standard deviations (m,) of the sensors' noise: a share of what each reads at most in the first run."""
    return design["noise"] / 100 * here.readings


def run_of(here: Here, design: Design, wanted: Wanted, L: np.ndarray) -> Run:
    """From the model's x(0) and χ(0) = 0 under the input chosen."""
    exact, plain = forms_at(wanted, L)
    form, D, last = joined(plain, exact, design["tau"]), here.scale, round(here.horizon / here.dt)
    plant, x0, sigma = here.inner, np.array(here.model.x0) / D, deviations(here, design)
    start = exact.R @ plant.C @ x0
    setting = Setting(plant, form, np.tile(wanted.K * D, (3, 1)), _inputs(here, design), x0,
                      np.concatenate([np.zeros(wanted.solved.order), start, start, start]), np.array(here.model.kick) / D,
                      kicked_at(design["kick"], here.dt, last), last, here.dt)
    calm = setting.pieces(None)
    noisy = setting.pieces(sigma * noise_values(design, last + 1, plant.m)) if design["noise"] else calm
    return _told(here, design, wanted, L, calm, noisy, promised(form, sigma, here.dt) if design["noise"] else np.zeros(len(form.G_y)))


def _inputs(here: Here, design: Design) -> Signal:
    return together([signal(design, horizon=here.horizon, which=j) for j in range(here.plant.inputs)])


def _told(here: Here, design: Design, wanted: Wanted, L: np.ndarray, calm: list[BilinearRun], noisy: list[BilinearRun],
          says: np.ndarray) -> Run:
    r, q, index = len(wanted.K), wanted.solved.order, form_index(design)
    count = min(len(whole("x", noisy)), len(whole("x", calm)))
    x, u = (whole(name, noisy)[:count] for name in ("x", "u"))
    errors, still = (whole("error", of)[:count].reshape(count, 3, r) for of in (noisy, calm))
    readout, A_L = wanted.solved.readout, error_matrix(wanted.solved, L)
    row, seen = wanted.solved.V[1] * here.scale, L @ here.inner.C

    def law_of(p: BilinearRun) -> np.ndarray:  # w = μ̂ − μ, and in the form without ẏ μ̂ = χ + L y
        w = p.z[0, index * q:(index + 1) * q] + (seen @ p.x[0] if index == 0 else 0.0) - row @ p.x[0]
        return _law(w, len(p.t), A_L, readout, here.dt)
    law = end_to_end([law_of(p) for p in calm])[:count]
    g, estimates = whole("g", noisy)[:count, :r], whole("estimate", noisy)[:count].reshape(count, 3, r)
    fed = fed_of(here.inner, L[0], noisy, 3 * q, design["tau"])[:count]
    size = np.maximum(np.max(np.abs(law), axis=0), HELD_SHARE * np.maximum(np.max(np.abs(g), axis=0),
                                                                           np.max(np.abs(estimates[:, index]), axis=0)))
    gap = float(np.max(np.abs(errors[:, index] - law) / np.where(size > 0, size, 1.0)))
    return Run(here.dt * np.arange(count), u, x * here.scale, g, estimates, errors, errors - still, law, fed, gap, says.reshape(3, r))


def _law(start: np.ndarray, count: int, A: np.ndarray, readout: np.ndarray, h: float) -> np.ndarray:
    """ε (count, r) of ẇ = A w from w(0) by the method of the run, Gauss's of order 6: of a linear equation it makes a Padé approximant."""
    q = len(A)
    Z = A * h
    even, odd = np.eye(q) + Z @ Z / 10, Z / 2 + Z @ Z @ Z / 120
    step = np.linalg.solve(even - odd, even + odd)
    w = np.empty((count, q))
    w[0] = start
    for k in range(1, count):
        w[k] = step @ w[k - 1]
    return np.clip(np.nan_to_num(w @ readout.T, nan=1e15, posinf=1e15, neginf=-1e15), -1e15, 1e15)
