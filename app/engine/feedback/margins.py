"""Compute gain, phase, delay and disk margins, one channel at a time and all at once."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..systems.gates.argument_checks import matrix, takes
from ..systems.gates.plant_gate import CONTROLLER, PLANT
from ..systems.plant import Plant
from ..systems.records import record
from .refine import Response, highest, zeros_of
from .sensitivity import Sensitivity, sensitivity

__all__ = ["ChannelMargins", "DiskMargin", "LoopMargins", "MultiMargins", "loop_margins", "state_feedback_margins"]

BALANCING = 12  # sweeps of Osborne's iteration
UNEVEN = 1e60  # how unequal squared rows and columns may be before balancing stops
ENDLESS = 1e6  # a gain factor that counts as infinite, its inverse as none; S is known to about 1e-9


@record(eq=True)
class DiskMargin:
    """The balanced disk margin α = 2 / max‖S − T‖ (for many channels max over ω of the structured norm).

    Every gain and phase (1 + δα/2)/(1 − δα/2), |δ| < 1, of each channel at once, is tolerated. gain: the real factors
    (low, high); phase in rad; frequency in rad/s of the worst perturbation. Seiler, Packard and Gahinet (2020), σ = 0.
    """

    alpha: float
    frequency: float

    @property
    def gain(self) -> tuple[float, float]:
        """The gains ((2 − α)/(2 + α), (2 + α)/(2 − α)); below zero where the sign may turn, ∞ above α = 2."""
        low = (2 - self.alpha) / (2 + self.alpha)
        return low, 1 / low if low > 0 else np.inf

    @property
    def phase(self) -> float:
        """2 atan(α/2) in rad."""
        return float(2 * np.arctan(self.alpha / 2))


@record(eq=True)
class ChannelMargins:
    """Margins of the loop cut at one signal, all other loops closed, with the loop gain ℓ of 1 + ℓ = 1/S_ii.

    gain: the loop is stable for every factor between (low, high), low = 0 and high = ∞ if no positive factor is too
    small or large; gain_frequencies in rad/s (NaN where there is none). phase: rad of lag or lead, π if |ℓ| = 1
    nowhere. delay: s of extra delay, ∞ if |ℓ| = 1 nowhere. sensitivity_peak max|S| and its
    peak_frequency; `nearest` is min|1 + ℓ|.
    """

    name: str
    gain: tuple[float, float]
    gain_frequencies: tuple[float, float]
    phase: float
    phase_frequency: float
    delay: float
    disk: DiskMargin
    sensitivity_peak: float
    peak_frequency: float

    @property
    def nearest(self) -> float:
        """min |1 + ℓ(jω)|, the distance of Nyquist's curve from −1."""
        return 1 / self.sensitivity_peak


@record(eq=True)
class MultiMargins:
    """Margins against perturbations of several channels at once, independent of each other.

    disk: α = 1/max_ω μ((S − T)/2), with the upper bound of μ for a diagonal of complex gains: never optimistic.
    unstructured: with the largest singular value in place of μ, against every full matrix of perturbations.
    sensitivity_peak: largest singular value of S over all frequencies, at peak_frequency.
    """

    disk: DiskMargin
    unstructured: DiskMargin
    sensitivity_peak: float
    peak_frequency: float


