"""Check the report's Algorithms 1 to 3, and run Algorithm 3 on a linear plant."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from observer_lab.engine.filters import joseph
from observer_lab.text import Text, text

from .cases import case_of, flow_of, plant_of

NONE, SHORT_FORM_LINE, S_LINE, WEIGHTS_LINE, REDRAW, ALPHA = "none", "short", "S", "weights", "redraw", "alpha"
REPORT_LINES = (
    (NONE, text("none yet")),
    (SHORT_FORM_LINE, text("Algorithms 1 and 2: P = (I − KC) P⁻")),
    (S_LINE, text("Algorithm 2, line 10: S = H P⁻ Hᵀ + R")),
    (WEIGHTS_LINE, text("Algorithm 3, line 5: the weights")),
    (REDRAW, text("Algorithm 3, line 11: h of the moved points")),
    (ALPHA, text("Appendix B.2: α of 10⁻³ to 10⁻¹")),
)
WRONG_LINES = frozenset((SHORT_FORM_LINE, REDRAW, ALPHA))
COMPARED_STEPS = 24  # samples of the linear comparison


def finding(line: str, gap: float) -> Text:
    """What the engine says about a line; `gap` is the distance of Algorithm 3 from the Kalman filter."""
    return {
        NONE: text("choose a line"),
        SHORT_FORM_LINE: text("right for the optimal gain only; (59) and B.1 have Joseph's form"),
        S_LINE: text("holds"),
        WEIGHTS_LINE: text("hold: they sum to 1, and to 2 − α² + β"),
        REDRAW: text("wrong: Q is missing from P_xy and S; off by {gap:.2g} σ on a linear plant", gap=gap),
        ALPHA: text("unwise: with α = 10⁻³ the first weight is 1 − 10⁶"),
    }[line]


@lru_cache(maxsize=64)
def linear_spreads(name: str, wind: float, sensor: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """σ of the first watched state on the plant made linear: of the Kalman filter, what Algorithm 3 believes, what it gets.

    Each (COMPARED_STEPS,) after the measurement. The last: the largest distance of the two gains, relative to the right one.
    P⁻ = A P Aᵀ + Q in both; the gain of Algorithm 3 comes from A P Aᵀ alone, and the error that it really leaves is
    Joseph's form with that gain.
    """
    case = case_of(name)
    plant = plant_of(name, 0.0, 0.0)
    rest = case.guess[:, None]
    A = flow_of(case, plant).expand(rest, np.zeros((plant.m, 1)))[1][0]
    C = plant.output_slope(rest, np.zeros((plant.m, 1)))[0]
    Q, R = wind * case.Q, sensor**2 * case.R
    right = believed = real = np.diag(case.spread**2)
    out = np.empty((3, COMPARED_STEPS))
    apart = 0.0
    for k in range(COMPARED_STEPS):
        carried = believed if k == 0 else A @ believed @ A.T
        added = 0.0 if k == 0 else Q
        prior, truth = (P if k == 0 else A @ P @ A.T + Q for P in (right, real))
        best = np.linalg.solve(C @ prior @ C.T + R, C @ prior).T
        S = C @ carried @ C.T + R
        M = np.linalg.solve(S, C @ carried).T
        right, real = joseph(prior, C, R, best), joseph(truth, C, R, M)
        believed = carried + added - M @ S @ M.T
        out[:, k] = [np.sqrt(max(P[case.state, case.state], 0.0)) for P in (right, believed, real)]
        apart = max(apart, float(np.abs(M - best).max() / np.abs(best).max()))
    return out[0], out[1], out[2], apart
