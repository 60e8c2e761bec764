"""Analyse a functional observer in a loop with a wrong model: errors, worst cases, runs.

All with u = −(N z + M (y − D u)) + v. e_u = K x − (N z + M (y − D u)) is what the estimate adds to the wanted
u = −K x + v; it equals û − K x of the source, where u = +K x.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from scipy.linalg import expm

from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import FUNCTION, SECONDS, SERIES, instance, items, matrix, optional, pair, takes
from ..systems.plant import Plant, as_matrix
from ..systems.records import record
from ..systems.recursions import affine_scan
from ..systems.stability import is_stable
from .functional import FunctionalObserver
from .perturbation import Perturbations

__all__ = ["FunctionalRun", "error_index", "error_transfer", "peak_gain", "perturbed_loop", "simulate_functional",
           "worst_error_gain"]

GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)
DIVERGENCE_LIMIT = 1e12
MAX_STEPS = 1_000_000


@record()
class FunctionalRun:
    """Time-first: t (n_t,), x (n_t, n), z (n_t, q), y (n_t, p), v, u and e_u (n_t, m); `diverged_at` or None."""

    t: np.ndarray
    x: np.ndarray
    z: np.ndarray
    y: np.ndarray
    v: np.ndarray
    u: np.ndarray
    e_u: np.ndarray
    diverged_at: float | None


def _error(value: Any, name: str, shape: tuple[int, int]) -> np.ndarray:
    matrix = np.zeros(shape) if value is None else as_matrix(value, name)
    if matrix.shape != shape:
        raise ShapeError("{name} must be {shape}×{shape2}; it is {rows}×{columns}.",
                         name=name, shape=shape[0], shape2=shape[1], rows=matrix.shape[0], columns=matrix.shape[1])
    return matrix


@takes(observer=instance(FunctionalObserver), dA=optional(matrix()), dB=optional(matrix()), dC=optional(matrix()))
def perturbed_loop(observer: FunctionalObserver, *, dA: Any = None, dB: Any = None, dC: Any = None) -> Plant:
    """The loop of the true plant (A + ΔA, B + ΔB, C + ΔC) and the observer of the model, from v to e_u.

    States (x, z) (n + q), inputs v (m), outputs e_u (m). Raises ShapeError where an error does not fit, or where K
    has not as many rows as the plant has inputs.
    """
    o, p = observer, observer.plant
    if len(o.K) != p.m:
        raise ShapeError("To close the loop K must have {m} rows, one for each input; it has {count}.",
                         m=p.m, count=len(o.K))
    A, B, C = (p.A + _error(dA, "dA", p.A.shape), p.B + _error(dB, "dB", p.B.shape), p.C + _error(dC, "dC", p.C.shape))
    whole = np.block([[A - B @ o.M @ C, -B @ o.N], [o.L @ C - o.TB @ o.M @ C, o.F - o.TB @ o.N]])
    inputs, outputs = (tuple(f"{name}{i + 1}" for i in range(p.m)) for name in ("v", "e_u"))
    return Plant(whole, np.vstack([B, o.TB]), np.hstack([o.K - o.M @ C, -o.N]), dt=p.dt, input_names=inputs,
                 output_names=outputs, name=f"{p.name} with functional observer".strip())


@takes(observer=instance(FunctionalObserver), omega=SERIES, dA=optional(matrix()), dC=optional(matrix()))
def error_transfer(observer: FunctionalObserver, omega: Any, *, dA: Any = None, dC: Any = None) -> np.ndarray:
    """N (jωI − F)⁻¹ Δ₁ + Δ₂ with Δ₁ = L ΔC − T ΔA, Δ₂ = M ΔC: from x to the error of the estimate (n_ω, r, n).

    Unlike J it does not depend on the observer's coordinates and sees N. ω in rad/s.

    >>> o = functional_observer(Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]), [[1, 1]], 1, poles=[-5])
    >>> bool(error_transfer(o, [1.0], dA=np.zeros((2, 2))).any())  # a model without error
    False
    """
    D1, D2 = _defects(observer, dA, dC)
    s = _points(observer.plant, np.atleast_1d(np.asarray(omega, dtype=float)))
    q = observer.order
    return observer.N @ np.linalg.solve(s[:, None, None] * np.eye(q) - observer.F, D1 + np.zeros((s.size, 1, 1))) + D2


def _defects(observer: FunctionalObserver, dA: Any, dC: Any) -> tuple[np.ndarray, np.ndarray]:
    dA, dC = _error(dA, "dA", observer.plant.A.shape), _error(dC, "dC", observer.plant.C.shape)
    return observer.L @ dC - observer.T @ dA, observer.M @ dC


def _points(plant: Plant, omega: np.ndarray) -> np.ndarray:
    return np.exp(1j * omega * plant.dt) if plant.dt else 1j * omega


@takes(observer=instance(FunctionalObserver), wrong=instance(Perturbations))
def error_index(observer: FunctionalObserver, *, wrong: Perturbations | None = None) -> float:
    """Σ αᵢ ‖N(sI − F)⁻¹ T Aᵢ‖_∞ + Σ βᵢ ‖N(sI − F)⁻¹ L Cᵢ + M Cᵢ‖_∞: bounds ‖N(sI − F)⁻¹Δ₁ + Δ₂‖_∞ for |δᵢ| ≤ αᵢ, βᵢ.

    The better index beside J: unchanged by W and by the scale of gᵢ, and large where N is. `wrong`: default that of the
    observer. Raises EngineError for a sampled plant.
    """
    _continuous(observer)
    o, w = observer, observer.wrong if wrong is None else wrong
    nothing = np.zeros((len(o.K), o.plant.n))
    parts = [a * peak_gain(o.F, o.T @ d, o.N, nothing)[0] for a, d in zip(w.alpha, w.A, strict=True) if a]
    parts += [b * peak_gain(o.F, o.L @ d, o.N, o.M @ d)[0] for b, d in zip(w.beta, w.C, strict=True) if b]
    return float(sum(parts))


def _continuous(observer: FunctionalObserver) -> None:
    if observer.plant.dt:
        raise EngineError("This index is for continuous plants; judge a sampled one by its runs.")


@takes(observer=instance(FunctionalObserver), errors=items(pair(matrix(), matrix()), 1_000_000))
def worst_error_gain(observer: FunctionalObserver, errors: Iterable[tuple[np.ndarray, np.ndarray]]) -> float:
    """Largest ‖v → e_u‖_∞ over the true plants (ΔA, ΔC), infinite where one of their loops is unstable.

    Raises EngineError for a sampled plant.
    """
    _continuous(observer)
    worst = 0.0
    for dA, dC in errors:
        loop = perturbed_loop(observer, dA=dA, dC=dC)
        worst = max(worst, peak_gain(loop.A, loop.B, loop.C, np.asarray(loop.D))[0])
    return worst


@takes(A=matrix("n n"), B=matrix("n m"), C=matrix("p n"), D=matrix("p m"))
def peak_gain(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray) -> tuple[float, float]:
    """(‖C(sI − A)⁻¹B + D‖_∞, the ω where it is reached, maybe ∞) in continuous time; (∞, ω) where A is not stable.

    The level is raised to the gain between the frequencies at which a Hamiltonian matrix has imaginary eigenvalues,
    until there are none 1e-10 higher. Source: Bruinsma and Steinbuch (1990).
    """
    poles = np.linalg.eigvals(A)
    if not is_stable(A):
        return np.inf, float(np.abs(poles[np.argmax(poles.real)].imag))

    def gain(omega: float) -> float:
        return float(np.linalg.norm(C @ np.linalg.solve(1j * omega * np.eye(len(A)) - A, B) + D, 2))

    level, at = max([(float(np.linalg.norm(D, 2)), np.inf), (gain(0.0), 0.0),
                     *((gain(w), w) for w in map(float, np.abs(poles)))])
    for _ in range(60):
        g = (1 + 1e-10) * level
        if g == 0:
            break
        R: np.ndarray = g * g * np.eye(D.shape[1]) - D.T @ D
        X: np.ndarray = A + B @ np.linalg.solve(R, D.T @ C)
        H: np.ndarray = np.block([[X, g * B @ np.linalg.solve(R, B.T)],
                                  [-g * C.T @ np.linalg.solve(g * g * np.eye(len(D)) - D @ D.T, C), -X.T]])
        values = np.linalg.eigvals(H)
        crossings = np.unique(np.abs(values.imag[np.abs(values.real) <= 1e-8 * np.maximum(np.abs(values), 1e-300)]))
        if crossings.size < 1:
            break
        ends = np.append(0.0, crossings)  # a crossing at 0 is a double eigenvalue, which rounding may turn off the axis
        middles = np.concatenate([crossings, (ends[1:] + ends[:-1]) / 2])
        best, where = max((gain(float(w)), float(w)) for w in middles)
        if not best > level * (1 + 1e-10):
            break
        level, at = best, where
    return level, at


@takes(observer=instance(FunctionalObserver), v=optional(FUNCTION), x0=optional(matrix()), z0=optional(matrix()),
       horizon=SECONDS, dt=SECONDS, dA=optional(matrix()), dB=optional(matrix()), dC=optional(matrix()))
def simulate_functional(observer: FunctionalObserver, v: Callable[[np.ndarray], Any] | None, *, x0: Any = None,
                   z0: Any = None, horizon: float = 6.0, dt: float = 0.01, dA: Any = None, dB: Any = None,
                   dC: Any = None) -> FunctionalRun:
    """Run the perturbed loop from x(0) (n,), z(0) (q,) under v(t).

    `v` maps times (k,) to (k,) for one input or to (k, m); None: zero. Matrix exponentials between grid points, the
    input by Gauss–Legendre quadrature of five nodes within each step: exact to rounding where v is smooth over a step.
    A plant with dt > 0 runs on its own period. Cut off where a state passes 1e12.
    Raises ShapeError and EngineError for shapes, grids and inputs that do not fit.

    >>> plant = Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    >>> o = functional_observer(plant, [[1, 1]], 1, poles=[-5])
    >>> run = simulate_functional(o, None, x0=[1, 0], horizon=4.0)
    >>> bool(abs(run.e_u[-1, 0]) < 1e-6)
    True
    """
    o, p = observer, observer.plant
    loop = perturbed_loop(o, dA=dA, dB=dB, dC=dC)
    dt = p.dt or float(dt)
    if not (dt <= horizon and horizon / dt <= MAX_STEPS):
        raise EngineError("The horizon must be positive and hold between 1 and {most_steps} steps dt.",
                          most_steps=MAX_STEPS)
    start = np.concatenate([_start(x0, "x0", p.n), _start(z0, "z0", o.order)])
    t = np.arange(round(horizon / dt) + 1) * dt
    Phi: np.ndarray
    forcing: np.ndarray
    if p.dt:
        Phi, forcing = loop.A, _input(v, t[:-1], p.m) @ loop.B.T
    else:
        nodes = (GAUSS_NODES + 1) / 2
        powers: np.ndarray = expm(np.append(1.0, 1 - nodes)[:, None, None] * dt * loop.A)
        Phi, ways = powers[0], (GAUSS_WEIGHTS / 2 * dt)[:, None, None] * powers[1:] @ loop.B
        given = np.hstack([_input(v, t[:-1] + node * dt, p.m) for node in nodes])
        forcing = given @ np.swapaxes(ways, 1, 2).reshape(-1, start.size)
    states = affine_scan(Phi, None if v is None else forcing, start, t.size - 1)
    with np.errstate(invalid="ignore"):
        fine = np.abs(states).max(axis=1) < DIVERGENCE_LIMIT
    count = t.size if fine.all() else max(1, int(np.argmin(fine)))
    x, z, given = states[:count, :p.n], states[:count, p.n:], _input(v, t[:count], p.m)
    seen = x @ (p.C + _error(dC, "dC", p.C.shape)).T
    u = given - z @ o.N.T - seen @ o.M.T
    return FunctionalRun(t[:count], x, z, seen + u @ np.asarray(p.D).T, given, u, states[:count] @ loop.C.T,
                         None if count == t.size else float(t[count]))


def _start(value: Any, name: str, length: int) -> np.ndarray:
    start = np.zeros(length) if value is None else as_matrix(value, name).ravel()
    if start.size != length:
        raise ShapeError("{name} must have {length} entries; it has {start_size}.",
                         name=name, length=length, start_size=start.size)
    return start


def _input(v: Callable[[np.ndarray], Any] | None, t: np.ndarray, m: int) -> np.ndarray:
    values = np.zeros((t.size, m)) if v is None else np.asarray(v(t), dtype=float)
    values = values[:, None] if values.shape == t.shape else values
    try:
        values = np.array(np.broadcast_to(values, (t.size, m)))
    except ValueError as problem:
        raise ShapeError("v(t) must give {m} numbers for each time.", m=m) from problem
    if not np.isfinite(values).all():
        raise EngineError("The input v(t) must be a finite number at all times of the run.")
    return values
