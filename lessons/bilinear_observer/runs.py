"""The plant under any input beside the three forms of one observer, all from the same first guess."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.engine import BilinearPlant, simulate_bilinear
from app.engine.observers import BilinearForm, BilinearRun
from app.lesson.lesson import Design
from app.plants.bilinear import X0

HORIZON, DT = 2.0, 0.005
HOLD = 0.1  # s for which a random input is held
PLAIN, EXACT, FILTERED = "plain", "exact", "filtered"
FORMS = (PLAIN, EXACT, FILTERED)
KICK = (0.0, 0.0, 0.0, 0.0, 2.0, 0.0)


@dataclass(frozen=True, eq=False)
class Watch:
    """One run: t, u (n_t,), x (n_t, 6), g (n_t,), estimates and errors ε = ĝ − g (n_t, 3) in the order of FORMS.

    law (n_t,): ε of the chosen form at its start, or after the kick, times e^{pole t}. fed (n_t, 2): L ẏ, true and as
    the differentiator gives it. `whole`: the run was not cut off because it diverged.
    """

    t: np.ndarray
    u: np.ndarray
    x: np.ndarray
    g: np.ndarray
    estimates: np.ndarray
    errors: np.ndarray
    law: np.ndarray
    fed: np.ndarray
    whole: bool


def signal(design: Design) -> Callable[[np.ndarray], np.ndarray]:
    """u(t) as the student chose it."""
    kind, size, omega = design["input"], design["amplitude"], design["omega"]
    if kind == "sine":
        return lambda t: size * np.sin(omega * t)
    if kind == "step":
        return lambda t: np.full(np.shape(t), size)
    if kind == "square":
        return lambda t: np.where(np.floor(t * omega / np.pi + 1e-9) % 2 == 0, size, -size)
    if kind == "sweep":
        return lambda t: size * np.cos(omega * t**2)
    if kind == "random":
        values = np.random.default_rng(int(design["seed"])).uniform(-size, size, round(HORIZON / HOLD) + 1)
        return lambda t: values[np.minimum(t / HOLD + 1e-9, len(values) - 1).astype(int)]
    if kind == "hand" and design["hand"]:
        times, drawn = np.array(design["hand"]).T
        held = np.concatenate([[0.0], drawn])
        return lambda t: held[np.searchsorted(times, t + 1e-9, side="right")]
    return lambda t: np.zeros(np.shape(t))


def joined(plain: BilinearForm, exact: BilinearForm, tau: float) -> BilinearForm:
    """One form with the states (χ, μ̂, μ̂ of the differentiator, d): ḋ = (L y − d)/τ stands for L ẏ in the third."""
    A = np.diag([plain.A[0, 0], exact.A[0, 0], exact.A[0, 0], -1 / tau])
    A[2, 3] = -1 / tau
    L, none, still = exact.R, np.zeros_like(exact.R), np.zeros((1, 1))
    G_z = np.zeros((3, 4))
    G_z[[0, 1, 2], [0, 1, 2]] = plain.G_z[0, 0], exact.G_z[0, 0], exact.G_z[0, 0]
    return BilinearForm(A, np.vstack([plain.Y, exact.Y, exact.Y + L / tau, L / tau]),
                        np.vstack([plain.B, exact.B, exact.B, still]), np.vstack([plain.U, exact.U, exact.U, none]),
                        np.vstack([none, L, none, none]), np.vstack([plain.G_y, exact.G_y, exact.G_y]), G_z)


def watch(plant: BilinearPlant, K: np.ndarray, plain: BilinearForm, exact: BilinearForm, design: Design) -> Watch:
    """Run all forms from χ(0), μ̂(0) = χ(0) + L y(0). A kick moves x, and through ẏ the exact form, never χ."""
    tau, u = design["tau"], signal(design)
    form, rows = joined(plain, exact, tau), np.repeat(K, 3, axis=0)
    x0, start = np.array(X0), (exact.R @ plant.C @ X0).item()
    z0 = np.array([design["chi0"], design["chi0"] + start, design["chi0"] + start, start])
    at = int(design["kick"] / DT + 1e-9) if design["kick"] >= 0 else None

    def run(x: np.ndarray, z: np.ndarray, begin: int, end: int) -> BilinearRun:
        return simulate_bilinear(plant, form, rows, lambda t: u(t + begin * DT), x, z, (end - begin) * DT, DT)

    last = round(HORIZON / DT)
    pieces = [run(x0, z0, 0, last)] if at is None else _kicked(plant, form, run, x0, z0, min(at, last - 1), last)
    return _watch(plant, exact, tau, form_index(design), plain.A[0, 0], pieces, last)


def form_index(design: Design) -> int:
    """Which of the three estimates the ghost shows."""
    return FORMS.index(design["form"])


def _kicked(plant: BilinearPlant, form: BilinearForm, run: Callable[..., BilinearRun], x0: np.ndarray, z0: np.ndarray,
            at: int, last: int) -> list[BilinearRun]:
    jump = np.array(KICK)
    leap = form.R @ plant.C @ jump
    if at == 0:
        return [run(x0 + jump, z0 + leap, 0, last)]
    before = run(x0, z0, 0, at)
    if before.diverged_at is not None:
        return [before]
    return [before, run(before.x[-1] + jump, before.z[-1] + leap, at, last)]


def _watch(plant: BilinearPlant, exact: BilinearForm, tau: float, chosen: int, pole: float, pieces: list[BilinearRun],
           last: int) -> Watch:
    def whole(name: str) -> np.ndarray:  # the sample at the kick is the one just after it
        parts = [getattr(p, name) for p in pieces]
        return np.concatenate([*(p[:-1] for p in parts[:-1]), parts[-1]])

    x, u, z, errors = whole("x"), whole("u"), whole("z"), whole("error")
    t = DT * np.arange(len(x))
    laws = [p.error[0, chosen] * np.exp(pole * p.t) for p in pieces]
    law = np.concatenate([*(part[:-1] for part in laws[:-1]), laws[-1]])
    rate = x @ plant.A.T + u[:, None] * (x @ plant.F.T + plant.B[:, 0])
    L = exact.R[0]
    fed = np.column_stack([rate @ plant.C.T @ L, (x @ plant.C.T @ L - z[:, 3]) / tau])
    return Watch(t, u, x, whole("g")[:, 0], whole("estimate"), errors, law, fed, len(x) == last + 1)
