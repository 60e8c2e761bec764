"""A run of a person's own bilinear plant beside three forms of its observer, with the noise of its sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.engine import simulate_bilinear
from app.engine.observers import BilinearForm, BilinearRun
from app.lesson.lesson import Design

from .drive import form_index, joined, noise_values, promised, signal
from .own_plant import Here, Wanted, error_matrix

HELD_SHARE = 1e-4  # of the largest |ĝ| and |g|: an error below this is compared with that, for digits' sake


@dataclass(frozen=True, eq=False)
class Run:
    """t, u (n_t,), x (n_t, n), g (n_t, r), estimates and errors ε = ĝ − g (n_t, 3, r), heard (n_t, 3, r): what noise made of them.

    law (n_t, r): the chosen form's error as its own equation ẇ = A_L w would have it from the start, or from the kick. fed
    (n_t, 2): the first row of L ẏ, true and as the differentiator has it. gap: how far ε leaves the law, relative to its peak.
    """

    t: np.ndarray
    u: np.ndarray
    x: np.ndarray
    g: np.ndarray
    estimates: np.ndarray
    errors: np.ndarray
    heard: np.ndarray
    law: np.ndarray
    fed: np.ndarray
    gap: float
    promised: np.ndarray  # (3, r)


def forms_at(wanted: Wanted, L: np.ndarray) -> tuple[BilinearForm, BilinearForm]:
    """(17) with (13), and (18) with (19), for the gain in use."""
    return wanted.solved.forms(L)


def deviations(here: Here, design: Design) -> np.ndarray:
    """Standard deviations (m,) of the sensors' noise: a share of what each reads at most in the first run."""
    return design["noise"] / 100 * here.readings


def run_of(here: Here, design: Design, wanted: Wanted, L: np.ndarray) -> Run:
    """From the model's x(0) and χ(0) = 0 under the input chosen; a kick moves x, and through ẏ the exact form, never χ."""
    exact, plain = forms_at(wanted, L)
    form, D, q = joined(plain, exact, design["tau"]), here.scale, wanted.solved.order
    plant, last = here.inner, round(here.horizon / here.dt)
    rows, u = np.tile(wanted.K * D, (3, 1)), signal(design, horizon=here.horizon)
    x0 = np.array(here.model.x0) / D
    start = exact.R @ plant.C @ x0
    z0 = np.concatenate([np.zeros(q), start, start, start])
    sigma = deviations(here, design)
    noise = sigma * noise_values(design, last + 1, plant.m) if design["noise"] else None
    at = min(int(design["kick"] / here.dt + 1e-9), last - 1) if design["kick"] >= 0 else None

    def piece(x: np.ndarray, z: np.ndarray, begin: int, end: int, noise: np.ndarray | None) -> BilinearRun:
        return simulate_bilinear(plant, form, rows, lambda t: u(t + begin * here.dt), x, z, horizon=(end - begin) * here.dt, dt=here.dt,
                                 noise=None if noise is None else noise[begin:end + 1])

    def pieces(noise: np.ndarray | None) -> list[BilinearRun]:
        if at is None:
            return [piece(x0, z0, 0, last, noise)]
        jump = np.array(here.model.kick) / D
        leap = form.R @ plant.C @ jump
        if at == 0:
            return [piece(x0 + jump, z0 + leap, 0, last, noise)]
        before = piece(x0, z0, 0, at, noise)
        if before.diverged_at is not None:
            return [before]
        return [before, piece(before.x[-1] + jump, before.z[-1] + leap, at, last, noise)]
    calm = pieces(None)
    return _told(here, design, wanted, L, calm, calm if noise is None else pieces(noise),
                 promised(form, sigma, here.dt) if design["noise"] else np.zeros(len(form.G_y)))


def _told(here: Here, design: Design, wanted: Wanted, L: np.ndarray, calm: list[BilinearRun], noisy: list[BilinearRun],
          says: np.ndarray) -> Run:
    def whole(name: str, of: list[BilinearRun]) -> np.ndarray:  # the sample at the kick is the one just after it
        parts = [getattr(p, name) for p in of]
        return np.concatenate([*(p[:-1] for p in parts[:-1]), parts[-1]])
    r, q, index = len(wanted.K), wanted.solved.order, form_index(design)
    count = min(len(whole("x", noisy)), len(whole("x", calm)))
    x, u, z, y = (whole(name, noisy)[:count] for name in ("x", "u", "z", "y"))
    errors, still = (whole("error", of)[:count].reshape(count, 3, r) for of in (noisy, calm))
    readout, A_L = wanted.solved.readout, error_matrix(wanted.solved, L)
    row, seen = wanted.solved.V[1] * here.scale, L @ here.inner.C

    def law_of(p: BilinearRun) -> np.ndarray:  # w = μ̂ − μ, and in the form without ẏ μ̂ = χ + L y
        w = p.z[0, index * q:(index + 1) * q] + (seen @ p.x[0] if index == 0 else 0.0) - row @ p.x[0]
        return _law(w, len(p.t), A_L, readout, here.dt)
    law = np.concatenate([*(law_of(p)[:-1] for p in calm[:-1]), law_of(calm[-1])])[:count]
    g, estimates = whole("g", noisy)[:count, :r], whole("estimate", noisy)[:count].reshape(count, 3, r)
    plant = here.inner
    rate = x @ plant.A.T + u[:, None] * (x @ plant.F.T + plant.B[:, 0])
    fed = np.column_stack([rate @ plant.C.T @ L[0], (y @ L[0] - z[:, 3 * q]) / design["tau"]])
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
