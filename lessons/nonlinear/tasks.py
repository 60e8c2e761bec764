"""Tasks of the lesson: back to linear, a start small enough, a filter that deceives itself, the report; and the exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .cases import FALL, PLATFORM
from .report import NONE, REDRAW, SLIPS
from .runs import Study

ROUNDING = 1e-6  # in standard deviations


def _no(en: str, zh: str) -> Verdict:
    return Verdict(False, Text(en, zh))


def _linear(o: Outcome[Study]) -> Verdict:
    m = o.metrics
    if o.design["case"] != PLATFORM:
        return _no("This task is about the platform.", "本题针对隔振平台。")
    said = (f"EKF and UKF stay within {m['apart_ekf']:.1e} and {m['apart_ukf']:.1e} σ of the KF",
            f"EKF、UKF 与 KF 最多相差 {m['apart_ekf']:.1e}、{m['apart_ukf']:.1e} σ")
    if max(m["apart_ekf"], m["apart_ukf"]) > ROUNDING:
        return _no(f"{said[0]}: that is more than rounding.", f"{said[1]}：超出了舍入误差。")
    return Verdict(True, Text(f"{said[0]}: three names, one filter.", f"{said[1]}：三个名字，一个滤波器。"))


def _small(o: Outcome[Study]) -> Verdict:
    m = o.metrics
    said = (f"NEES per state: KF {m['nees_kf']:.3g}, EKF {m['nees_ekf']:.3g}",
            f"每个状态的 NEES：KF {m['nees_kf']:.3g}，EKF {m['nees_ekf']:.3g}")
    if o.design["case"] != PLATFORM or o.design["hardening"] < 0.5:
        return _no("The platform is wanted, with a hardening of at least 0.5.", "要求隔振平台，且硬化系数不小于 0.5。")
    if not 0.6 <= m["nees_ekf"] <= 1.5:
        return _no(f"{said[0]}; the EKF's should lie between 0.6 and 1.5.", f"{said[1]}；EKF 应在 0.6 与 1.5 之间。")
    if m["nees_kf"] < 3:
        return _no(f"{said[0]}; the KF's should exceed 3, or nothing is shown.", f"{said[1]}；KF 应大于 3，否则说明不了问题。")
    return Verdict(True, Text(f"{said[0]}: bent springs, an honest EKF.", f"{said[1]}：弹簧是弯的，EKF 却是诚实的。"))


def _deceived(o: Outcome[Study]) -> Verdict:
    m = o.metrics
    said = (f"NEES per state: EKF {m['nees_ekf']:.3g}, UKF {m['nees_ukf']:.3g}",
            f"每个状态的 NEES：EKF {m['nees_ekf']:.3g}，UKF {m['nees_ukf']:.3g}")
    if o.design["case"] != FALL or o.design["size"] > 0.5:
        return _no("The falling body is wanted, with at most half the uncertainty of the start.",
                   "要求下落体，且初始不确定度不超过一半。")
    if m["nees_ekf"] < 100:
        return _no(f"{said[0]}; the EKF is not yet wrong by a factor of 100.", f"{said[1]}；EKF 还没有错到 100 倍。")
    if m["nees_ukf"] > 4:
        return _no(f"{said[0]}; the UKF is lost as well.", f"{said[1]}；UKF 也失效了。")
    return Verdict(True, Text(f"{said[0]}: a better start has not helped the EKF.", f"{said[1]}：初值更准并没有帮到 EKF。"))


def _report(o: Outcome[Study]) -> Verdict:
    line, m = o.design["line"], o.metrics
    if line == NONE:
        return _no("Choose a line of the report.", "请选择报告中的一行。")
    if line not in SLIPS:
        return _no("That line holds.", "这一行成立。")
    if line != REDRAW:
        return _no("Open to objection, but with it a linear plant still gets its Kalman filter.",
                   "确有可议之处，但它仍能在线性对象上得到卡尔曼滤波器。")
    if m["apart_ekf"] > ROUNDING or o.design["case"] != PLATFORM:
        return _no("The right line; now show it on the linear platform.", "选对了；请在线性的隔振平台上证明。")
    if m["apart_ukf"] < 1e-3:
        return _no("The right line; now run the algorithm as printed.", "选对了；请按印出的算法运行。")
    return Verdict(True, Text(f"On a linear plant the printed UKF leaves the Kalman filter by up to {m['apart_ukf']:.2g} σ.",
                              f"在线性对象上，印出的 UKF 与卡尔曼滤波器最多相差 {m['apart_ukf']:.2g} σ。"))


def exam(seed: int) -> ExamItem:
    """The mean of a x² that sigma points find, a (m² + P)."""
    rng = np.random.default_rng(seed)
    a, m, P = int(rng.integers(2, 6)), int(rng.integers(1, 8)), float(rng.integers(1, 13)) / 4
    return ExamItem({"a": str(a), "m": str(m), "P": f"{P:g}"}, a * (m * m + P), 0.01)


TASKS = (
    Task("linear", _linear, {"case": PLATFORM, "hardening": 0.0, "weakening": 0.0}),
    Task("small", _small, {"case": PLATFORM, "hardening": 0.6, "size": 0.3}),
    Task("deceived", _deceived, {"size": 0.5}),
    Task("report", _report, {"case": PLATFORM, "hardening": 0.0, "weakening": 0.0, "redraw": False, "line": REDRAW}),
)