@record()
class LoopMargins:
    """Margins of a loop: of each plant input and output, of all inputs, of all outputs, and of both together.

    Each is worked out when it is first asked for. An unstable loop has no margins: gain (1, 1), phase, delay and α zero,
    peaks ∞.
    """

    loop: Sensitivity
    names: tuple[str, ...]

    @property
    def stable(self) -> bool:
        """Whether the closed loop is stable."""
        return self.loop.stable

    def input(self, i: int) -> ChannelMargins:
        """Of the loop cut at plant input i alone, the others closed: what `inputs` says of it, without the rest."""
        return _channel(self.loop, range(self.loop.inputs)[i], self.names[i])

    @cached_property
    def inputs(self) -> tuple[ChannelMargins, ...]:
        """Of the loop cut at each plant input."""
        return tuple(_channel(self.loop, i, self.names[i]) for i in range(self.loop.inputs))

    @cached_property
    def outputs(self) -> tuple[ChannelMargins, ...]:
        """Of the loop cut at each plant output."""
        return tuple(_channel(self.loop, i, self.names[i]) for i in range(self.loop.inputs, len(self.names)))

    @cached_property
    def input_disk(self) -> DiskMargin:
        """`all_inputs.disk` alone, for who needs nothing else of it."""
        return _structured_disk(self.loop)

    @cached_property
    def all_inputs(self) -> MultiMargins:
        """Of all plant inputs at once.

        >>> bool(loop_margins(Plant([[0]], [[1]], [[1]]), [[-1]]).all_inputs.disk.alpha > 1.99)
        True
        """
        return _together(self.loop, slice(0, self.loop.inputs))

    @cached_property
    def all_outputs(self) -> MultiMargins:
        """Of all plant outputs at once.

        >>> bool(loop_margins(Plant([[0]], [[1]], [[1]]), [[-1]]).all_outputs.disk.alpha > 1.99)
        True
        """
        return _together(self.loop, slice(self.loop.inputs, len(self.names)))

    @cached_property
    def both(self) -> MultiMargins:
        """Of all inputs and outputs at once; `unstructured` and the peaks here depend on the units of the signals."""
        return _together(self.loop, slice(0, len(self.names)))


@takes(plant=PLANT, controller=CONTROLLER)
def loop_margins(plant: Plant, controller: Plant | object) -> LoopMargins:
    """Margins of the loop of a plant and a controller u = Kc(s) y, its sign included as `compensator` gives it.

    `controller` is a Plant from y to u or a constant matrix m×p. The loop is swept from ω = 0 to ∞ (to π/dt if
    sampled), denser around lightly damped poles; crossings are located by Im S_ii = 0 (phase −π or 0) and
    Re S_ii = ½ (gain one), peaks refined between grid points. Raises ShapeError, EngineError where the two do not fit.

    >>> loop_margins(Plant([[0]], [[1]], [[1]]), compensator(Plant([[0]], [[1]], [[1]]), [[1]], [[2]])).stable
    True
    """
    return LoopMargins(sensitivity(plant, controller), plant.input_names + plant.output_names)


@takes(plant=PLANT, K=matrix())
def state_feedback_margins(plant: Plant, K: object) -> LoopMargins:
    """Margins of u = −K x, the whole state measured; the outputs are then the states."""
    seen = Plant(plant.A, plant.B, np.eye(plant.n), np.zeros((plant.n, plant.m)), plant.dt, plant.state_names, plant.input_names,
                 plant.state_names)
    return loop_margins(seen, -np.atleast_2d(np.asarray(K, dtype=float)))


# --- one channel -------------------------------------------------------------------------------------------------------
def _channel(loop: Sensitivity, i: int, name: str) -> ChannelMargins:
    if not loop.stable:
        nan = float("nan")
        return ChannelMargins(name, (1.0, 1.0), (nan, nan), 0.0, nan, 0.0, DiskMargin(0.0, nan), np.inf, nan)
    omega, s, at = loop.omega, loop.own(i), loop.along(i)
    low, high = _gain(omega, s, at)
    phase, delay = _phase(loop, s, at)
    peak, frequency = highest(omega, np.abs(s), lambda w: np.abs(at(w)))
    disk = _disk(*highest(omega, np.abs(s - 0.5), lambda w: np.abs(at(w) - 0.5)))
    return ChannelMargins(name, (low[0], high[0]), (low[1], high[1]), phase[0], phase[1], delay, disk, peak, frequency)


def _gain(omega: np.ndarray, s: np.ndarray, at: Response) -> tuple[tuple[float, float], tuple[float, float]]:
    """(factor, frequency) of the largest destabilising gain below one and the least above: 1 + gℓ = 0, g = S/(S − 1)."""
    crossings = zeros_of(omega, np.imag(s), lambda w: np.imag(at(w)))
    where = np.concatenate([omega[[0, -1]], crossings])
    value = np.real(np.concatenate([s[[0, -1]], at(crossings)]))
    with np.errstate(divide="ignore"):
        factor = value / (value - 1)
    below, above = (factor > 1 / ENDLESS) & (factor < 1), (factor > 1) & (factor < ENDLESS)
    low, high = (0.0, float("nan")), (float("inf"), float("nan"))
    if below.any():
        low = max(zip(factor[below].tolist(), where[below].tolist(), strict=True))
    if above.any():
        high = min(zip(factor[above].tolist(), where[above].tolist(), strict=True))
    return low, high


