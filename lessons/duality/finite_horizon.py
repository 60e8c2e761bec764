"""Solve both Riccati equations in time: regulator backwards, filter forwards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm, solve_continuous_lyapunov

from observer_lab.course.figures.records import Curve, LineFigure
from observer_lab.engine import Plant
from observer_lab.text import joined, same, text

from ..toolkit.latex import percent

HORIZON_STEPS = 80
HORIZON_TAB = text("Finite horizon")
Weights = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class Horizon:
    """Over t (n_t,): S(t) (n_t, n, n), which ends at S_f, P(t) (n_t, n, n), which begins at P₀, and K(t) = R⁻¹BᵀS(t) (n_t, m, n)."""

    t: np.ndarray
    S: np.ndarray
    P: np.ndarray
    K: np.ndarray


def horizon_of(plant: Plant, weights: Weights, S: np.ndarray, P: np.ndarray, T: float, ends: tuple[np.ndarray, np.ndarray]) -> Horizon:
    """Both equations over T s; `weights` are Q, R, W, V, S and P what the two settle to, `ends` the terminal weight S_f and P₀.

    −Ṡ = AᵀS + SA − SBR⁻¹BᵀS + Q from S(T) = S_f, Ṗ = AP + PAᵀ − PCᵀV⁻¹CP + W from P(0) = P₀.
    Source: report (003), appendix A, Φ(x) = ½ xᵀS_f x, and (40)–(51); Anderson and Moore, Optimal Control (1990).
    """
    _, R, _, V = weights
    A, B, C = plant.A, plant.B, plant.C
    back, forward = (_path(*side, T) for side in (
        (A, B @ np.linalg.solve(R, B.T), S, ends[0]), (A.T, C.T @ np.linalg.solve(V, C), P, ends[1])))
    return Horizon(T * np.arange(HORIZON_STEPS + 1) / HORIZON_STEPS, back[::-1], forward, np.linalg.solve(R, B.T @ back[::-1]))


def _path(A: np.ndarray, G: np.ndarray, X: np.ndarray, first: np.ndarray, T: float) -> np.ndarray:
    """X(τ) (n_t, n, n) of dX/dτ = AᵀX + XA − XGX + Q from X(0) = `first` at equal times up to T; the equation settles to X.

    What is missing, D = X − X(τ), obeys dD/dτ = FᵀD + DF + DGD with F = A − GX stable. So D⁻¹ obeys a linear equation, and
    D = EᵀD(0)(I − ΓD(0))⁻¹E with E = e^{Fτ}, Γ(τ) = ∫₀^τ e^{Fs} G e^{Fᵀs} ds: nothing in it grows.
    """
    n, F = len(A), A - G @ X
    whole = solve_continuous_lyapunov(F, -G)
    step, powers = expm(F * T / HORIZON_STEPS), [np.eye(n)]
    for _ in range(HORIZON_STEPS):
        powers.append(powers[-1] @ step)
    E = np.array(powers)
    heard = whole - E @ whole @ E.swapaxes(1, 2)
    start = X - first
    missing = E.swapaxes(1, 2) @ start @ np.linalg.solve(np.eye(n) - heard @ start, E)
    missing[0] = start
    return X - (missing + missing.swapaxes(1, 2)) / 2


def horizon_figure(found: Horizon, S: np.ndarray, P: np.ndarray, K: np.ndarray, terminal: float) -> LineFigure:
    """The traces as shares of what they settle to far from their ends, S, P and K of the endless problem; S_f = terminal·S."""
    def share(path: np.ndarray, settled: np.ndarray) -> np.ndarray:
        return np.trace(path, axis1=1, axis2=2) / max(float(np.trace(settled)), 1e-300)
    back, forward = share(found.S, S), share(found.P, P)
    size = np.linalg.norm(found.K, axis=(1, 2)) / max(float(np.linalg.norm(K)), 1e-300)
    reached = text("T = {window:.3g} s. S at t = 0 is {back} % of its limit, P at T is {forward} %.", window=float(found.t[-1]),
                   back=percent(float(back[0])), forward=percent(float(forward[-1])))
    end = (text("At the end no cost is left to save, so K is 0.") if terminal == 0 else
           text("The terminal weight is the settled S, so S(t) and K(t) are constant.") if terminal == 1 else
           text("At the end K is R⁻¹BᵀS_f, {share:.3g} times its limit.", share=terminal))
    return LineFigure(
        "horizon", text("two Riccati equations in opposite time"), found.t,
        (Curve(text("tr S(t), from S(T) = S_f backwards"), back, "plant"),
         Curve(text("tr P(t), from P(0) = P₀ forwards"), forward, "estimate"),
         Curve(same("‖K(t)‖"), size, "force", "dash")),
        text("share of the settled value"), window=(0.0, 1.1), tab=HORIZON_TAB, caption=joined(reached, end))
