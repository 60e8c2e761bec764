"""Join a continuous plant and a sampled controller: linear step, clipping, rounding."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..feedback.loop_spectrum import NoisyLoop
from ..systems.arrays import as_checked, as_covariance, frozen, symmetric
from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.gates.argument_checks import INTEGER, count, covariance, gated, instance, items, matrix, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.lyapunov import settled_covariance
from ..systems.noise import root
from ..systems.plant import Plant, as_matrix
from ..systems.records import record
from ..systems.stability import is_stable
from .hardware import Hardware
from .mechanics import HeldMechanics, held_mechanics, matrix_key, sensor_root, without_converter
from .sampled_control import SampledController

__all__ = ["SampledLoop", "sampled_loop"]

IDEAL = Hardware()
MOST_DELAY = 1000  # samples


@record()
class SampledLoop:
    """w = (driver, plant, ground, controller, bias, commands on their way); at sample k

        m = round(Y w + v), s = clip(U w + T m), w⁺ = F w + F_m m + F_s s + jumps.

    F (N×N), F_m (N×p), F_s (N×m), Y (p×N), and U (k, m, N), T (k, m, p) for each sample, the last from then on; F too
    is (k, N, N), F_m (k, N, p) and F_s (k, N, m). x, mechanics, control, bias: where the plant, all that is continuous,
    the controller and the bias stand in w. ways: whole samples of delay, what the command then due does to the
    mechanics, and what the one before it still does. outputs (q×N): what is recorded beside u. jump (N×r), sensor
    (p×p): roots of the covariances of a sample's noise. Gamma (N×d): what the known disturbances do, held over a sample.
    """

    F: np.ndarray
    F_m: np.ndarray
    F_s: np.ndarray
    Y: np.ndarray
    U: np.ndarray
    T: np.ndarray
    x: slice
    mechanics: slice
    control: slice
    bias: slice
    ways: tuple[int, np.ndarray, np.ndarray]
    outputs: np.ndarray
    jump: np.ndarray
    sensor: np.ndarray
    Gamma: np.ndarray
    hardware: Hardware
    dt: float

    @property
    def n(self) -> int:
        """Number of states."""
        return self.F.shape[1]

    @property
    def varying(self) -> int:
        """Samples for which the controller still changes."""
        return len(self.F) - 1

    @gated(k=optional(count()))
    def closed(self, *, k: int | None = None) -> np.ndarray:
        """The step w⁺ = F_c w of the loop as long as nothing clips or rounds, N×N; at sample k, by default settled.

        From sample `varying` on the loop is the settled one.
        """
        k = self.varying if k is None else min(k, self.varying)
        return self.F[k] + self.F_m[k] @ self.Y + self.F_s[k] @ (self.U[k] + self.T[k] @ self.Y)

    @cached_property
    def feedback(self) -> np.ndarray:
        """u = feedback w of the settled loop, m×N, without sensor noise."""
        return self.U[-1] + self.T[-1] @ self.Y

    @cached_property
    def noise_in(self) -> np.ndarray:
        """How v enters the settled loop: w⁺ = F_c w + noise_in v, N×p."""
        return self.F_m[-1] + self.F_s[-1] @ self.T[-1]

    @cached_property
    def poles(self) -> np.ndarray:
        """Poles of the settled loop as they come; the bias, which nothing controls, does not count."""
        return frozen(np.linalg.eigvals(self._without_bias(self.closed())))

    @cached_property
    def radius(self) -> float:
        """Largest |pole| of the settled loop."""
        return float(np.max(np.abs(self.poles), initial=0.0))

    @cached_property
    def stable(self) -> bool:
        """Whether the settled loop is stable by more than rounding, as long as nothing clips or is quantised."""
        return is_stable(self._without_bias(self.closed()), dt=self.dt)

    def _without_bias(self, matrix: np.ndarray) -> np.ndarray:
        keep = np.ones(self.n, dtype=bool)
        keep[self.bias] = False
        return matrix[np.ix_(keep, keep)]

    @cached_property
    def covariance(self) -> np.ndarray:
        """Stationary covariance of w (N×N), the bias taken for zero and rounding for white noise of step²/12.

        P = F_c P F_cᵀ + jumps + noise. Raises EngineError where the loop is not stable.
        """
        if not self.stable:
            raise EngineError("This loop is not stable, so it has no stationary covariance; stabilise it first.")
        keep = np.ones(self.n, dtype=bool)
        keep[self.bias] = False
        push = np.hstack([self.jump, self.noise_in @ root(self.reading)])[keep]
        P = np.zeros((self.n, self.n))
        P[np.ix_(keep, keep)] = settled_covariance(self._without_bias(self.closed()), push, dt=1.0)
        return frozen(symmetric(P))

    @cached_property
    def reading(self) -> np.ndarray:
        """Covariance of one reading's noise (p×p): the sensor's, and step²/12 of the converter."""
        return self.sensor @ self.sensor.T + self.hardware.step**2 / 12 * np.eye(len(self.sensor))

    @cached_property
    def noisy(self) -> NoisyLoop:
        """The settled loop as long as nothing clips, under its own noise: densities and variances of (outputs, u).

        Rounding counts as white noise of step²/12; a drifting bias enters as the white noise that it sums up. Its
        `outputs(T)` take the recorded outputs, its `inputs(T)` the commands.
        """
        r, q, p = self.jump.shape[1], len(self.outputs), len(self.Y)
        white = np.zeros((r + p, r + p))
        white[:r, :r], white[r:, r:] = np.eye(r), self.reading
        D = np.zeros((q + len(self.feedback), r + p))
        D[q:, r:] = self.T[-1]
        return NoisyLoop(self.closed(), np.hstack([self.jump, self.noise_in]), np.vstack([self.outputs, self.feedback]), D,
                         white, r, q, self.dt)


@takes(plant=PLANT, controller=instance(SampledController), controls=items(INTEGER, 1000), hardware=instance(Hardware),
       W=covariance(), V=covariance("p"), shaping=PLANT, disturbances=matrix(), outputs=matrix("k n"))
def sampled_loop(plant: Plant, controller: SampledController, controls: Sequence[int], *, hardware: Hardware = IDEAL,
                 W: object | None = None, V: object | None = None, shaping: Plant | None = None,
                 disturbances: np.ndarray | None = None, outputs: np.ndarray | None = None) -> SampledLoop:
    """The loop of a continuous plant and a sampled controller, exact at the samples.

    The controller drives the inputs `controls`; the others are the ground. White noise of intensity W (q×q) is the
    ground motion itself, or, with `shaping`, drives this filter, whose outputs are the ground motion. V (p×p) is the
    intensity of the sensors' noise, V/dt its covariance at a sample. `disturbances` (n×d): how known disturbances enter
    the plant's ẋ, the ground's columns of B by default. `outputs` (q×n): rows that are recorded of the plant's state, C
    by default. Raises ShapeError, EngineError, one sentence each.

    >>> from observer_lab.engine.sampled import sampled_controller
    >>> plant = Plant([[0]], [[1]], [[1]])
    >>> sampled_loop(plant, sampled_controller(compensator(plant, [[1]], [[3]]), 0.1), [0]).dt
    0.1
    """
    chosen = [int(i) for i in controls]
    if len(set(chosen)) < len(chosen) or not all(0 <= i < plant.m for i in chosen):
        raise ShapeError("The controlled inputs must be different numbers from 0 to {m}.", m=plant.m - 1)
    others = [i for i in range(plant.m) if i not in chosen]
    p, m, dt = plant.p, len(chosen), controller.dt
    if plant.dt:
        raise EngineError("The plant must be continuous; the loop samples it exactly.")
    if np.any(np.asarray(plant.D)):
        raise EngineError("A plant with direct feedthrough (D ≠ 0) is not simulated here.")
    if controller.B.shape[2] != p or controller.C.shape[1] != m:
        raise ShapeError("The controller must take {p} outputs and drive {m} inputs; it takes {b_shape} and "
                         "drives {columns}.",
                         p=p, m=m, b_shape=controller.B.shape[2], columns=controller.C.shape[1])
    if hardware.delay > MOST_DELAY * dt:
        raise EngineError("The delay is longer than {most_delay} samples; shorten it.", most_delay=MOST_DELAY)
    rows = as_matrix(plant.C if outputs is None else outputs, phrase("The outputs"))
    noise = None if W is None else as_covariance(W, "W", shaping.m if shaping else len(others))
    known = None if disturbances is None else as_checked(disturbances)
    held = held_mechanics(
        plant, tuple(chosen), tuple(others), without_converter(hardware), shaping, matrix_key(noise), matrix_key(known), dt
    )
    return _assembled(held, controller, hardware, V, rows, p, m)


def _assembled(held: HeldMechanics, controller: SampledController, hardware: Hardware, V: object | None,
               outputs: np.ndarray, p: int, m: int) -> SampledLoop:
    dt, a, c, part, soon, late = controller.dt, len(held.Phi), controller.n, held.part, held.soon, held.late
    lag = held.whole + (part > 0)
    drifting = p if hardware.walk > 0 or hardware.ramp != 0 else 0
    N = a + c + drifting + lag * m
    control, bias, queue = slice(a, a + c), slice(a + c, a + c + drifting), a + c + drifting
    k = len(controller.A)
    F, F_m, F_s = np.zeros((k, N, N)), np.zeros((k, N, p)), np.zeros((k, N, m))
    F[:, :a, :a], F[:, control, control], F[:, bias, bias] = held.Phi, controller.A, np.eye(drifting)
    F_m[:, control], F_s[:, control] = controller.B, controller.E
    ways = [slice(queue + i * m, queue + (i + 1) * m) for i in range(lag)]  # ways[0] is the oldest command
    if lag:
        F_s[:, ways[-1]] = np.eye(m)
        for older, newer in pairwise(ways):
            F[:, older, newer] = np.eye(m)
    if part > 0:
        F[:, :a, ways[0]] += late
        if lag > 1:
            F[:, :a, ways[1]] += soon
        else:
            F_s[:, :a] += soon
    elif lag:
        F[:, :a, ways[0]] += soon
    else:
        F_s[:, :a] += soon
    Y, U = np.zeros((p, N)), np.zeros((k, m, N))
    Y[:, :a], Y[:, bias] = held.C, np.eye(p)[:, :drifting]
    U[:, :, control] = controller.C
    shown = np.zeros((len(outputs), N))
    shown[:, held.x] = outputs
    jump = _padded(held.jump, N)
    if hardware.walk > 0:
        walk = np.zeros((N, p))
        walk[bias] = hardware.walk * np.sqrt(dt) * np.eye(p)
        jump = np.hstack([jump, walk])
    sensor = np.zeros((p, p)) if V is None else sensor_root(matrix_key(as_covariance(V, "V", p)), dt)
    return SampledLoop(F, F_m, F_s, Y, U, controller.D, held.x, slice(0, a), control, bias,
                       (held.whole, soon, late), shown, jump, sensor, _padded(held.Gamma, N), hardware, dt)


def _padded(rows: np.ndarray, N: int) -> np.ndarray:
    return np.vstack([rows, np.zeros((N - len(rows), rows.shape[1]))])


