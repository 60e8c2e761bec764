"""Find Q and R from a data sheet and the sampling period, and compare prediction and current estimate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine import KalmanFilter
from observer_lab.text import format_number, same, text

from .filters import SENSOR_SIGMA
from .knobs import DT, MODEL, VZ_INDEX
from .study import S

SHEET_TAB = text("Data sheet")
MM = 1e3  # mm in a m
STATE_LABELS = ("x [mm]", "z [mm]", "θ [mrad]", "vx [mm/s]", "vz [mm/s]", "ω [mrad/s]")


@dataclass(frozen=True, eq=False)
class Sheet:
    """What a data sheet gives at a sampling period. R_density and R_step in (m/s)², Q (n, n); σ of v_z before and after a reading."""

    R_density: float
    R_step: float
    Q: np.ndarray
    euler: float
    sigma_prior: float
    sigma_after: float

    @property
    def R(self) -> float:
        """Of one reading: independent noises add."""
        return self.R_density + self.R_step

    @property
    def r(self) -> float:
        """Over the true R of this lesson."""
        return self.R / SENSOR_SIGMA**2


@lru_cache(maxsize=16)
def sheet_of(density: float, step: float, push: float, period: float) -> Sheet:
    """Densities are one-sided, in mm/s and N per √Hz, the quantisation step in mm/s, the period in s.

    A reading averaged over T has the variance n²/(2T); rounding to Δ adds Δ²/12. The force has the intensity d²/2; Van Loan's
    exponential gives its covariance over one period.
    """
    V, R_step = (density / MM) ** 2 / 2, (step / MM) ** 2 / 12
    G = (MODEL.plant.B[:, 0] + MODEL.plant.B[:, 1])[:, None] / 2  # one vertical force, shared by both coils' places
    kf = KalmanFilter.from_plant(MODEL.plant, np.array([[push**2 / 2]]), (V + R_step * period) * np.eye(4), dt=period, G=G)
    steady = kf.steady
    sigmas = [float(np.sqrt(P[VZ_INDEX, VZ_INDEX])) for P in (steady.solution, steady.filtered)]
    return Sheet(V / period, R_step, kf.Q, float(G[VZ_INDEX, 0]) ** 2 * push**2 / 2 * period, *sigmas)


def sheet_in(design: Design) -> Sheet:
    """At the knobs of a design."""
    return sheet_of(design["density"], design["step"], design["push"], design["period"])


def sheet_figure(outcome: Outcome[S]) -> TableFigure:
    """R and Q from the data sheet, and the filter that they make."""
    s, T = sheet_in(outcome.design), outcome.design["period"]

    def squared(value: float) -> str:
        return format_number(value * MM**2, ".3g")
    rows = (
        (text("R from noise density, n²/(2T)"), squared(s.R_density), "mm²/s²"),
        (text("R from quantisation, Δ²/12"), squared(s.R_step), "mm²/s²"),
        (text("R of one reading"), squared(s.R), "mm²/s²"),
        (text("r, for sensors of this sheet: R / true R"), format_number(s.r, ".3g"), ""),
        (text("Q of v_z over one period, Van Loan"), squared(float(s.Q[VZ_INDEX, VZ_INDEX])), "mm²/s²"),
        (text("the same by the short rule W T"), squared(s.euler), "mm²/s²"),
        (text("σ of v_z before a reading"), format_number(MM * s.sigma_prior, ".3g"), "mm/s"),
        (text("σ of v_z after it"), format_number(MM * s.sigma_after, ".3g"), "mm/s"),
    )
    return TableFigure("sheet", text("from data sheet to Q and R"), (text("quantity"), text("value"), text("unit")), rows, tab=SHEET_TAB,
                       caption=text("At a sampling period of {T:.3g} s. A longer period makes the R of the density smaller and Q larger.",
                                    T=T))


def estimators_figure(outcome: Outcome[S]) -> TableFigure:
    """σ that the settled filter expects of the prediction x̂(k|k−1) and of the current estimate x̂(k|k)."""
    steady, kf = outcome.study.watcher.steady, outcome.study.watcher.filter
    before, after = (MM * np.sqrt(np.maximum(np.diag(P)[:6], 0.0)) for P in (steady.solution, steady.filtered))
    rows = tuple((name, format_number(a, ".3g"), format_number(b, ".3g"), format_number(b / a, ".3g") if a > 0 else "–")
                 for name, a, b in zip(STATE_LABELS, before, after, strict=True))
    L = kf.A @ steady.filter_gain
    return TableFigure(
        "estimators", text("prediction and current estimate, settled"),
        (text("state"), same("σ x̂(k|k−1)"), same("σ x̂(k|k)"), text("ratio")), rows, tab=SHEET_TAB,
        caption=text("Gain from VL to vz: L = A·M has {L:.3g} for the prediction, M has {M:.3g} for the current estimate. A controller "
                     "on the prediction uses readings that are {T:g} s older.",
                     L=L[VZ_INDEX, 0], M=steady.filter_gain[VZ_INDEX, 0], T=DT))
