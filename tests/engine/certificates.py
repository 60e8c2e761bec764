"""The table of certificates: what the engine says of its own answers, beside fifty digits.

    python tests/engine/certificates.py [plants] [seed] [law …]

Each law takes a random ill-conditioned plant and returns what is said and what is true; `breach` compares.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[2]), str(Path(__file__).resolve().parent)]

from fifty_digits import (
    away_from,
    difference_on_grid,
    distance_to_hidden,
    eigenvalues,
    hankel_values,
    response,
    riccati_residual,
    roots,
    sampled_variances,
    union_gap,
    variances,
)

from observer_lab.engine import EngineError, Plant, design, feedback, structure, systems
from observer_lab.engine.design.riccati import RiccatiProblem, in_balanced_units

FACTOR = 10.0
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Case:
    """A plant of 2 … 8 states, poles to ask for, and its seed."""

    plant: Plant
    poles: np.ndarray
    rng: np.random.Generator


Pairs = list[tuple[float, float, float]]  # what is said, what is true, and how small a difference is nothing


def spread_poles(rng: np.random.Generator, n: int) -> np.ndarray:
    """Simple, multiple, nearly multiple poles, or poles decades apart; conjugate pairs among them."""
    kind, pairs = rng.integers(4), int(rng.integers(0, n // 2 + 1))
    upper = -rng.uniform(0.3, 3, pairs) + 1j * rng.uniform(0.3, 4, pairs)
    real = -rng.uniform(0.3, 5, n - 2 * pairs)
    if kind == 1:
        upper[:], real[:] = upper[:1].sum(), real[:1].sum()
    elif kind == 2:
        real = real[:1].sum() * (1 + 10 ** rng.uniform(-12, -3) * np.arange(len(real)))
    elif kind == 3:
        upper, real = (v * 10 ** rng.uniform(-2, 2, len(v)) for v in (upper, real))
    return np.concatenate([real, upper, upper.conj()]).astype(complex)


def block_diagonal(poles: np.ndarray) -> np.ndarray:
    """A real matrix with these poles, pairs as blocks."""
    M = np.diag(poles.real)
    upper, lower = np.flatnonzero(poles.imag > 0), np.flatnonzero(poles.imag < 0)
    M[upper, lower], M[lower, upper] = poles.imag[upper], -poles.imag[upper]
    return M


def random_case(rng: np.random.Generator) -> Case:
    """Stable modes turned by an ill-conditioned matrix, a cascade, a companion form, a dense plant, or near-hidden modes."""
    n = int(rng.integers(2, 9))
    m, p = (int(rng.integers(1, min(n, 2) + 1)) for _ in range(2))
    kind, modes = rng.integers(5), spread_poles(rng, n)
    A = block_diagonal(modes)
    B, C = rng.standard_normal((n, m)), rng.standard_normal((p, n))
    if kind == 0:
        T = np.linalg.qr(rng.standard_normal((n, n)))[0] * 10 ** rng.uniform(-2, 2, n) @ np.linalg.qr(rng.standard_normal((n, n)))[0]
        A, B, C = np.linalg.solve(T, A @ T), np.linalg.solve(T, B), C @ T
    elif kind == 1:
        A = np.diag(modes.real) + np.diag(rng.uniform(0.5, 2, n - 1), -1)
        B, C = np.eye(n)[:, :1], np.eye(n)[n - 1:]
    elif kind == 2:
        A = np.vstack([np.eye(n, k=1)[:-1], -np.poly(modes).real[:0:-1]])
        B = np.eye(n)[:, n - 1:]
    elif kind == 3:
        A = rng.standard_normal((n, n))
        A -= (max(np.linalg.eigvals(A).real.max(), 0) + 10 ** rng.uniform(-3, 0)) * np.eye(n)
    else:
        B[0], C[:, -1] = B[0] * 10 ** rng.uniform(-9, -2), C[:, -1] * 10 ** rng.uniform(-9, -2)
        Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
        A, B, C = Q @ A @ Q.T, Q @ B, C @ Q.T
    return Case(Plant(A, B, C), spread_poles(rng, n), rng)


# --- laws: what is said, what is true ------------------------------------------------------------------------------
def placement(c: Case) -> Pairs:
    found = design.place(c.plant.A, c.plant.B, c.poles)
    true = away_from(found.asked, eigenvalues(c.plant.A, c.plant.B, found.gain))
    return [(found.error, true, 1e-19 * float(np.abs(found.asked).max()))]


def observer(c: Case) -> Pairs:
    found = design.observer_gain(c.plant.A, c.plant.C, c.poles)
    true = away_from(found.asked, eigenvalues(c.plant.A, found.gain, c.plant.C))
    return [(found.error, true, 1e-19 * float(np.abs(found.asked).max()))]


def balanced(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The units of states and inputs in which a residual is meant: powers of two, so nothing is rounded."""
    _, states, inputs = in_balanced_units(RiccatiProblem(A, B, Q, R, np.zeros(B.shape)))
    return states, inputs


