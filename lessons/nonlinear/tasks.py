"""Define the tasks of lesson 14."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import Text, text

from .cases import FALL_CASE, PLATFORM
from .report_algorithms import NONE, REDRAW, WRONG_LINES
from .runs import Study

WELL_KNOWN = 0.6  # times the usual uncertainty: from there on the EKF is consistent on every seed tried
DEVIATION_ROUNDING = 1e-6  # in standard deviations


def _no(words: Text) -> Verdict:
    return Verdict(False, words)


def _linear(o: Outcome[Study]) -> Verdict:
    m = o.metrics
    if o.design["case"] != PLATFORM:
        return _no(text("This task is about the platform."))
    said = text("EKF and UKF stay within {apart_ekf:.1e} and {apart_ukf:.1e} σ of the KF",
                apart_ekf=m["apart_ekf"], apart_ukf=m["apart_ukf"])
    if max(m["apart_ekf"], m["apart_ukf"]) > DEVIATION_ROUNDING:
        return _no(text("{said}: that is more than rounding.", said=said))
    return Verdict(True, text("{said}: three names, one filter.", said=said))


def _small(o: Outcome[Study]) -> Verdict:
    m = o.metrics
    said = text("NEES per state: KF {nees_kf:.3g}, EKF {nees_ekf:.3g}",
                nees_kf=m["nees_kf"], nees_ekf=m["nees_ekf"])
    if o.design["case"] != PLATFORM or o.design["hardening"] < 0.6:
        return _no(text("The platform is wanted, with a hardening of at least 0.6."))
    if o.design["size"] > WELL_KNOWN:
        return _no(text("{said}; a few runs may flatter it. Make the start better known: 0.6 or less.", said=said))
    if not 0.6 <= m["nees_ekf"] <= 1.5:
        return _no(text("{said}; the EKF's should lie between 0.6 and 1.5.", said=said))
    if m["nees_kf"] < 3:
        return _no(text("{said}; the KF's should exceed 3, or nothing is shown.", said=said))
    return Verdict(True, text("{said}: the springs are nonlinear, and the EKF is consistent.", said=said))


def _deceived(o: Outcome[Study]) -> Verdict:
    m = o.metrics
    said = text("NEES per state: EKF {nees_ekf:.3g}, UKF {nees_ukf:.3g}",
                nees_ekf=m["nees_ekf"], nees_ukf=m["nees_ukf"])
    if o.design["case"] != FALL_CASE or o.design["size"] > 0.5:
        return _no(text("The falling body is wanted, with at most half the uncertainty of the start."))
    if m["nees_ekf"] < 100:
        return _no(text("{said}; the EKF is not yet wrong by a factor of 100.", said=said))
    if m["nees_ukf"] > 4:
        return _no(text("{said}; the UKF is over-confident as well.", said=said))
    return Verdict(True, text("{said}: a better start has not helped the EKF.", said=said))


def _report(o: Outcome[Study]) -> Verdict:
    line, m = o.design["line"], o.metrics
    if line == NONE:
        return _no(text("Choose a line of the report."))
    if line not in WRONG_LINES:
        return _no(text("That line holds."))
    if line != REDRAW:
        return _no(text("Open to objection, but with it a linear plant still gets its Kalman filter."))
    if m["apart_ekf"] > DEVIATION_ROUNDING or o.design["case"] != PLATFORM:
        return _no(text("The right line; now show it on the linear platform."))
    if m["apart_ukf"] < 1e-3:
        return _no(text("The right line; now run the algorithm as printed."))
    return Verdict(True, text("On a linear plant the printed UKF leaves the Kalman filter by up to "
                              "{apart_ukf:.2g} σ.",
                              apart_ukf=m["apart_ukf"]))


SQUARE = Typed("2*m*P/(4*m^2*P+R)", ("m", "P", "R"), slips=(
    ("P/(P+R)", text("That is a sensor that reads x itself; here the slope of x² at m counts.")),
    ("2*m*P/(2*m*P+R)", text("The slope enters the innovation's variance twice."))))
DRAG = Typed("-c^3*v^2*exp(-k*h)", ("c", "k", "h", "v"), slips=(
    ("c^3*v^2*exp(-k*h)", text("The size is right; the sign follows the order h, v, β of the state.")),
    ("c*v^2*exp(-k*h)", text("That is the last entry alone; the determinant has the two others of the triangle as factors."))))
BOUND_FORMULA = Typed("P*R/(R+4*N*P*(m^2+P))", ("m", "P", "R", "N"), slips=(
    ("P*R/(R+4*N*P*m^2)", text("That is the tangent at m; the bound takes the mean of x² over all truths, m² + P.")),
    ("R/(4*N*(m^2+P))", text("The prior knowledge is information too: 1/P."))))

TASKS = (
    Task("linear", _linear, {"case": PLATFORM, "hardening": 0.0, "weakening": 0.0}),
    Task("small", _small, {"case": PLATFORM, "hardening": 0.6, "size": 0.3}),
    Task("deceived", _deceived, {"size": 0.5}, easy="the best start that can be had does not help the EKF"),
    Task("report", _report, {"case": PLATFORM, "hardening": 0.0, "weakening": 0.0, "redraw": False, "line": REDRAW}),
    typed_task("square", SQUARE),
    typed_task("drag", DRAG),
    typed_task("least", BOUND_FORMULA),
)
