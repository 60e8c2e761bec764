"""Simulate the sampled loop over a network with lost, late or reordered packets.

x[k+1] = A x + B a + w, y = C x + v; u = −K x̂ with x̂ = x̂[k | all that arrived by k]; a is what the actuator applies.
"""

from __future__ import annotations

from dataclasses import field
from typing import Any, Literal

import numpy as np

from ..systems.arrays import as_covariance, symmetric
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import SEED, array, choice, count, covariance, instance, matrix, optional, passed, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.noise import root
from ..systems.plant import Plant, as_matrix
from ..systems.records import record
from .intermittent import corrected_covariance, riccati_path
from .packets import LOST_PACKET, Link, newest_packet_age

__all__ = ["NetworkRun", "NetworkScenario", "network_meter", "promised_error", "simulate_network"]

STATE_ROUNDING = 1e-12
DIVERGENCE_FACTOR = 1e9  # times the larger of 1 and the size of the start


@record()
class NetworkScenario:
    """One run of the loop over two links, N = `steps` samples.

    `plant` is sampled (dt > 0, D = 0). K: m×n. Q (n×n), R (p×p): covariances of w and v of a sample. x(0) = x0, and
    x̂[0|−1] is x0 less an error drawn from P0. `sensor`, `actuator`: the two links. `on_loss`: what the actuator applies
    where no packet arrives, the last input or zero. `told`: the input that the observer counts with, the one asked for
    ("asked") or the one that the actuator applies ("applied", acknowledged at once). `order`: whether measurements
    carry the time they were taken ("stamped": the filter goes back and takes each in at its place, which is optimal)
    or are taken for fresh ("arrival"). `ahead`: the controller predicts the state this many samples on, with the
    inputs asked for that are still under way. `jumps` (N, n) are added to x between samples, unknown to the observer.
    Streams of noise, of losses on each link and of the start come from `seed` separately.

    >>> plant = Plant([[1.1]], [[1]], [[1]], dt=1.0)
    >>> NetworkScenario(plant, [[0.5]], [[1]], [[1]], [[1]], [0.0], 20, Link(loss=0.2)).steps
    20
    """

    plant: Plant
    K: Any
    Q: Any
    R: Any
    P0: Any
    x0: Any
    steps: int
    sensor: Link = field(default_factory=Link)
    actuator: Link = field(default_factory=Link)
    on_loss: Literal["hold", "zero"] = "hold"
    told: Literal["asked", "applied"] = "applied"
    order: Literal["stamped", "arrival"] = "stamped"
    ahead: int = 0
    jumps: Any = None
    seed: int = 0

    def __post_init__(self) -> None:
        passed(self, plant=PLANT, K=matrix(), Q=covariance("n"), R=covariance("p"), P0=covariance("n"), x0=matrix(),
               steps=count(1, 1_000_000, beside="n n"), sensor=instance(Link), actuator=instance(Link), on_loss=choice("hold", "zero"),
               told=choice("asked", "applied"), order=choice("stamped", "arrival"), ahead=count(), jumps=optional(matrix()), seed=SEED)
        plant = self.plant
        if not plant.dt or np.any(plant.D):
            raise EngineError("A loop over packets needs a sampled plant (dt > 0) without direct feedthrough D.")
        if self.ahead > self.actuator.latest:
            raise EngineError("The controller cannot predict farther than the delay, where no input asked for is "
                              "under way; predict less far.")
        n, m = plant.n, plant.m
        K = as_matrix(self.K, "K")
        x0 = as_matrix(self.x0, "x0").ravel()
        jumps = np.zeros((self.steps, n)) if self.jumps is None else as_matrix(self.jumps, "jumps")
        if K.shape != (m, n) or x0.shape != (n,) or jumps.shape != (self.steps, n):
            raise ShapeError("K must be {m}×{n}, x0 must have {n} entries, jumps must be {steps}×{n}.",
                             m=m, n=n, steps=self.steps)
        values = {"K": K, "x0": x0, "jumps": jumps, "Q": as_covariance(self.Q, "Q", n),
                  "R": as_covariance(self.R, "R", plant.p), "P0": as_covariance(self.P0, "P0", n)}
        for name, value in values.items():
            object.__setattr__(self, name, value)


@record()
class FilterPlan:
    """What a filter does at each k: it starts `window` samples back and takes in `heard[k, i]` with gain `gains[k, i]`.

    source[k, i]: which measurement is taken in there. P (N, n, n): its covariance after the last of them.
    """

    window: int
    heard: np.ndarray
    source: np.ndarray
    gains: np.ndarray
    P: np.ndarray


@record()
class Draw:
    """What the seed gives: x(0) − x̂(0) (n,), w with the jumps (N, n), v (N, p), samples of arrival (N,) on both links."""

    e0: np.ndarray
    w: np.ndarray
    v: np.ndarray
    sensed: np.ndarray
    acted: np.ndarray


