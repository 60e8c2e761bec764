"""Try a filter with wrong noise assumptions on a record of the true plant."""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from ...design.optimal import DiscreteFilter
from ...design.starting_gains import starting_feedback
from ...simulation.scenario import Run, Scenario
from ...simulation.simulate import simulate
from ...systems.gates.argument_checks import MOST_NUMBERS, SECONDS, SEED, count, covariance, matrix, number, optional, pair, takes, vector
from ...systems.gates.plant_gate import PLANT
from ...systems.noise import root
from ...systems.plant import Plant, as_matrix
from ...systems.records import record
from ..belief import Belief
from ..track import Track
from .kalman import KalmanFilter
from .trade_off import error_parts

__all__ = ["FilterTrial", "simulate_filter"]

START_COVARIANCE_FACTOR = 4.0  # covariance of the start, times that of the settled filter


@record()
class FilterTrial:
    """The sampled plant held by a filter that knows the truth, and beside it the filter on trial.

    `truth`, `filter`: both filters; `steady`: the one on trial after infinitely many steps; `run`, `track`: what happened
    and what it made of it.
    """

    truth: KalmanFilter
    filter: KalmanFilter
    steady: DiscreteFilter
    run: Run
    track: Track

    @cached_property
    def distance(self) -> np.ndarray:
        """Of the gain of each sample from that of the Riccati equation (n_t,), relative."""
        goal = self.steady.filter_gain
        return np.abs(self.track.gains - goal).max(axis=(1, 2)) / max(float(np.abs(goal).max()), 1e-300)

    @cached_property
    def expected(self) -> float:
        """What NIS is on average once all has settled, worked out and not drawn: tr(S⁻¹ (C P Cᵀ + R)), P the true covariance of the
        error. Raises EngineError where that does not settle."""
        truth, held = self.truth, self.run.scenario.plant
        P = error_parts(held, self.steady.gain, np.eye(held.n), truth.Q, truth.R).total
        promised = truth.C @ self.steady.solution @ truth.C.T + self.filter.R
        return float(np.trace(np.linalg.solve(promised, truth.C @ P @ truth.C.T + truth.R)))


@takes(plant=PLANT, G=matrix("n q"), W=covariance("q"), V=covariance("p"), step=SECONDS,
       samples=count(1, MOST_NUMBERS // 8, beside="n n"), believed=pair(number(0), number(0)), seed=SEED,
       kick=optional(pair(number(0, 1_000_000_000.0), vector())))
def simulate_filter(plant: Plant, G: object, W: object, V: object, step: float, samples: int, *,
                    believed: tuple[float, float] = (1.0, 1.0), seed: int = 0,
                    kick: tuple[float, np.ndarray] | None = None) -> FilterTrial:
    """A filter that believes `believed` = (times the true Q, times the true R), on `samples` steps of `step` s.

    G n×q, W q×q and V p×p as in `KalmanFilter.from_plant`; `kick` = (time, jump of the state). The record begins from a
    drawn start, and is held by the estimate of the filter that knows, so that an unstable plant can be watched for long.
    Raises EngineError, RiccatiError where there is no such filter.
    """
    matrices = (as_matrix(M, name) for M, name in ((G, "G"), (W, "W"), (V, "V")))
    truth, K, held = _held(plant, *((M.tobytes(), M.shape) for M in matrices), step)
    doubting = KalmanFilter(truth.A, truth.B, truth.C, believed[0] * truth.Q, believed[1] * truth.R, truth.D, truth.dt)
    P0 = START_COVARIANCE_FACTOR * truth.steady.solution
    P0 = P0 + 1e-12 * np.trace(P0) * np.eye(plant.n)
    x0 = root(P0) @ np.random.default_rng([seed, 11]).standard_normal(plant.n)
    kicks = () if kick is None else ((step * np.ceil(kick[0] / step - 1e-9), kick[1]),)
    run = simulate(Scenario(held, K, truth.steady.gain, x0=x0, xhat0=np.zeros(plant.n), horizon=samples * step, dt=step,
                            W=truth.Q, G=np.eye(plant.n), V=truth.R, seed=seed, impulses=kicks))
    final = doubting.steady
    track = doubting.run(Belief(np.zeros(plant.n), P0), run.y, run.u_applied)
    return FilterTrial(truth, doubting, final, run, track)


Packed = tuple[bytes, tuple[int, ...]]


@lru_cache(maxsize=32)
def _held(plant: Plant, G: Packed, W: Packed, V: Packed, step: float) -> tuple[KalmanFilter, np.ndarray, Plant]:
    """The filter that knows the truth, a gain that holds the sampled plant, and that plant."""
    G_, W_, V_ = (np.frombuffer(data).reshape(shape) for data, shape in (G, W, V))
    truth = KalmanFilter.from_plant(plant, W_, V_, dt=step, G=G_)
    held = Plant(truth.A, truth.B, truth.C, truth.D, step)
    return truth, starting_feedback(held).gain, held