def _phase(loop: Sensitivity, s: np.ndarray, at: Response) -> tuple[tuple[float, float], float]:
    """((phase margin, its frequency), delay margin) from the frequencies with |ℓ| = 1, where −ℓ = (S − 1)/S = e^{jφ}."""
    crossings = zeros_of(loop.omega, np.real(s) - 0.5, lambda w: np.real(at(w)) - 0.5)
    phase, delay = (float(np.pi), float("nan")), float("inf")
    if crossings.size:
        value = at(crossings)
        angles = np.angle((value - 1) / value)
        nearest = int(np.argmin(np.abs(angles)))
        phase = float(np.abs(angles[nearest])), float(crossings[nearest])
        delay = float((angles % (2 * np.pi) / crossings).min())
    if not loop.dt and abs(1 - s[-1]) > abs(s[-1]):
        delay = 0.0  # |ℓ(j∞)| > 1: the slightest delay destabilises
    return phase, delay


def _structured_disk(loop: Sensitivity) -> DiskMargin:
    """Of all inputs at once, which come first among the signals."""
    if not loop.stable:
        return DiskMargin(0.0, float("nan"))
    count = loop.inputs
    S, half = loop.values[:, :count, :count], 0.5 * np.eye(count)
    return _disk(*highest(loop.omega, _structured(S - half), lambda w: _structured(loop.corner(w, count) - half)))


# --- many channels -----------------------------------------------------------------------------------------------------
def _together(loop: Sensitivity, part: slice) -> MultiMargins:
    nan = float("nan")
    if not loop.stable:
        none = DiskMargin(0.0, nan)
        return MultiMargins(none, none, np.inf, nan)
    S = loop.values[:, part, part]
    identity = np.eye(S.shape[1])

    def peak(norm: Response, less: float) -> tuple[float, float]:
        """The largest norm of S − less · I, and where."""
        return highest(loop.omega, norm(S - less * identity), lambda w: norm(loop.corner(w, part.stop)[..., part, part] - less * identity))

    top, frequency = peak(_largest, 0.0)
    return MultiMargins(_disk(*peak(_structured, 0.5)), _disk(*peak(_largest, 0.5)), top, frequency)


def _largest(matrices: np.ndarray) -> np.ndarray:
    """Largest singular value of each matrix of a stack; of two rows and columns without a search, sums of squares alone."""
    if matrices.shape[-2:] == (2, 2):
        size = np.real(matrices) ** 2 + np.imag(matrices) ** 2
        first, second = size[..., 0, :].sum(axis=-1), size[..., 1, :].sum(axis=-1)
        along = (matrices[..., 0, :] * matrices[..., 1, :].conj()).sum(axis=-1)
        return np.sqrt((first + second + np.hypot(first - second, 2 * np.abs(along))) / 2)
    return np.linalg.svd(matrices, compute_uv=False)[..., 0]


def _structured(matrices: np.ndarray) -> np.ndarray:
    """An upper bound of μ for a diagonal of complex perturbations: σ̄(D M D⁻¹), D balancing rows and columns (Osborne).

    Any D gives a bound that is never below μ, so that a margin from it is never optimistic.
    """
    size = matrices.shape[-1]
    if size == 1:
        return np.abs(matrices[..., 0, 0])
    power = np.abs(matrices) ** 2
    power += power.max(axis=(-2, -1), keepdims=True) / UNEVEN + 1e-200
    power[..., np.arange(size), np.arange(size)] = 0.0
    d = np.ones(matrices.shape[:-1])  # squares of the scalings
    for _ in range(BALANCING if size > 2 else 1):  # one round balances two
        for i in range(size):
            d[..., i] = np.sqrt((power[..., :, i] * d).sum(axis=-1) / (power[..., i, :] / d).sum(axis=-1))
        d = np.clip(d / d[..., :1], 1 / UNEVEN, UNEVEN)
    d = np.sqrt(d)
    return np.minimum(_largest(matrices * d[..., :, None] / d[..., None, :]), _largest(matrices))


def _disk(peak: float, frequency: float) -> DiskMargin:
    return DiskMargin(1 / peak if peak > 0 else float("inf"), frequency)
