"""The report's Algorithms 1 to 3 put to the test: lines in doubt, and the filter that Algorithm 3 gives on a linear plant."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from app.engine.filters import joseph
from app.text.words import Text

from .cases import case_of, flow_of, plant_of

NONE, SHORT, S_LINE, WEIGHTS, REDRAW, ALPHA = "none", "short", "S", "weights", "redraw", "alpha"
LINES = (
    (NONE, Text("none yet", "尚未选择")),
    (SHORT, Text("Algorithms 1 and 2: P = (I − KC) P⁻", "算法 1、2：P = (I − KC) P⁻")),
    (S_LINE, Text("Algorithm 2, line 10: S = H P⁻ Hᵀ + R", "算法 2 第 10 行：S = H P⁻ Hᵀ + R")),
    (WEIGHTS, Text("Algorithm 3, line 5: the weights", "算法 3 第 5 行：权重")),
    (REDRAW, Text("Algorithm 3, line 11: h of the moved points", "算法 3 第 11 行：对传播后的点取 h")),
    (ALPHA, Text("Appendix B.2: α of 10⁻³ to 10⁻¹", "附录 B.2：α 常取 10⁻³ 至 10⁻¹")),
)
SLIPS = frozenset((SHORT, REDRAW, ALPHA))
STEPS = 24  # samples of the linear comparison


def finding(line: str, gap: float) -> Text:
    """What the engine says about a line; `gap` is the distance of Algorithm 3 from the Kalman filter."""
    return {
        NONE: Text("choose a line", "请选择一行"),
        SHORT: Text("right for the optimal gain only; (59) and B.1 have Joseph's form",
                    "仅对最优增益正确；式 (59) 与 B.1 用的是 Joseph 形式"),
        S_LINE: Text("holds", "成立"),
        WEIGHTS: Text("hold: they sum to 1, and to 2 − α² + β", "成立：和分别为 1 与 2 − α² + β"),
        REDRAW: Text(f"wrong: Q is missing from P_xy and S; off by {gap:.2g} σ on a linear plant",
                     f"有误：P_xy 与 S 中缺少 Q；线性对象上相差 {gap:.2g} σ"),
        ALPHA: Text("unwise: with α = 10⁻³ the first weight is 1 − 10⁶", "不妥：α = 10⁻³ 时首个权重为 1 − 10⁶"),
    }[line]


@lru_cache(maxsize=64)
def linear_spreads(name: str, wind: float, sensor: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """σ of the first watched state on the plant made linear: of the Kalman filter, what Algorithm 3 believes, what it gets.

    Each (STEPS,) after the measurement. The last: the largest distance of the two gains, relative to the right one.
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
    out = np.empty((3, STEPS))
    apart = 0.0
    for k in range(STEPS):
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