@record()
class NetworkRun:
    """A run; arrays are time-first over N samples (fewer where it diverged).

    x, xhat = x̂[k | arrived by k], e = x − x̂ (N, n); u_asked, u_applied (N, m); y (N, p) as sent. P (N, n, n): the
    covariance of x[k] − x̂[k | arrived by k] as the filter believes it, prior (N, n, n): that one step ahead.
    sensed, acted (N,): sample of arrival of each packet, −1 if lost; sensor_age, actuator_age (N,): how many samples
    old the newest packet is that has arrived (k + 1 where none has). fresh (N,): whether the actuator got a packet.
    plan, draw: what the filter does at each sample, and what the seed gave.
    """

    scenario: NetworkScenario
    t: np.ndarray
    x: np.ndarray
    xhat: np.ndarray
    e: np.ndarray
    u_asked: np.ndarray
    u_applied: np.ndarray
    y: np.ndarray
    P: np.ndarray
    prior: np.ndarray
    sensed: np.ndarray
    acted: np.ndarray
    sensor_age: np.ndarray
    actuator_age: np.ndarray
    fresh: np.ndarray
    diverged_at: float | None
    plan: FilterPlan
    draw: Draw


@takes(s=instance(NetworkScenario))
def simulate_network(s: NetworkScenario) -> NetworkRun:
    """Run the loop. Ends early, `diverged_at` set, where a state passes 1e9 times its start (or 1).

    >>> plant = Plant([[1.1]], [[1]], [[1]], dt=1.0)
    >>> run = simulate_network(NetworkScenario(plant, [[0.5]], [[1]], [[1]], [[1]], [0.0], 20, Link(loss=0.2)))
    >>> run.e.shape
    (20, 1)
    """
    d = _draw(s)
    plan = _plan(s, d.sensed, s.order)
    applied = _applied(s, d.acted)
    x, xhat, y, asked, acts = _march(s, d, plan, applied)
    count, A = len(x), s.plant.A
    sensor_age, actuator_age = newest_packet_age(d.sensed)[:count], newest_packet_age(d.acted)[:count]
    prior = np.empty((count, *A.shape))
    prior[0] = s.P0
    prior[1:] = A @ plan.P[:count - 1] @ A.T + s.Q
    fresh = np.isin(np.arange(count), d.acted)
    return NetworkRun(s, s.plant.dt * np.arange(count), x, xhat, x - xhat, asked, acts, y, plan.P[:count], prior,
                      d.sensed[:count], d.acted[:count], sensor_age, actuator_age, fresh,
                      None if count == s.steps else float(count * s.plant.dt), plan, d)


@takes(run=instance(NetworkRun))
def promised_error(run: NetworkRun) -> np.ndarray:
    """e (N, n) of an observer that is told the applied input and reads time stamps, on this run's noise and packets.

    Then e⁺ depends on e, w, v and the arrivals alone, whatever K and the state do.
    """
    s, d = run.scenario, run.draw
    plan = run.plan if s.order == "stamped" else _plan(s, d.sensed, "stamped")
    watch = _Watch(plan, s.plant, -d.e0, d.v, -d.w)  # a plant at rest whose estimate is −e
    return -np.array([watch.at(k) for k in range(len(run.t))])


@takes(run=instance(NetworkRun), promised=optional(array("k n")))
def network_meter(run: NetworkRun, *, promised: np.ndarray | None = None) -> float:
    """How far e leaves the promise: max‖e − e_promised‖/max‖e_promised‖ over the run; 0 to rounding if separation holds.

    A gap below 1e-12 of the largest ‖x‖ is the rounding of x − x̂ and counts as none, in runs that run away too.
    `promised` (N, n) is that of `promised_error`, if it is already there.
    """
    promised = promised_error(run) if promised is None else promised
    if promised.shape != run.e.shape:
        raise ShapeError("{name} must be {must}; it is {it_is}.", name="promised", must="×".join(map(str, run.e.shape)),
                         it_is="×".join(map(str, promised.shape)))
    gap, size, state = (float(np.linalg.norm(v, axis=1).max()) for v in (run.e - promised, promised, run.x))
    if gap <= STATE_ROUNDING * state:
        return 0.0
    return gap / size if size else gap


# --- the parts ---------------------------------------------------------------------------------------------------------
def _draw(s: NetworkScenario) -> Draw:
    start, for_w, for_v, for_sensor, for_actuator = np.random.default_rng(s.seed).spawn(5)
    n, p = s.plant.n, s.plant.p
    return Draw(root(s.P0) @ start.standard_normal(n), for_w.standard_normal((s.steps, n)) @ root(s.Q).T + s.jumps,
                 for_v.standard_normal((s.steps, p)) @ root(s.R).T, s.sensor.draw(s.steps, for_sensor),
                 s.actuator.draw(s.steps, for_actuator))


