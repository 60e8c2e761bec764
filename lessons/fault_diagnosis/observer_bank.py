"""Build the deck, its disturbances, the filter of the loop, and the bank of seven observers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.engine import KalmanFilter, dlqr, residual_generator
from observer_lab.engine.observers import FaultBank, ResidualGenerator
from observer_lab.engine.systems import discretise
from observer_lab.plants import MODELS
from observer_lab.plants.platform.model import SENSOR_IDS, Parameters, deck, deck_disturbance
from observer_lab.text import text

MODEL = MODELS["deck"]
DT, SAMPLE_COUNT = 0.02, 601  # s and samples: 12 s
HORIZON = DT * (SAMPLE_COUNT - 1)
SENSOR_SIGMA = 1e-3  # m/s, noise of a reading
GROUND_INTENSITY = 4e-10  # m² s, intensity of each ground motion
DRAUGHT = 3e-4  # N² s, intensity of an unknown force that presses one side down and the other up
COIL_IDS = ("u1", "u2", "u3")
FAULT_PLACES = (*SENSOR_IDS, *COIL_IDS)
MEMBER_NAMES = ("−VL", "−HL", "−VR", "−HR", "−u1", "−u2", "−u3")
Q_WEIGHT = 1e5  # of the outputs, against 1 for the inputs


@lru_cache(maxsize=1)
def model() -> KalmanFilter:
    """The filter that knows the deck, its disturbances and its sensors' noise as they are: one sample of DT."""
    B = MODEL.plant.B
    G = np.column_stack([deck_disturbance(), B[:, 1] - B[:, 0]])
    return KalmanFilter.from_plant(
        MODEL.plant, np.diag([GROUND_INTENSITY, GROUND_INTENSITY, DRAUGHT]), SENSOR_SIGMA**2 * DT * np.eye(4), dt=DT, G=G
    )


@dataclass(frozen=True, eq=False)
class Guard:
    """The bank, and the filter on all four sensors that the loop starts with."""

    bank: FaultBank
    whole: ResidualGenerator


@lru_cache(maxsize=1)
def guard() -> Guard:
    """Four members that each leave out one sensor, three that each ignore one coil."""
    kf = model()
    sensors = [residual_generator(kf, name=name, outputs=[j for j in range(4) if j != i])
               for i, name in enumerate(MEMBER_NAMES[:4])]
    coils = [residual_generator(kf, name=name, E=kf.B[:, [j]]) for j, name in enumerate(MEMBER_NAMES[4:])]
    return Guard(FaultBank(kf, (*sensors, *coils)), residual_generator(kf, name="all"))


@lru_cache(maxsize=8)
def gain(without: int | None = None) -> np.ndarray:
    """K (3×6) of the sampled regulator, with a row of zeros for the coil that is no longer used."""
    kf = model()
    used = [j for j in range(3) if j != without]
    K = np.zeros((3, 6))
    K[used] = dlqr(kf.A, kf.B[:, used], Q_WEIGHT * kf.C.T @ kf.C, np.eye(len(used))).gain
    return K


@lru_cache(maxsize=64)
def truth(stiffer: float) -> tuple[np.ndarray, np.ndarray]:
    """A and B of a deck whose vertical springs are stiffer by this share than the bank believes."""
    if stiffer == 0:
        return model().A, model().B
    real = discretise(deck(Parameters(kz=Parameters.kz * (1 + stiffer))), DT)
    return real.A, real.B


COIL_NAMES = (text("coil u1 (left)"), text("coil u2 (right)"),
              text("coil u3 (across)"))
SENSOR_NAMES = tuple(text("sensor {n}", n=n) for n in FAULT_PLACES[:4])
PLACE_NAMES = (*SENSOR_NAMES, *COIL_NAMES)