def costs(c: Case, k: int) -> np.ndarray:
    return np.diag(10 ** c.rng.uniform(-3, 3, k))


def regulator(c: Case) -> Pairs:
    p, Q, R = c.plant, costs(c, c.plant.n), costs(c, c.plant.m)
    found = design.lqr(p.A, p.B, Q, R)
    x, u = balanced(p.A, p.B, Q, R)
    true = riccati_residual(p.A * x / x[:, None], p.B * u / x[:, None], Q * x * x[:, None], R * u * u[:, None],
                            found.solution * x * x[:, None])
    return [(found.residual, true, 1e-19)]


def sampled_regulator(c: Case) -> Pairs:
    p, Q, R = systems.discretise(c.plant, 0.1), costs(c, c.plant.n), costs(c, c.plant.m)
    found = design.dlqr(p.A, p.B, Q, R)
    x, u = balanced(p.A, p.B, Q, R)
    true = riccati_residual(p.A * x / x[:, None], p.B * u / x[:, None], Q * x * x[:, None], R * u * u[:, None],
                            found.solution * x * x[:, None], sampled=True)
    return [(found.residual, true, 1e-19)]


def estimator(c: Case) -> Pairs:
    A, C, G, W, V = c.plant.A, c.plant.C, c.plant.B, costs(c, c.plant.m), costs(c, c.plant.p)
    found = design.lqe(A, G, C, W, V)
    x, y = balanced(A.T, C.T, G @ W @ G.T, V)
    true = riccati_residual(A.T * x / x[:, None], C.T * y / x[:, None], (G * x[:, None], W), V * y * y[:, None],
                            found.solution * x * x[:, None])
    return [(found.residual, true, 1e-19)]


def variances_settled(c: Case) -> Pairs:
    """Variances are right to what rounding the plant may do to them."""
    p = c.plant
    return _variances(p.A, p.B, 0.0, variances)


def loop_variances(c: Case) -> Pairs:
    """Of sampled loops with gains of a hundred, which magnify rounding a million times and more."""
    n = c.plant.n
    turn = np.linalg.qr(c.rng.standard_normal((n, n)))[0]
    A = turn @ (np.diag(c.rng.uniform(-0.95, 0.95, n)) + np.triu(100 * c.rng.standard_normal((n, n)), 1)) @ turn.T
    return _variances(A, c.rng.standard_normal((n, 2)), 1.0, sampled_variances)


