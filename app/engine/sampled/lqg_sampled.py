"""Design sampled LQG: exact plant, cost and noise; steady or recursive filter."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..design.optimal import Optimal, dlqr
from ..feedback.compensator import compensator
from ..feedback.loop_spectrum import NoisyLoop, noisy_loop
from ..filters.belief import Belief
from ..filters.linear.kalman import KalmanFilter
from ..filters.track import Schedule
from ..systems.arrays import as_checked, as_covariance
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import SECONDS, SEED, array, count, covariance, gated, instance, matrix, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.noise import root, step_covariance
from ..systems.plant import Plant, as_matrix
from ..systems.records import record
from ..systems.recursions import affine_scan
from ..systems.sampling import require_continuous

__all__ = ["SampledLqg", "SampledRun", "sampled_cost", "sampled_lqg"]

PART_SAMPLES = 1000  # samples whose steps are made at once


@record()
class SampledRun:
    """A run of a sampled loop, time first: t (n_t,), x, xhat (after the reading), u, y (with its noise)."""

    t: np.ndarray
    x: np.ndarray
    xhat: np.ndarray
    u: np.ndarray
    y: np.ndarray


@record()
class SampledLqg:
    """An LQG loop that runs every `plant.dt` seconds: u[k] = −K x̂[k|k], held until the next sample.

    plant: x⁺ = A x + B u, exact. K (m×n), regulator with its Riccati solution, filter: the Kalman filter with the
    noise of one step (R = V/dt). controller is the compensator with the steady gain M, from y to u; it uses the
    reading of its own sample.
    """

    plant: Plant
    K: np.ndarray
    regulator: Optimal
    filter: KalmanFilter

    @cached_property
    def controller(self) -> Plant:
        """x̂⁻⁺ = (A − BK)(x̂⁻ + M(y − C x̂⁻)), u = −K(x̂⁻ + M(y − C x̂⁻)) with x̂⁻ the prediction: sign included."""
        return self.controller_with(self.filter.steady.filter_gain)

    @cached_property
    def late_controller(self) -> Plant:
        """The compensator that answers one sample late, u[k] = −K x̂[k|k−1]: x̂⁺ = (A − BK − LC) x̂ + L y, L = A M.

        >>> late = sampled_lqg(Plant([[0]], [[1]], [[1]]), [[1]], [[1]], [[1]], [[1]], 0.1).late_controller
        >>> bool(late.D.any())  # nothing of a reading reaches the input of its own sample
        False
        """
        return compensator(self.plant, self.K, self.filter.steady.predictor_gain)

    @gated(M=matrix())
    def controller_with(self, M: np.ndarray) -> Plant:
        """The compensator with a filter gain M (n×p) frozen at one instant of the recursive filter."""
        p, K = self.plant, self.K
        if M.shape != (p.n, p.p):
            raise ShapeError("{name} must be {must}; it is {it_is}.", name="M", must=f"{p.n}×{p.p}", it_is=f"{M.shape[0]}×{M.shape[1]}")
        keep, step = np.eye(p.n) - M @ p.C, p.A - p.B @ K
        return Plant(step @ keep, step @ M, -K @ keep, -K @ M, p.dt, tuple(f"{s}_hat" for s in p.state_names),
                     p.output_names, p.input_names, name=f"sampled compensator of {p.name}".strip())

    @gated(process=matrix(), readings=matrix())
    def loop(self, *, process: object | None = None, readings: object | None = None) -> NoisyLoop:
        """The loop with the steady filter under white noise: covariances of a step (n×n) and of a reading (p×p).

        By default those that the filter believes. Signals are taken at the samples.
        """
        return noisy_loop(self.plant, self.controller, np.eye(self.plant.n),
                          self.filter.Q if process is None else process,
                          V=self.filter.R if readings is None else readings)

    @gated(steps=count(1, 1_000_000))
    def schedule(self, P0: object, steps: int) -> Schedule:
        """Gains of the recursive filter (Joseph's form) over `steps` samples, from the covariance P0 of x̂⁻[0]."""
        return self.filter.schedule(Belief(np.zeros(self.plant.n), as_covariance(P0, "P0", self.plant.n)), steps)

    @gated(steps=count(0, 1_000_000), seed=SEED)
    def draw(self, steps: int, seed: int, *, process: object | None = None,
             readings: object | None = None) -> tuple[np.ndarray, np.ndarray]:
        """White noise of a seed: jumps of the state (steps, n) and noise of the readings (steps, p).

        process (n×n) and readings (p×p) are their covariances, by default those that the filter believes.
        """
        for_w, for_v = np.random.default_rng(seed).spawn(2)
        w = self.filter.Q if process is None else as_covariance(process, "process", self.plant.n)
        v = self.filter.R if readings is None else as_covariance(readings, "readings", self.plant.p)
        return (for_w.standard_normal((steps, len(w))) @ root(w).T, for_v.standard_normal((steps, len(v))) @ root(v).T)

    @gated(x0=array(), w=matrix(), v=matrix(), gains=optional(instance(Schedule)), xhat0=array(), truth=PLANT)
    def run(self, x0: object, w: np.ndarray, v: np.ndarray, *, gains: Schedule | None = None,
            xhat0: object | None = None, truth: Plant | None = None) -> SampledRun:
        """The loop from x0 and the prediction xhat0 (default zero) under jumps w (n_t, n) and reading noise v (n_t, p).

        w[k] joins the state after sample k. `gains`: a schedule of the recursive filter, or None for the steady one.
        `truth`: what the plant really is, sampled alike; filter and gain keep to their own. Raises ShapeError.
        """
        w, v = as_matrix(w, "w"), as_matrix(v, "v")
        p, n, steps = self.plant, self.plant.n, len(v)
        real = p if truth is None else truth
        if (real.n, real.m, real.p, real.dt) != (n, p.m, p.p, p.dt):
            raise ShapeError("The true plant must have the states, inputs, outputs and period of the one designed "
                             "for.")
        if w.shape != (steps, n) or v.shape != (steps, p.p):
            raise ShapeError("Noise must be of shapes (n_t, {n}) and (n_t, {p}); it is {w_shape} and {v_shape}.",
                             n=n, p=p.p, w_shape=w.shape, v_shape=v.shape)
        z = np.concatenate([_vector(x0, "x0", n), _vector(np.zeros(n) if xhat0 is None else xhat0, "xhat0", n)])
        early, M = (0, self.filter.steady.filter_gain) if gains is None else (min(steps, len(gains.gains)), gains.gains[-1])
        path = np.empty((steps, 2 * n))
        for first in range(0, early, PART_SAMPLES):  # gains that still change
            part = slice(first, min(first + PART_SAMPLES, early))
            A, forcing = self._changing(real, gains.gains[part], w[part], v[part])  # type: ignore[union-attr]
            for k in range(part.start, part.stop):
                path[k] = z
                z = A[k - first] @ z + forcing[k - first]
        if early < steps:
            A, E = self._step(real, M)
            forcing = v[early:-1] @ E.T
            forcing[:, :n] += w[early:-1]
            path[early:] = affine_scan(A, forcing, z, steps - 1 - early)
        x, predicted = path[:, :n], path[:, n:]
        seen = x @ real.C.T + v - predicted @ p.C.T
        xhat = predicted + seen @ M.T
        if early:
            xhat[:early] = predicted[:early] + np.einsum("knp,kp->kn", gains.gains[:early], seen[:early])  # type: ignore[union-attr]
        return SampledRun(p.dt * np.arange(steps), x, xhat, -xhat @ self.K.T, x @ real.C.T + v)

    def _changing(self, real: Plant, M: np.ndarray, w: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(x, x̂⁻)⁺ = A (x, x̂⁻) + forcing at each sample, with its own filter gain M (k, n, p): A (k, 2n, 2n), forcing (k, 2n)."""
        p, n = self.plant, self.plant.n
        enter = np.vstack([-real.B @ self.K, p.A - p.B @ self.K])  # what x̂ after the reading does
        believed = M @ np.hstack([real.C, -p.C])
        believed[:, :, n:] += np.eye(n)
        A = enter @ believed
        A[:, :n, :n] += real.A
        forcing = np.einsum("knp,kp->kn", M, v) @ enter.T
        forcing[:, :n] += w
        return A, forcing

    def _step(self, real: Plant, M: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(x, x̂⁻)⁺ = A (x, x̂⁻) + E v with the filter gain M."""
        built = self.controller_with(M)
        Dk = np.asarray(built.D)
        A = np.block([[real.A + real.B @ Dk @ real.C, real.B @ built.C], [built.B @ real.C, built.A]])
        return A, np.vstack([real.B @ Dk, built.B])


@takes(plant=PLANT, Q=covariance("n"), R=covariance("m"), dt=SECONDS)
def sampled_cost(plant: Plant, Q: object, R: object, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(Q_d, R_d, N_d) with ∫₀ᵈᵗ xᵀQx + uᵀRu dt = xᵀQ_d x + 2xᵀN_d u + uᵀR_d u for u held over the step.

    From ∫ e^{Mᵀs} diag(Q, R) e^{Ms} ds with M = [A B; 0 0]. Shapes n×n, m×m, n×m. Raises EngineError.
    """
    require_continuous(plant)
    n, m = plant.n, plant.m
    M = np.zeros((n + m, n + m))
    M[:n, :n], M[:n, n:] = plant.A, plant.B
    weight = np.zeros_like(M)
    weight[:n, :n], weight[n:, n:] = as_checked(Q), as_checked(R)
    whole = step_covariance(M.T, weight, dt)
    return whole[:n, :n], whole[n:, n:], whole[:n, n:]


@takes(plant=PLANT, Q=covariance("n"), R=covariance("m"), W=covariance(), V=covariance("p"), dt=SECONDS, G=matrix("n q"))
def sampled_lqg(plant: Plant, Q: object, R: object, W: object, V: object, dt: float, *,
                G: object | None = None) -> SampledLqg:
    """The LQG loop that minimises the continuous cost average of xᵀQx + uᵀRu with a computer's held input.

    Plant, cost and noise are sampled exactly (Van Loan), R = V/dt; K from the discrete Riccati equation. Weights and
    intensities as in `lqg`. A plant that is sampled every dt already is taken as it is, Q, R its cost of a sample, W, V covariances.
    Platform report (003), equations (53)–(59) and section 5.3.2. Raises as `lqg` does, and for a plant of another period.

    >>> design = sampled_lqg(Plant([[0]], [[1]], [[1]]), [[1]], [[1]], [[1]], [[1]], 0.1)
    >>> design.filter.dt
    0.1
    """
    G = plant.B if G is None else as_checked(G)
    kf = KalmanFilter.from_plant(plant, W, V, dt=dt, G=G)
    sampled = Plant(kf.A, kf.B, kf.C, kf.D, dt, plant.state_names, plant.input_names, plant.output_names, plant.units,
                    plant.name)
    if np.any(sampled.D):
        raise EngineError("A sampled loop that answers in the same sample needs a plant without a direct path (D "
                          "= 0).")
    Qd, Rd, Nd = (as_checked(Q), as_checked(R), None) if plant.dt else sampled_cost(plant, Q, R, dt)
    regulator = dlqr(sampled.A, sampled.B, Qd, Rd, N=Nd)
    return SampledLqg(sampled, regulator.gain, regulator, kf)


def _vector(value: object, name: str, length: int) -> np.ndarray:
    vector = np.asarray(value, dtype=float).ravel()
    if vector.size != length or not np.isfinite(vector).all():
        raise ShapeError("{name} must have {length} finite entries.", name=name, length=length)
    return vector
