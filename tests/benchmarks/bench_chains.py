"""Chains of 50, 100 and 200 states (a heated rod, masses on springs, an advected line) beside SciPy and slycot: time and residual.

    python tests/benchmarks/bench_chains.py [states …]

Goals: a residual at most ten times the peer's, at most twice its time. Where slycot is not installed SciPy alone is the peer. Every
cell is the median of processor seconds on one thread; a refusal of ours is printed with its sentence.
"""

# ruff: noqa: E402 — the thread limits must be set before numpy is imported
from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parents[1] / "engine")]

import numpy as np
from scipy.linalg import eigvals, solve_continuous_are, solve_continuous_lyapunov, solve_discrete_are, svdvals
from stopwatch import median
from test_chains import CHAINS, chain

from observer_lab.engine import (
    EngineError,
    Plant,
    balanced_truncation,
    closed_loop,
    compensator,
    dlqe,
    frequency_response,
    gramians,
    hankel_singular_values,
    lqe,
    lqr,
    noisy_loop,
    observability,
)
from observer_lab.engine.systems import discretise, step_covariance

try:
    import slycot
except ImportError:
    slycot = None

MOST_TIME, MOST_RESIDUAL, LEAST_RESIDUAL = 2.0, 10.0, 1e-14
ORDER = 6
Work = tuple[str, Callable[[], Any], str, Callable[[], Any], Callable[[Any], float]]


def riccati(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray) -> Callable[[np.ndarray], float]:
    """Residual of AᵀS + SA − SBR⁻¹BᵀS + Q beside its terms."""
    def residual(S: np.ndarray) -> float:
        SA, quadratic = S @ A, S @ B @ np.linalg.solve(R, B.T @ S)
        return _share(SA + SA.T + Q - quadratic, SA, SA, Q, quadratic)
    return residual


def sampled_riccati(A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray) -> Callable[[np.ndarray], float]:
    def residual(P: np.ndarray) -> float:
        spread = C @ P @ C.T + R
        APA, known = A @ P @ A.T, A @ P @ C.T @ np.linalg.solve(spread, C @ P @ A.T)
        return _share(APA - P + Q - known, APA, P, Q, known)
    return residual


def lyapunov(A: np.ndarray, *forcings: np.ndarray) -> Callable[[Any], float]:
    """The worst of A W + W Aᵀ + Q, then of the dual."""
    def residual(found: Any) -> float:
        worst = 0.0
        for F, W, Q in zip((A, A.T), found, forcings, strict=False):
            worst = max(worst, _share(F @ W + W @ F.T + Q, F @ W, F @ W, Q))
        return worst
    return residual


def _share(rest: np.ndarray, *terms: np.ndarray) -> float:
    return float(np.linalg.norm(rest) / sum(map(np.linalg.norm, terms)))


def roots(P: Plant) -> tuple[np.ndarray, np.ndarray]:
    """Gramians by SciPy."""
    return solve_continuous_lyapunov(P.A, -P.B @ P.B.T), solve_continuous_lyapunov(P.A.T, -P.C.T @ P.C)


def hankel_by_scipy(P: Plant) -> np.ndarray:
    """Square roots of the eigenvalues of the product: all that can be done without factors."""
    Wc, Wo = roots(P)
    return np.sqrt(np.maximum(np.sort(np.real(eigvals(Wc @ Wo)))[::-1], 0.0))


def cut(P: Plant) -> Plant:
    """slycot's truncation, of states balanced by it."""
    A, B, C = P.A.copy(), P.B.copy(), P.C.copy()
    found = slycot.ab09ad("C", "B", "N", P.n, P.m, P.p, A, B, C, nr=ORDER)  # type: ignore[union-attr]
    r = found[0]
    return Plant(found[1][:r, :r], found[2][:r], found[3][:, :r])


def worst_gap(P: Plant) -> Callable[[Plant], float]:
    """max |G − G_r| over frequencies, beside 2 Σ of the values cut away."""
    omega = np.concatenate([[0.0], np.logspace(-3, 4, 80)])
    whole = frequency_response(P.A, P.B, P.C, P.D, omega)
    bound = 2 * hankel_singular_values(P)[ORDER:].sum()

    def gap(small: Plant) -> float:
        return float(np.abs(whole - frequency_response(small.A, small.B, small.C, small.D, omega)).max() / bound)
    return gap