def _variances(A: np.ndarray, G: np.ndarray, dt: float, oracle: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Pairs:
    """The largest relative error beside that which changes of A by rounding make in the truth itself."""
    signs = np.random.default_rng(0)
    true = oracle(A, G)
    rounding = EPS * np.linalg.norm(A, 2) / np.sqrt(len(A))
    moved = np.array([oracle(A + rounding * signs.standard_normal(A.shape), G) for _ in range(2)])
    if not np.isfinite([true, *moved]).all() or np.any(np.abs(moved - true) > 0.1 * true):  # the plant does not tell
        return []
    allowed = max(float(np.abs(m / true - 1).max()) for m in moved)
    found = np.diag(systems.settled_covariance(A, G, dt=dt))
    return [(float(np.abs(found / true - 1).max()), 0.0, 100 * allowed + 1e3 * EPS)]


def truncation(c: Case) -> Pairs:
    order = int(c.rng.integers(0, c.plant.n))
    cut = structure.balanced_truncation(c.plant, order)
    true = 2 * float(sum(hankel_values(c.plant)[order:]))
    real = difference_on_grid(c.plant, cut.plant)
    if real > cut.error_bound:
        return [(0.0, real, 0.0)]
    slowest = float(np.abs(c.plant.poles).min())
    rounding = 1e3 * EPS * float(np.linalg.norm(c.plant.B) * np.linalg.norm(c.plant.C) * np.linalg.norm(c.plant.A)) / slowest**2
    return [(cut.error_bound, max(true, real), rounding)]


def hidden(c: Case) -> Pairs:
    found = structure.observability(c.plant)
    size = max(np.linalg.norm(c.plant.A, 2), np.linalg.norm(c.plant.C, 2))
    true = distance_to_hidden(c.plant, found)
    return [(mode.distance, right, 10 * EPS * float(size)) for mode, right in zip(found.modes, true, strict=True)]


def roll_off(c: Case) -> Pairs:
    speeds = np.abs(c.plant.poles)
    omega = np.geomspace(0.1 * speeds.min(), 1e4 * speeds.max(), 12)
    p = c.plant
    found = systems.frequency_response(p.A, p.B, p.C, p.D, omega)
    true, peak = response(p, omega), 0.0
    peak = np.abs(true).max(axis=0)
    off = np.abs(found - true) / np.maximum(np.abs(true), 1e-12 * peak)
    return [(float(off.max()), 0.0, 1e-6)]


def polynomial(c: Case) -> Pairs:
    """Roots of a product of factors: as many distinct ones as were multiplied, in exact pairs, each a root of what is given."""
    given = np.round(c.poles * 64) / 64
    given = np.where(given == 0, -1.0, given)
    p = np.poly(given).real
    found = design.polynomial_roots(p)
    pairs = np.array_equal(np.sort_complex(found), np.sort_complex(found.conj()))
    back = np.abs(np.poly(found).real - p) / np.poly(-np.abs(found)).real
    told: Pairs = [(float(pairs), 1.0, 0.0), (float(back.max()), 0.0, 100 * EPS)]
    copies = sorted(np.unique(given, return_counts=True)[1])
    if max(copies) > 1:
        told.append((float(sorted(np.unique(found, return_counts=True)[1]) == copies), 1.0, 0.0))
    else:
        true = roots(p)
        size = np.abs(true)
        own = systems.match_poles(true, found)[0]
        told.append((float((np.abs(found[own] - true) / size).max()), 0.0, _merged(true)))
    return told


def _merged(true: np.ndarray) -> float:
    """How far a root may be told from where it is: no further than to the neighbour with which rounding makes it one."""
    apart = np.abs(true[:, None] - true) + np.where(np.eye(len(true)) > 0, np.inf, 0)
    nearest = float((apart.min(axis=1) / np.abs(true)).min()) if len(true) > 1 else np.inf
    return 1e-14 if nearest > 1e-3 else 0.5


def union(c: Case) -> Pairs:
    K = design.lqr(c.plant.A, c.plant.B, np.eye(c.plant.n), np.eye(c.plant.m)).gain
    L = design.lqe(c.plant.A, c.plant.B, c.plant.C, np.eye(c.plant.m), np.eye(c.plant.p)).gain
    found = feedback.closed_loop(c.plant, K, L)
    true = union_gap(found, c.plant, K, L)
    return [(min(found.union_error, true), true, 1e-15)]  # what rounding adds to it is said with it


def diophantine(c: Case) -> Pairs:
    n = c.plant.n
    a, b = np.poly(c.plant.poles).real, c.rng.standard_normal(n)
    asked = np.poly(np.concatenate([c.poles, 2 * c.poles])).real
    found = design.diophantine(a, b, asked)
    from fractions import Fraction as F

    def product(x: np.ndarray, y: np.ndarray) -> list[F]:
        out = [F(0)] * (len(x) + len(y) - 1)
        for i, u in enumerate(x):
            for j, v in enumerate(y):
                out[i + j] += F(float(u)) * F(float(v))
        return out
    parts = (product(a, found.E), product(b, found.F), product(np.abs(a), np.abs(found.E)), product(np.abs(b), np.abs(found.F)))
    size = len(asked)
    ae, bf, ae1, bf1 = ([F(0)] * (size - len(x)) + x for x in parts)
    true = max(float(abs(x + y - F(float(z))) / (x1 + y1 + abs(F(float(z))))) for x, y, x1, y1, z in
               zip(ae, bf, ae1, bf1, asked, strict=True) if x1 + y1 + abs(z))
    return [(found.residual, true, 1e-19)]


LAWS: dict[str, Callable[[Case], Pairs]] = {f.__name__: f for f in (
    placement, observer, regulator, sampled_regulator, estimator, variances_settled, loop_variances, truncation, hidden,
    roll_off, polynomial, union, diophantine)}


ANSWERED = ("placement", "roll_off", "polynomial", "variances_settled")  # laws to which no plant may be refused


def breach(law: str, seed: tuple[int, ...]) -> str:
    """What is said to be better or worse than it is, by more than a factor of ten; nothing if the law holds."""
    case = random_case(np.random.default_rng(seed))
    try:
        told = LAWS[law](case)
    except EngineError as refusal:
        answered = law in ANSWERED and "can move it" not in str(refusal)
        return f"refused: {refusal}" if answered else ""
    for said, true, nothing in told:
        low, high = min(said, true), max(said, true)
        if not (high <= FACTOR * low or high <= nothing):
            return f"says {said:.3g} where it is {true:.3g}"
    return ""


def main(plants: int = 300, seed: int = 1, *laws: str) -> None:
    """Print a row for each law: on how many plants it is broken, and one example."""
    for law in laws or LAWS:
        broken: Counter[str] = Counter()
        example, began = "", time.perf_counter()
        for k in range(plants):
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    wrong = breach(law, (seed, k))
                except Exception as problem:
                    wrong = f"{type(problem).__name__}: {problem}"
            broken[law] += bool(wrong)
            example = example or (f"plant {k}: {wrong}" if wrong else "")
        print(f"{law:18s} {broken[law]:5d} of {plants} in {time.perf_counter() - began:5.0f} s  {example[:120]}", flush=True)


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3]), *sys.argv[3:])
