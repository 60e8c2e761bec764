"""The table of laws of units: what every public call must answer in any units, told back in those of a random plant.

A change of units is x = X x′, u = U u′, y = Y y′, w = E w′, t = τ t′ with diagonal X, U, Y, E. Each law here takes a plant in
some units, asks the engine, and brings the answer back to the plant's own units: there it must be the same.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from unit_cases import Case, Units, ones

from observer_lab.engine import Plant, design, feedback, filters, observers, structure, systems
from observer_lab.engine import sampled as sampled_room
from observer_lab.engine.filters import error_parts, noise_ladder
from observer_lab.engine.structure import split_stable
from observer_lab.engine.systems import all_stable, transmission_zeros

Answer = dict[str, object]


# --- laws: the answer in the plant's own units ---------------------------------------------------------------------
def _rate(c: Case, z: Units) -> float:
    return 1.0 if c.plant.dt else z.tau


def _K(K: np.ndarray, z: Units) -> np.ndarray:
    return K * z.U[:, None] / z.X


def _L(c: Case, L: np.ndarray, z: Units) -> np.ndarray:
    return L * z.X[:, None] / z.Y / _rate(c, z)


def _P(P: np.ndarray, z: Units) -> np.ndarray:
    return P * np.outer(z.X, z.X)


def _map(H: np.ndarray, z: Units) -> np.ndarray:
    return H * z.Y[:, None] / z.U


def _correlated(P: np.ndarray) -> np.ndarray:
    """Variances as they are, covariances beside them: every entry told to the digits of its own units."""
    variance = np.maximum(np.diag(P), 1e-300)
    return np.where(np.eye(len(P)) > 0, np.log(variance), P / np.sqrt(variance) / np.sqrt(variance)[:, None])


def lqr(c: Case, z: Units) -> Answer:
    found = (design.dlqr if c.plant.dt else design.lqr)(c.plant.A, c.plant.B, c.Q, c.R)
    S = found.solution / np.outer(z.X, z.X) * _rate(c, z)
    return {"K": _K(found.gain, z), "S": _correlated(S), "poles": np.poly(found.poles / _rate(c, z))}


def lqe(c: Case, z: Units) -> Answer:
    found = (design.dlqe if c.plant.dt else design.lqe)(c.plant.A, c.G, c.plant.C, c.W, c.V)
    return {"L": _L(c, found.gain, z), "P": _correlated(_P(found.solution, z)), "poles": np.poly(found.poles / _rate(c, z))}


def place(c: Case, z: Units) -> Answer:
    found = design.place(c.plant.A, c.plant.B, c.slow)
    # of several inputs, which of the gains that reach the poles is best conditioned depends on units
    return {"K": _K(found.gain, z) if c.plant.m == 1 else np.zeros(0), "fixed": len(found.fixed),
            "met": found.error < 1e-3 * np.abs(found.asked).max()}


def observer_gain(c: Case, z: Units) -> Answer:
    found = design.observer_gain(c.plant.A, c.plant.C, c.quick)
    return {"L": _L(c, found.gain, z) if c.plant.p == 1 else np.zeros(0), "met": found.error < 1e-3 * np.abs(found.asked).max()}


def observability(c: Case, z: Units) -> Answer:
    found, dual = structure.observability(c.plant), structure.controllability(c.plant)
    return {"rank": (found.rank, dual.rank), "detectable": found.detectable, "stabilizable": dual.stabilizable}


def decomposition(c: Case, z: Units) -> Answer:
    found = structure.kalman_decomposition(c.plant)
    return {"sizes": found.sizes, "minimal": np.poly(found.minimal.poles / _rate(c, z)) if found.minimal.n else np.ones(1)}


def gramians(c: Case, z: Units) -> Answer:
    found = structure.gramians(c.plant)
    rate = _rate(c, z)
    Wc = structure.gramians(Plant(c.plant.A, c.plant.B / z.U, c.plant.C, dt=c.plant.dt)).controllability
    Wo = structure.gramians(Plant(c.plant.A, c.plant.B, c.plant.C * z.Y[:, None], dt=c.plant.dt)).observability
    assert np.all(np.diag(found.controllability) >= 0)
    return {"Wc": _correlated(_P(Wc, z) / rate), "Wo": _correlated(Wo / np.outer(z.X, z.X) * rate)}


def _unit_channels(c: Case, z: Units) -> Plant:
    """The plant with the inputs and outputs of the reference, states and time in units: Hankel values mean those."""
    p = c.plant
    return Plant(p.A, p.B / z.U, p.C * z.Y[:, None], np.asarray(p.D) * z.Y[:, None] / z.U, p.dt)


def hankel(c: Case, z: Units) -> Answer:
    return {"values": structure.hankel_singular_values(_unit_channels(c, z))}


def _response(p: Plant, z: Units, rate: float) -> np.ndarray:
    omega = np.array([0.0, 0.1, 1.0, 7.0]) * rate if not p.dt else np.array([0.0, 0.3, 1.0, 2.0]) / p.dt
    return systems.frequency_response(p.A, p.B, p.C, p.D, omega, dt=p.dt)


def truncation(c: Case, z: Units) -> Answer:
    plant = _unit_channels(c, z)
    kept = split_stable(plant).unstable.n
    cut = structure.balanced_truncation(plant, min(plant.n, kept + 1))
    tail = 2 * float(cut.hankel[min(plant.n, kept + 1) - cut.kept:].sum())
    assert tail <= cut.error_bound  # what rounding may add to it is told to a digit only
    return {"response": _response(cut.plant, z, _rate(c, z)), "bound": tail, "kept": cut.kept}


def splitting(c: Case, z: Units) -> Answer:
    parts = split_stable(c.plant)
    rate = _rate(c, z)
    return {"count": (parts.stable.n, parts.unstable.n), "stable": _map(_response(parts.stable, z, rate), z),
            "unstable": _map(_response(parts.unstable, z, rate), z)}


def zeros(c: Case, z: Units) -> Answer:
    k = min(c.plant.m, c.plant.p)
    p = c.plant
    found = transmission_zeros(Plant(p.A, p.B[:, :k], p.C[:k], np.asarray(p.D)[:k, :k], p.dt))
    assert found is not None
    found = found / _rate(c, z)
    return {"count": len(found), "zeros": np.poly(found) / max(1.0, float(np.abs(np.poly(found)).max())),
            "minimum phase": int(np.sum(np.real(found) > 0))}


def noise(c: Case, z: Units) -> Answer:
    L = (design.dlqe if c.plant.dt else design.lqe)(c.plant.A, c.G, c.plant.C, c.W, c.V).gain
    parts = error_parts(c.plant, L, c.G, c.W, c.V)
    assert all(np.all(np.diag(P) >= 0) for P in (parts.process, parts.sensor))
    return {"process": _correlated(_P(parts.process, z)), "sensor": _correlated(_P(parts.sensor, z))}


def ladder(c: Case, z: Units) -> Answer:
    found = noise_ladder(c.plant, c.G, c.W, c.V, np.array([0.1, 1.0, 10.0]))
    totals = np.array([np.diag(_P(part.total, z)) for part in found.parts])
    assert np.all(totals >= totals[1] * (1 - 1e-7)), "a filter beats the best one"
    return {"totals": np.log(totals)}


def decoupling(c: Case, z: Units) -> Answer:
    found = observers.decoupling(c.plant, c.G)
    poly = np.zeros(0) if found.zeros is None else np.poly(found.zeros / _rate(c, z))
    return {"exists": found.exists, "ranks": (found.rank_CE, found.rank_E), "zeros": poly}


def unknown_input(c: Case, z: Units) -> Answer:
    known = observers.decoupling(c.plant, c.G)
    if not known.exists or known.zeros is None:
        return {"exists": False}
    free = [p for p in c.quick if p.imag == 0][:c.plant.n - len(known.zeros)]
    while len(free) < c.plant.n - len(known.zeros):
        free.append(free[-1] * 0.9 if free else c.quick.real.min())
    found = observers.unknown_input_observer(c.plant, c.G, free)
    return {"poles": np.poly(found.poles / _rate(c, z)),
            "misses": max(_told(found.residuals(c.plant, c.G))) < 1e-6}


def _told(values: tuple[float, ...]) -> tuple[float, ...]:
    return values


def dominance(c: Case, z: Units) -> Answer:
    p, k = c.plant, min(c.plant.m, c.plant.p)
    square = Plant(p.A, p.B[:, :k], p.C[:k], np.asarray(p.D)[:k, :k], p.dt)
    omega = np.array([0.1, 1.0]) * z.tau
    found = structure.dominance(square, omega)
    return {"scaled": found.scaled, "relative gains": found.relative_gains}


def lqg(c: Case, z: Units) -> Answer:
    if c.plant.dt:
        return {}
    found = feedback.lqg(c.plant, c.Q, c.R, c.W, c.V, G=c.G)
    loop = feedback.noisy_loop(c.plant, found.controller, c.G, c.W, V=c.V)
    real = sum(loop.cost(c.Q, c.R))
    least = found.cost
    assert real >= least * (1 - 1e-7), f"costs {real:.9g}, below the least {least:.9g}"
    return {"cost": np.array([np.log(least), np.log(real)])}


def closed_loop(c: Case, z: Units) -> Answer:
    K = (design.dlqr if c.plant.dt else design.lqr)(c.plant.A, c.plant.B, c.Q, c.R).gain
    L = (design.dlqe if c.plant.dt else design.lqe)(c.plant.A, c.G, c.plant.C, c.W, c.V).gain
    found = feedback.closed_loop(c.plant, K, L)
    return {"stable": found.stable, "union": found.union_error < 1e-6, "poles": np.poly(found.poles / _rate(c, z))}


def margins(c: Case, z: Units) -> Answer:
    if c.plant.dt:
        return {}
    K = design.lqr(c.plant.A, c.plant.B, c.Q, c.R).gain
    L = design.lqe(c.plant.A, c.G, c.plant.C, c.W, c.V).gain
    found = feedback.loop_margins(c.plant, feedback.compensator(c.plant, K, L))
    channels = (*found.inputs, *found.outputs)
    return {"stable": found.stable, "nearest": np.array([m.nearest for m in channels]), "phase": np.array([m.phase for m in channels]),
            "delay": np.array([np.tanh(m.delay * z.tau) for m in channels])}


def response(c: Case, z: Units) -> Answer:
    return {"H": _map(_response(c.plant, z, _rate(c, z)), z)}


def transfer(c: Case, z: Units) -> Answer:
    found = feedback.to_tf(c.plant)
    scale = _rate(c, z) ** np.arange(c.plant.n + 1)
    return {"den": found.den / scale, "num": found.num / scale * z.Y[:, None, None] / z.U[:, None]}


def coprime(c: Case, z: Units) -> Answer:
    found = structure.coprime_factors(c.plant)
    return {"indices": found.indices}


def finite_gramian(c: Case, z: Units) -> Answer:
    p = c.plant
    W = structure.reachability_gramian(Plant(p.A, p.B / z.U, p.C, dt=p.dt), c.horizon)
    return {"W": _correlated(_P(W, z) / _rate(c, z))}


def starting(c: Case, z: Units) -> Answer:
    K, L = design.starting_feedback(c.plant), design.starting_observer(c.plant)
    return {"bolted": (len(K.bolted), len(L.bolted)), "stable": [all_stable(g.moved, dt=c.plant.dt) for g in (K, L)]}


def filtering(c: Case, z: Units) -> Answer:
    if not c.plant.dt:
        return {}
    steady = filters.KalmanFilter.from_plant(c.plant, c.W, c.V, G=c.G).steady
    return {"P": _correlated(_P(steady.filtered, z))}


def least(c: Case, z: Units) -> Answer:
    if not c.plant.dt:
        return {}
    spread, slopes = np.linalg.inv(c.Q), np.array([[0.9 * c.plant.A, 1.1 * c.plant.A]] * 6)
    seen = np.array([[c.plant.C] * 2] * 7)
    return {kind: _correlated(_P(filters.posterior_bound(slopes, seen, spread, c.V, spread, unknown=kind)[-1], z))
            for kind in ("states", "noise")}


def functional(c: Case, z: Units) -> Answer:
    if c.plant.dt or not structure.observability(c.plant).observable:
        return {}
    K = design.lqr(c.plant.A, c.plant.B, c.Q, c.R).gain[:1]
    found = observers.functional_observer(c.plant, K, c.plant.n - c.plant.p)
    reach = observers.existence(c.plant, K, found.poles)
    return {"poles": len(found.poles), "met": found.output_residual < 1e-6, "ranks": [reach.rank, reach.with_K, reach.free]}


def sampled(c: Case, z: Units) -> Answer:
    if c.plant.dt:
        return {}
    found = sampled_room.sampled_lqg(c.plant, c.Q, c.R, c.W, c.V, 0.05 / z.tau, G=c.G)
    return {"K": _K(found.K, z), "P": _correlated(_P(found.filter.steady.solution, z))}


LAWS: dict[str, Callable[[Case, Units], Answer]] = {f.__name__: f for f in (
    lqr, lqe, place, observer_gain, observability, decomposition, gramians, hankel, truncation, splitting, zeros, noise,
    ladder, decoupling, unknown_input, dominance, lqg, closed_loop, margins, response, transfer, coprime, finite_gramian,
    starting, filtering, least, functional, sampled)}

TOLERANCE = 1e-5  # of an answer beside its largest entry


def breach(law: str, case: Case, units: Units, tolerance: float = TOLERANCE) -> str:
    """What a plant in other units is told differently, nothing if the law holds; raises what the engine should not."""
    own = _asked(law, case, ones(case))
    other = _asked(law, case.to(units), units)
    if isinstance(own, str) or isinstance(other, str):
        if isinstance(own, str) and isinstance(other, str):
            return ""
        return f"{law}: {'refused' if isinstance(other, str) else 'answered'} in other units: {own if isinstance(own, str) else other}"
    for key, value in own.items():
        difference = _difference(value, other[key])
        if difference > tolerance:
            return f"{law}: {key} differs by {difference:.1e}"
    return ""


def _asked(law: str, case: Case, units: Units, laws: dict[str, Callable[[Case, Units], Answer]] = LAWS) -> Answer | str:
    try:
        return laws[law](case, units)
    except systems.EngineError as refusal:
        return str(refusal)


def _difference(a: object, b: object) -> float:
    first, second = np.asarray(a, dtype=complex), np.asarray(b, dtype=complex)
    if first.shape != second.shape:
        return np.inf
    size = float(np.abs(first).max(initial=0.0)) or 1.0
    gap = float(np.abs(first - second).max(initial=0.0)) / size
    return gap if np.isfinite(gap) else np.inf
