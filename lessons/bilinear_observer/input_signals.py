"""Compute the input u(t), the sensor noise, and the three observer forms in one system."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.linalg import expm

from observer_lab.course.lesson import Design
from observer_lab.engine.observers import BilinearForm

Signal = Callable[[np.ndarray], np.ndarray]
PLAIN_FORM, EXACT_DERIVATIVE, FILTERED_DERIVATIVE = "plain", "exact", "filtered"
FORMS = (PLAIN_FORM, EXACT_DERIVATIVE, FILTERED_DERIVATIVE)
HORIZON = 2.0
RANDOM_HOLDS = 20  # values that a random input holds in a run, and one for its end
DOUBLINGS = 40
NOISE = 1  # stands beside the seed where noise is drawn


def form_index(design: Design) -> int:
    """Which of the three estimates the ghost shows."""
    return FORMS.index(design["form"])


def signal(design: Design, *, horizon: float = HORIZON, which: int = 0) -> Signal:
    """u(t) as the student chose it for one of the inputs, for a run of `horizon` s."""
    number = number_of(which)
    kind, drawn = design[f"input{number}"], design[f"hand{number}"]
    if kind == "random":
        values = random_values(design, which)
        return lambda t: values[np.minimum(t / (horizon / RANDOM_HOLDS) + 1e-9, len(values) - 1).astype(int)]
    if kind == "hand" and drawn:
        times, levels = np.array(drawn).T
        held = np.concatenate([[0.0], levels])
        return lambda t: held[np.searchsorted(times, t + 1e-9 * horizon, side="right")]
    return wave(kind, design[f"amplitude{number}"], design[f"omega{number}"], horizon)


def wave(kind: str, size: float, omega: float, horizon: float) -> Signal:
    """A sine, step, square wave or sweep, else nothing."""
    if kind == "sine":
        return lambda t: size * np.sin(omega * t)
    if kind == "step":
        return lambda t: np.full(np.shape(t), size)
    if kind == "square":
        return lambda t: np.where(np.floor(t * omega / np.pi + 1e-9) % 2 == 0, size, -size)
    if kind == "sweep":
        return lambda t: size * np.cos(omega * t**2 * 2.0 / horizon)
    return lambda t: np.zeros(np.shape(t))


def number_of(which: int) -> str:
    """What the names of an input's knobs end with: nothing for the first, 2 for the second."""
    return str(which + 1) if which else ""


def together(signals: Sequence[Signal]) -> Signal:
    """Several inputs along a last axis; one by itself."""
    return signals[0] if len(signals) == 1 else lambda t: np.stack([one(t) for one in signals], axis=-1)


def columns(u: np.ndarray) -> np.ndarray:
    """The inputs of a run as columns (n_t, k)."""
    return u.reshape(len(u), -1)


def random_values(design: Design, which: int = 0) -> np.ndarray:
    """What a random input holds, one value after the other."""
    seed, size = (design[f"{name}{number_of(which)}"] for name in ("seed", "amplitude"))
    return np.random.default_rng(int(seed)).uniform(-size, size, RANDOM_HOLDS + 1)


def noise_values(design: Design, count: int, outputs: int) -> np.ndarray:
    """What noise of deviation one adds to each sensor (count, m), held over each step."""
    return np.random.default_rng([int(design["seed"]), NOISE]).standard_normal((count, outputs))


def joined(plain: BilinearForm, exact: BilinearForm, tau: float) -> BilinearForm:
    """One form with the states (χ, μ̂, μ̂ of the differentiator, d), q each: ḋ = (L y − d)/τ stands for L ẏ in the third."""
    q = len(exact.A)
    one, none = np.eye(q), np.zeros_like(exact.R)
    A, L = np.zeros((4 * q, 4 * q)), exact.R
    for k, block in enumerate((plain.A, exact.A, exact.A, -one / tau)):
        A[k * q:(k + 1) * q, k * q:(k + 1) * q] = block
    A[2 * q:3 * q, 3 * q:] = -one / tau
    r = len(exact.G_z)
    G_z = np.zeros((3 * r, 4 * q))
    for k, block in enumerate((plain.G_z, exact.G_z, exact.G_z)):
        G_z[k * r:(k + 1) * r, k * q:(k + 1) * q] = block
    return BilinearForm(A, np.vstack([plain.Y, exact.Y, exact.Y + L / tau, L / tau]),
                        np.vstack([plain.B, exact.B, exact.B, 0 * exact.B]), np.vstack([plain.U, exact.U, exact.U, 0 * exact.U]),
                        np.vstack([none, L, none, none]), np.vstack([plain.G_y, exact.G_y, exact.G_y]), G_z)


def promised(form: BilinearForm, deviations: np.ndarray, dt: float) -> np.ndarray:
    """What noise of these deviations (m,), held over dt, makes of each estimate (r,) at rest and u = 0: its rms.

    P = Φ P Φᵀ + Γ S Γᵀ, var ĝ = G_y S G_yᵀ + G_z P G_zᵀ with S = diag(deviations²); infinite where A is not stable.
    """
    q, m = form.Y.shape
    if np.max(np.real(np.linalg.eigvals(form.A))) >= 0:
        return np.full(len(form.G_y), np.inf)
    step: np.ndarray = expm(np.block([[form.A, form.Y * deviations], [np.zeros((m, q + m))]]) * dt)
    phi, gamma = step[:q, :q], step[:q, q:]
    P = gamma @ gamma.T
    for _ in range(DOUBLINGS):  # twice as many past steps each time; unlike a linear system for P it does not mind units
        P, phi = P + phi @ P @ phi.T, phi @ phi
    variance = np.sum((form.G_y * deviations) ** 2, axis=1) + np.einsum("ij,jk,ik->i", form.G_z, P, form.G_z)
    return np.sqrt(np.maximum(variance, 0.0))
