"""Model converter noise: white floor, 1/f below a corner, quantisation."""

from __future__ import annotations

from functools import cached_property
from typing import TypeVar

import numpy as np
from scipy.linalg import block_diag

from ...systems.errors import EngineError
from ...systems.gates.argument_checks import GENERATOR, MOST_NUMBERS, RECORD, SERIES, count, gated, instance, number, passed, takes
from ...systems.records import record
from .linear_filter import LinearFilter

__all__ = ["AdcNoise", "with_coloured_noise"]

Filter = TypeVar("Filter", bound=LinearFilter)
PER_DECADE = 3  # relaxations; their sum ripples by less than 1 % about 1/f
MAX_RELAXATIONS = 60
RELAXATION_SPAN = 10.0  # how far above the corner relaxations are placed; there the floor hides what is missing


@record(eq=True)
class AdcNoise:
    """Converter noise of one channel, sampled every dt s: a white floor and flicker noise below the corner.

    sigma: standard deviation of the floor at a sample, so its one-sided density is 2σ²dt. corner Hz: where flicker and
    floor are equal (0: no flicker); lowest Hz: below it flicker stays flat. step: size of one bit (0: none).
    Flicker is a sum of relaxations b⁺ = a b + q with corners three a decade, each of the same variance, so that the
    density is S(f) = 2dt [σ² + Σ s²(1 − a²)/|e^{j2πf dt} − a|²] exactly and a Kalman filter can carry the noise as
    states. Raises EngineError for sizes that make no sense.
    """

    sigma: float
    corner: float
    lowest: float
    dt: float
    step: float = 0.0

    def __post_init__(self) -> None:
        size = number(0, 1e150)
        passed(self, sigma=size, corner=size, lowest=size, dt=size, step=size)
        numbers = (self.sigma, self.corner, self.lowest, self.dt, self.step)
        if not all(np.isfinite(number) and number >= 0 for number in numbers) or self.dt == 0:
            raise EngineError("The noise of a converter needs finite sizes ≥ 0 and a sampling period dt > 0.")
        if self.corner > 0 and not 0 < self.lowest < min(self.corner, 0.5 / self.dt):
            raise EngineError("The lowest frequency must lie above 0 and below the corner and half the sampling "
                              "rate.")
        if self.corner > 0 and len(self.relaxations[0]) > MAX_RELAXATIONS:
            raise EngineError("The lowest frequency is too far below the corner; raise it.")

    @cached_property
    def relaxations(self) -> tuple[np.ndarray, float]:
        """Factors a (q,) of the relaxations over a sample, and the variance s² of each."""
        if self.corner == 0:
            return np.zeros(0), 0.0
        top = max(min(RELAXATION_SPAN * self.corner, 0.25 / self.dt), self.lowest)
        span = PER_DECADE * (np.log10(top) - np.log10(self.lowest))
        count = int(np.ceil(min(span, MAX_RELAXATIONS))) + 1
        corners = self.lowest * 10 ** (np.arange(count) / PER_DECADE)
        variance = 2 * self.sigma**2 * self.dt * self.corner * np.log(10) / PER_DECADE
        return np.exp(-2 * np.pi * corners * self.dt), float(variance)

    @property
    def variance(self) -> float:
        """Variance of a sample: floor, flicker and step²/12."""
        a, each = self.relaxations
        return self.sigma**2 + len(a) * each + self.step**2 / 12

    @gated(frequency=SERIES)
    def density(self, frequency: object) -> np.ndarray:
        """One-sided density in units²/Hz at frequencies in Hz, quantisation counted as white noise of step²/12."""
        f = np.asarray(frequency, dtype=float)
        a, each = self.relaxations
        turn = np.exp(2j * np.pi * f * self.dt)[..., None]
        flicker = (each * (1 - a**2) / np.abs(turn - a) ** 2).sum(axis=-1)
        return 2 * self.dt * (self.sigma**2 + self.step**2 / 12 + flicker)

    @gated(steps=count(0, MOST_NUMBERS // 20), channels=count(1, 10_000), rng=GENERATOR)
    def draw(self, steps: int, channels: int, rng: np.random.Generator) -> np.ndarray:
        """Independent noise for each channel, stationary from the start, (steps, channels); without quantisation."""
        if steps * channels > MOST_NUMBERS:
            raise EngineError("The run must have at least one sample and fit into memory; shorten it.")
        from scipy.signal import lfilter  # late: it brings all of scipy.stats, 0.6 s

        noise = self.sigma * rng.standard_normal((steps, channels))
        a, each = self.relaxations
        for factor in a:
            push = np.sqrt(each * (1 - factor**2)) * rng.standard_normal((steps, channels))
            push[:1] = np.sqrt(each) * rng.standard_normal((1, channels))
            noise += lfilter([1.0], [1.0, -factor], push, axis=0)
        return noise

    @gated(y=RECORD)
    def quantise(self, y: object) -> np.ndarray:
        """Readings rounded to whole steps.

        >>> AdcNoise(0.0, 0.0, 0.0, 1e-3, step=0.5).quantise([0.2, 0.3])
        array([0. , 0.5])
        """
        y = np.asarray(y, dtype=float)
        return self.step * np.round(y / self.step) if self.step > 0 else y


@takes(plain=instance(LinearFilter), noise=instance(AdcNoise))
def with_coloured_noise(plain: Filter, noise: AdcNoise) -> Filter:
    """The same filter with the flicker noise of every output as further states, and R from the white part alone.

    States (x, b): b⁺ = diag(a) b + q, y = C x + Σ b + D u + v. The innovations of this filter are white where those of
    the plain one are not. Raises EngineError where the sampling periods differ.
    """
    if plain.dt and abs(plain.dt - noise.dt) > 1e-9 * noise.dt:
        raise EngineError("The filter steps every {dt:g} s but the converter every {dt2:g} s; give both the same "
                          "period.",
                          dt=plain.dt, dt2=noise.dt)
    a, each = noise.relaxations
    p = len(plain.C)
    factors = np.tile(a, p)
    return type(plain)(
        A=np.asarray(block_diag(plain.A, np.diag(factors))),
        B=np.vstack([plain.B, np.zeros((factors.size, plain.B.shape[1]))]),
        C=np.hstack([plain.C, np.kron(np.eye(p), np.ones((1, a.size)))]),
        Q=np.asarray(block_diag(plain.Q, np.diag(each * (1 - factors**2)))),
        R=(noise.sigma**2 + noise.step**2 / 12) * np.eye(p),
        D=plain.D, dt=plain.dt or noise.dt,
    )