def _applied(s: NetworkScenario, acted: np.ndarray) -> np.ndarray:
    """Which input the actuator applies at each sample (N,), −1 for zero. An actuator never goes back to an older one."""
    k = np.arange(s.steps)
    source = k - newest_packet_age(acted)
    return source if s.on_loss == "hold" else np.where(np.isin(k, acted), source, LOST_PACKET)


def _plan(s: NetworkScenario, sensed: np.ndarray, order: str) -> FilterPlan:
    A, C, Q, R, N = s.plant.A, s.plant.C, s.Q, s.R, s.steps
    k = np.arange(N)
    if order == "arrival":
        inside = np.isin(k, sensed)
        newest = np.full(N, LOST_PACKET)
        taken = np.flatnonzero((sensed >= 0) & (sensed < N))
        newest[sensed[taken]] = taken
        window, source, heard = 0, newest[:, None], inside[:, None]
    else:
        window = s.sensor.latest
        source = k[:, None] + np.arange(-window, 1)
        there = sensed[np.maximum(source, 0)]
        heard = (source >= 0) & (there >= 0) & (there <= k[:, None])
        inside = sensed >= 0
    final = riccati_path(s.P0, A, C, Q, R, inside[:-1])  # what is known once every packet that comes has come
    P = final[np.maximum(k - window, 0)]
    gains = np.empty((N, window + 1, *C.T.shape))
    for i in range(window + 1):
        after, gains[:, i] = corrected_covariance(P, C, R)
        P = np.where(heard[:, i, None, None], after, P)
        if i < window:
            P = np.where((source[:, i] >= 0)[:, None, None], A @ P @ A.T + Q, P)
    return FilterPlan(window, heard, source, gains, symmetric(P))


class _Watch:
    """The observer along a record: measurements y (N, p) and pushes B u (N, n), both filled in as time goes on."""

    def __init__(self, plan: FilterPlan, plant: Plant, start: np.ndarray, y: np.ndarray, pushes: np.ndarray) -> None:
        self._A, self._C, self._window, self._gains = plant.A, plant.C, plan.window, plan.gains
        self._heard, self._source = plan.heard.tolist(), plan.source.tolist()
        self._y, self._pushes = y, pushes
        self._early = self._last = start  # x̂ of the first sample of the window, before its measurement

    def at(self, k: int) -> np.ndarray:
        """x̂[k | arrived by k]; to be asked for k = 0, 1, 2 … with y up to k and pushes up to k − 1 known."""
        A, C, D = self._A, self._C, self._window
        if D == 0 and k:
            self._early = A @ self._last + self._pushes[k - 1]
        z = self._early
        for i in range(max(0, D - k), D + 1):
            if self._heard[k][i]:
                z = z + self._gains[k, i] @ (self._y[self._source[k][i]] - C @ z)
            if i < D:
                z = A @ z + self._pushes[k - D + i]
                if i == 0:
                    self._early = z
        self._last = z
        return z


def _march(s: NetworkScenario, d: Draw, plan: FilterPlan, applied: np.ndarray) -> tuple[np.ndarray, ...]:
    """States, estimates, measurements, inputs asked and applied, up to where the run diverges."""
    A, B, C, N, K = s.plant.A, s.plant.B, s.plant.C, s.steps, s.K
    n, m = B.shape
    xs, estimates, ys, pushes = np.empty((N, n)), np.empty((N, n)), np.empty((N, len(C))), np.zeros((N, n))
    asked, acts, x = np.zeros((N, m)), np.zeros((N, m)), s.x0
    watch = _Watch(plan, s.plant, s.x0 - d.e0, ys, pushes)
    bound = DIVERGENCE_FACTOR * max(1.0, float(np.abs(x).max()))
    ahead = [np.linalg.matrix_power(A, i) @ B for i in range(s.ahead)]
    forward = np.linalg.matrix_power(A, s.ahead)
    for k in range(N):
        xs[k] = x
        ys[k] = C @ x + d.v[k]
        estimates[k] = guess = watch.at(k)
        if s.ahead:
            guess = forward @ guess
            for i in range(1, min(s.ahead, k) + 1):
                guess = guess + ahead[i - 1] @ asked[k - i]
        asked[k] = u = -K @ guess
        if applied[k] >= 0:
            acts[k] = asked[applied[k]]
        act = B @ acts[k]
        pushes[k] = act if s.told == "applied" else B @ u
        x = A @ x + act + d.w[k]
        if not np.abs(x).max() < bound:
            return tuple(a[:k + 1] for a in (xs, estimates, ys, asked, acts))
    return xs, estimates, ys, asked, acts
