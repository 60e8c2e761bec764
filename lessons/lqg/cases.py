"""Define the plants of lesson 10: the platform, Doyle's plant, or any model that fits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import Plant, noisy_loop
from observer_lab.engine.design import typical_rate
from observer_lab.engine.feedback import NoisyLoop
from observer_lab.plants import MODELS, doyle
from observer_lab.plants.model import Model
from observer_lab.plants.platform import lqg_weights
from observer_lab.plants.platform.channels import HORIZONTAL, ROTATION, VERTICAL_CHANNEL, T_y
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, text

from ..toolkit.gains import sizes

REPORT, DOYLE = "platform", "doyle"
MAX_FREQUENCIES = 200  # frequencies of a figure
SENSOR_ERROR_SHARE = 0.01  # of an output at the start: how far the sensors of a person's own plant err


@dataclass(frozen=True)
class Factors:
    """What multiplies a case's own Q, R, W, V, and its true sensor noise: α_Q, α_R, β_Q, β_R and V_true/V."""

    alpha_q: float
    alpha_r: float
    beta_q: float
    beta_r: float
    sensor: float


REPORT_FACTORS = Factors(100.0, 0.1, 1.0, 1e9, 1.0)  # with which the page begins on the platform


@dataclass(frozen=True, eq=False)
class Case:
    """A model with weights and noise of unit size, and what is shown of it.

    plant: with its controlled inputs alone; G (n×q); Q, R, W, V: what the factors multiply; the true noise is
    `disturbance`·W and `sensor`·V. rows (k×n): the watched channels with their names; spectra are drawn in
    `unit`²/Hz, `scale` times SI, inputs in `input_unit`. band: Hz in which peaks are looked for, low: Hz below it that
    is reported too. wide: Hz of the robustness figures; dt, horizon: s of the run; computer: s between two samples of
    the Monte-Carlo, warm_up and record: s of it.
    """

    id: str
    label: Text
    model: Model
    plant: Plant
    G: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    W: np.ndarray
    V: np.ndarray
    rows: np.ndarray
    names: tuple[Text, ...]
    factors: Callable[[Design], Factors]
    true_disturbance: Callable[[Factors], float]
    unit: str
    scale: float
    input_unit: str
    input_scale: float
    frequency: np.ndarray
    band: tuple[float, float]
    low: float
    wide: np.ndarray
    dt: float
    horizon: float
    computer: float
    warm_up: float
    record: float

    @cached_property
    def open_loop(self) -> NoisyLoop:
        """The plant left alone under the true disturbance of unit factor, its watched channels as outputs."""
        return noisy_loop(self.plant, None, self.G, self.W).watching(self.rows)

    @cached_property
    def open_psd(self) -> np.ndarray | None:
        """Densities (n_f, k) of the channels without control, None where the plant is unstable."""
        return self.open_loop.psd(self.frequency) if self.open_loop.stable else None

    @cached_property
    def recovery_unit(self) -> float:
        """μ₀² = tr(G W Gᵀ)/tr(B Bᵀ): fictitious noise on the inputs that weighs as much as the disturbances.

        0 where the inputs move nothing.
        """
        inputs = float(np.trace(self.plant.B @ self.plant.B.T))
        return float(np.trace(self.G @ self.W @ self.G.T)) / inputs if inputs > 0 else 0.0


def _grid(plant: Plant, low: float, high: float, count: int) -> np.ndarray:
    """A logarithmic sweep in Hz, denser around the lightly damped modes inside it."""
    points = [np.geomspace(low, high, count)]
    for pole in (complex(p) for p in plant.poles if p.imag > 0):
        f = pole.imag / (2 * np.pi)
        if low < f < high and abs(pole.real) < 0.2 * abs(pole):
            points.append(f + abs(pole.real) / (2 * np.pi) * np.tan(np.linspace(-1.35, 1.35, 9)))
    grid = np.unique(np.concatenate(points))
    return grid[(grid >= low) & (grid <= high)][:MAX_FREQUENCIES]