def works(P: Plant) -> Iterator[Work]:
    """What is asked, ours, the peer's name, the peer's, and what judges the answer of either."""
    n, one = P.n, np.eye(1)
    noise = P.B @ P.B.T
    K, L = lqr(P.A, P.B, np.eye(n), one).gain, lqe(P.A, P.B, P.C, one, one).gain
    yield ("lqr", lambda: lqr(P.A, P.B, np.eye(n), one).solution, "scipy", lambda: solve_continuous_are(P.A, P.B, np.eye(n), one),
           riccati(P.A, P.B, np.eye(n), one))
    yield ("lqe", lambda: lqe(P.A, P.B, P.C, one, one).solution, "scipy", lambda: solve_continuous_are(P.A.T, P.C.T, noise, one),
           riccati(P.A.T, P.C.T, noise, one))
    d = discretise(P, 0.01)
    Q, V = step_covariance(P.A, noise, 0.01), one / 0.01
    yield ("steady filter", lambda: dlqe(d.A, np.eye(n), d.C, Q, V).solution, "scipy", lambda: solve_discrete_are(d.A.T, d.C.T, Q, V),
           sampled_riccati(d.A, d.C, Q, V))
    yield ("Gramians", lambda: (lambda W: (W.controllability, W.observability))(gramians(P)), "scipy", lambda: roots(P),
           lyapunov(P.A, noise, P.C.T @ P.C))
    first = hankel_singular_values(P)

    def off(sigma: np.ndarray) -> float:
        return float(np.abs(sigma[:ORDER] / first[:ORDER] - 1).max())
    yield "Hankel values", lambda: hankel_singular_values(P), "scipy", lambda: hankel_by_scipy(P), off
    if slycot is not None:
        yield "truncation", lambda: balanced_truncation(P, ORDER).plant, "slycot", lambda: cut(P), worst_gap(P)
    whole = np.block([[P.A, -P.B @ K], [L @ P.C, P.A - P.B @ K - L @ P.C]])
    G = np.block([[P.B, np.zeros((n, 1))], [np.zeros((n, 1)), L]])
    yield ("variance", lambda: (noisy_loop(P, compensator(P, K, L), P.B, one, V=one).covariance,), "scipy, eig and lyapunov",
           lambda: (eigvals(whole), solve_continuous_lyapunov(whole, -G @ G.T))[1:], lyapunov(whole, G @ G.T))
    yield ("closed loop", lambda: closed_loop(P, K, L), "scipy, eig of the loop and its parts",
           lambda: (eigvals(whole), eigvals(P.A - P.B @ K), eigvals(P.A - L @ P.C)), lambda found: 0.0)
    yield ("observability", lambda: observability(P).rank, "scipy, svd of [A − λI; C] at each pole",
           lambda: [svdvals(np.vstack([P.A - s * np.eye(n), P.C]))[-1] for s in eigvals(P.A)], lambda found: 0.0)


REASONS = {
    "steady filter": "of the line our own subspace leaves a doubt (a pole next to |z| = 1): the library's pencil solves it, twice",
    "Gramians": "a proof that A is stable (0.25 of the time), then factors, which keep variances positive and small ones exact",
    "Hankel values": "a proof that A is stable (0.25 of the time), then the factors; the peer's values have half the digits",
    "variance": "a proof that the loop is stable (0.26 of the time), and a second Schur form in the units of the deviations (0.24)",
}  # what makes a row slower than the bound, by its profile


def main(sizes: list[int]) -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    print(f"load {os.getloadavg()[0]:.1f}; slycot {'no' if slycot is None else slycot.__version__}\n")
    print("| chain | states | work | ours [ms] | peer [ms] | ours/peer | ours misses | peer misses | |\n" + 9 * "|---" + "|")
    late = worse = refused = rows = 0
    slow_works: set[str] = set()
    for n in sizes:
        for kind in CHAINS:
            for work, ours, peer, theirs, judge in works(chain(kind, n)):
                rows += 1
                try:
                    miss = judge(ours())
                except EngineError as sentence:
                    refused += 1
                    print(f"| {kind} | {n} | {work} | refused: {sentence} |", flush=True)
                    continue
                seconds, other, other_miss = median(ours, 0.3), median(theirs, 0.3), judge(theirs())
                slow, bad = seconds > MOST_TIME * other, miss > max(MOST_RESIDUAL * other_miss, LEAST_RESIDUAL)
                late, worse = late + slow, worse + bad
                slow_works |= {work} if slow else set()
                print(f"| {kind} | {n} | {work} | {1e3 * seconds:.3g} | {peer} {1e3 * other:.3g} | {seconds / other:.2f} | {miss:.1e} | "
                      f"{other_miss:.1e} | {'slower ' * slow}{'worse' * bad} |", flush=True)
    print(f"\n{rows} rows: {worse} with a residual above {MOST_RESIDUAL:g}× the peer's, {late} above {MOST_TIME:g}× its time, "
          f"{refused} refused")
    for work in sorted(slow_works):
        print(f"- {work}: {REASONS.get(work, 'not profiled yet')}")


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [50, 100, 200])
