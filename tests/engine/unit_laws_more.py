"""More laws of units, as in `unit_laws`: equations, references, records, runs, densities."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from unit_cases import Case, Units
from unit_laws import _L, _P, LAWS, Answer, _correlated, _map, _rate

from observer_lab.engine import (
    Belief,
    KalmanFilter,
    Plant,
    Scenario,
    dlyap,
    feedback,
    filters,
    lyap,
    observers,
    simulate,
    structure,
    systems,
)
from observer_lab.engine.design import dlqe, dlqr, lqe, lqr
from observer_lab.engine.feedback import integral_action, reference_gain
from observer_lab.engine.systems import continuous_of, discretise, settled_covariance, stable_poles, step_covariance


def _gain(c: Case) -> np.ndarray:
    return (dlqr if c.plant.dt else lqr)(c.plant.A, c.plant.B, c.Q, c.R).gain


def _stable(c: Case) -> np.ndarray:
    """A − BK of the optimal loop."""
    return c.plant.A - c.plant.B @ _gain(c)


def lyapunov(c: Case, z: Units) -> Answer:
    noise = c.G @ c.W @ c.G.T
    return {"X": _correlated(_P((dlyap if c.plant.dt else lyap)(_stable(c), (noise + noise.T) / 2), z))}


def settled(c: Case, z: Units) -> Answer:
    return {"P": _correlated(_P(settled_covariance(_stable(c), c.G @ np.linalg.cholesky(c.W), dt=c.plant.dt), z))}


def step_noise(c: Case, z: Units) -> Answer:
    if c.plant.dt:
        return {}
    return {"Q": _correlated(_P(step_covariance(c.plant.A, c.G @ c.W @ c.G.T, 0.3 / z.tau), z))}


def judged(c: Case, z: Units) -> Answer:
    poles, stable = stable_poles(c.plant.A, dt=c.plant.dt)
    return {"stable": int(stable.sum()), "poles": np.poly(poles / _rate(c, z)), "loop": systems.is_stable(_stable(c), dt=c.plant.dt)}


def _square(c: Case) -> Plant:
    """With as many outputs as inputs."""
    k, p = min(c.plant.m, c.plant.p), c.plant
    return Plant(p.A, p.B[:, :k], p.C[:k], np.asarray(p.D)[:k, :k], p.dt)


def _followed(c: Case) -> tuple[Plant, np.ndarray]:
    p = _square(c)
    return p, (dlqr if p.dt else lqr)(p.A, p.B, c.Q, c.R[:p.m, :p.m]).gain


def reference(c: Case, z: Units) -> Answer:
    p, K = _followed(c)
    return {"N": reference_gain(p, K) * z.U[:p.m, None] / z.Y[:p.p]}


def integral(c: Case, z: Units) -> Answer:
    if c.plant.dt:
        return {}
    p, K = _followed(c)
    found = integral_action(p, K, 0.2 * z.tau)
    return {"K_I": found.K_I * z.U[:p.m, None] / z.Y[:p.p] / z.tau}


def _filter(c: Case) -> KalmanFilter:
    p = c.plant
    return KalmanFilter(p.A, p.B, p.C, c.G @ c.W @ c.G.T, c.V, D=p.D, dt=p.dt)


def _record(c: Case, z: Units) -> tuple[KalmanFilter, Belief, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    y, u = rng.standard_normal((12, c.plant.p)) / z.Y, rng.standard_normal((12, c.plant.m)) / z.U
    return _filter(c), Belief(np.zeros(c.plant.n), np.linalg.inv(c.Q)), y, u


def filtered(c: Case, z: Units) -> Answer:
    if not c.plant.dt:
        return {}
    model, start, y, u = _record(c, z)
    track = model.run(start, y, u)
    return {"means": track.means * z.X, "P": np.array([_correlated(_P(P, z)) for P in track.covariances]),
            "innovations": track.innovations * z.Y}


def smoothed(c: Case, z: Units) -> Answer:
    if not c.plant.dt:
        return {}
    model, start, y, u = _record(c, z)
    found = filters.smooth(model, model.run(start, y, u))
    return {"means": found.means * z.X, "P": np.array([_correlated(_P(P, z)) for P in found.covariances])}


def horizon(c: Case, z: Units) -> Answer:
    if not c.plant.dt:
        return {}
    model, start, y, u = _record(c, z)
    found = filters.moving_horizon(model, y, u=u, start=start, lower=-0.3 / z.X, horizon=4)
    return {"means": found.means * z.X}


def robust(c: Case, z: Units) -> Answer:
    if c.plant.dt:
        return {}
    found = filters.h_infinity(c.plant.A, c.G, c.plant.C, c.W, c.V, gamma=100.0 / np.sqrt(z.tau), Z=np.diag(z.X))
    return {"L": _L(c, found.gain, z), "P": _correlated(_P(found.solution, z))}


def reduced(c: Case, z: Units) -> Answer:
    if c.plant.p >= c.plant.n or not structure.observability(c.plant).observable:
        return {}
    found = observers.reduced_observer(c.plant, _real(c, z, c.plant.n - c.plant.p))
    return {"poles": np.poly(np.linalg.eigvals(found.F) / _rate(c, z)), "N": found.N * z.X[:, None] / z.Y if c.plant.p == 1 else 0}


def _real(c: Case, z: Units, count: int) -> np.ndarray:
    rates = np.linspace(3, 5, count)
    return np.exp(-0.1 * rates) if c.plant.dt else -rates * z.tau


def _closed(c: Case) -> Plant:
    return feedback.compensator(c.plant, _gain(c), _lqe(c))


def density(c: Case, z: Units) -> Answer:
    loop = feedback.noisy_loop(c.plant, _closed(c), c.G, c.W, V=c.V)
    S = loop.psd(np.array([0.03, 0.3]) * z.tau, loop.outputs()) * z.tau * z.Y**2
    return {"S": np.log(S), "variance": np.log(loop.covariance.diagonal()[:c.plant.n] * z.X**2)}


def _lqe(c: Case) -> np.ndarray:
    return (dlqe if c.plant.dt else lqe)(c.plant.A, c.G, c.plant.C, c.W, c.V).gain


def sensitive(c: Case, z: Units) -> Answer:
    found, units = feedback.sensitivity(c.plant, _closed(c)), np.concatenate([z.U, z.Y])
    return {"stable": found.stable, "S": found.at(np.array([0.1, 1.0]) * z.tau) * units[:, None] / units}


def sampling(c: Case, z: Units) -> Answer:
    if c.plant.dt:
        back = continuous_of(c.plant)
        return {"H": _map(systems.frequency_response(back.A, back.B, back.C, back.D, np.array([0.1, 1.0]) * 0.1 / c.plant.dt), z)}
    d = discretise(c.plant, 0.2 / z.tau)
    return {"A": d.A * z.X[:, None] / z.X, "B": d.B * z.X[:, None] / z.U}


def run(c: Case, z: Units) -> Answer:
    dt = c.plant.dt or 0.01 / z.tau
    found = simulate(Scenario(c.plant, _gain(c), _lqe(c), x0=1 / z.X, horizon=40 * dt, dt=dt))
    return {"x": found.x * z.X, "e": found.e * z.X, "u": found.u_applied * z.U}


def finite_seen(c: Case, z: Units) -> Answer:
    p = c.plant
    W = structure.observability_gramian(Plant(p.A, p.B, p.C * z.Y[:, None], dt=p.dt), c.horizon)
    return {"W": _correlated(W / np.outer(z.X, z.X) * _rate(c, z))}


MORE: dict[str, Callable[[Case, Units], Answer]] = {f.__name__: f for f in (
    lyapunov, settled, step_noise, judged, reference, integral, filtered, smoothed, horizon, robust, reduced, density, sensitive, sampling,
    run, finite_seen)}
ALL = {**LAWS, **MORE}