def _by_knobs(design: Design) -> Factors:
    return Factors(design["alpha_q"], design["alpha_r"], design["beta_q"], design["beta_r"], design["sensor"])


def _by_paper(design: Design) -> Factors:
    return Factors(design["q"], 1.0, design["sigma"], 1.0, 1.0)


def _one(factors: Factors) -> float:
    return 1.0


def _as_believed(factors: Factors) -> float:
    return factors.beta_q


def report_case() -> Case:
    """The platform with ten states; Q, R, W, V as in the report with σ_v = 10⁻⁹ taken literally."""
    model = MODELS["platform"]
    whole, unit = model.plant, lqg_weights.Weights(1.0, 1.0, 1.0, 1.0, lqg_weights.LITERAL_V)
    plant = lqg_weights.coils(whole)
    channels = (VERTICAL_CHANNEL, ROTATION, HORIZONTAL)
    names = tuple(text("{name} channel", name=c.name) for c in channels)
    return Case(REPORT, text("platform of the report"), model, plant, lqg_weights.ground(whole),
                unit.Q(whole), unit.R, unit.W, unit.V, T_y[:3] @ plant.C, names, _by_knobs, _one, "µm/s", 1e6, "mN", 1e3,
                _grid(plant, 0.05, 50.0, 150), (0.5, 3.0), 0.1, np.geomspace(1e-2, 1e4, 140), 0.03, 6.0, 5e-3, 60.0, 170.0)


def doyle_case() -> Case:
    """Doyle's plant; q and σ are α_Q and β_Q, R = V = 1, and the noise is what the filter believes."""
    model, together = doyle.MODEL, doyle.BOTH_STATES
    one = np.eye(1)
    names = (text("measured state x₁"), text("hidden state x₂"),
             text("weighted sum x₁ + x₂"))
    return Case(DOYLE, text("Doyle's plant of 1978"), model, model.plant, together, together @ together.T, one,
                one, one, np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), names, _by_paper, _as_believed, "", 1.0, "", 1.0,
                np.geomspace(1e-2, 30.0, 150), (0.01, 30.0), 0.1, np.geomspace(1e-3, 1e3, 160), 0.015, 6.0, 2e-3, 4.0, 33.0)


def case_of(model: Model) -> Case:
    """Any model in its own measures: Q = 1 for outputs as large as at the start, R = 1 for inputs of u_max.

    The disturbances (of the inputs, if the model names none) are as strong as u_max over one typical time, the sensors
    err by a hundredth of an output. Spectra begin and end beyond all poles.
    """
    plant, G = model.controlled, model.disturbed
    G = plant.B if G is None else G
    size, rate = sizes(model), typical_rate(plant)
    speed = np.abs(plant.poles[np.abs(plant.poles) > 1e-6 * rate])
    slow, fast = (float(speed.min()), float(speed.max())) if speed.size else (rate, rate)
    low, high = max(slow, rate * 1e-3) / 40, min(fast, rate * 1e3) * 2
    shown = min(plant.p, 3)
    weighed = plant.C / size[:, None]
    names = tuple(text("output {name}", name=signal_name(plant, n)) for n in plant.output_names[:shown])
    dt = model.horizon / 200
    return Case(model.id, model.label, model, plant, G, weighed.T @ weighed, np.eye(plant.m) / model.u_max**2,
                np.eye(G.shape[1]) * model.u_max**2 / rate, np.diag((SENSOR_ERROR_SHARE * size) ** 2) / rate,
                weighed[:shown], names, _by_knobs, _one, "", 1.0, model.input_unit, 1.0,
                _grid(plant, low, high, 150), (low, high), low * 2, np.geomspace(low / 10, high * 10, 140), dt, model.horizon,
                dt / 4, model.horizon, 4096 * dt)
