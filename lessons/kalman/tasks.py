"""Define the tasks of lesson 9, judged over all records and not by one draw."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import Text, text

from .all_records import Expected, expected
from .data_sheet import MM
from .filters import SENSOR_SIGMA
from .knobs import DT, NEAR_R, NONE, WRONG_LINES
from .study import Study

ENOUGH = 0.5  # share of the records that counts as found out
NIS_BAND, MAX_FLAGGED_SHARE = (1.9, 2.1), 0.02  # NIS over all records, and the share of them that whiteness may flag


def _expected(o: Outcome[Study]) -> Expected:
    return expected(o.design["noise"], o.design["q"], o.design["r"])


def _said(e: Expected) -> Text:
    return text("Over all records NIS averages {nis:.3g}, NEES {nees:.3g}, and whiteness flags {flagged:.0f} %",
                nis=e.nis, nees=e.nees, flagged=100 * e.flagged)


def _tune(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] != "white":
        return Verdict(False, text("This task is about white sensor noise."))
    e = _expected(o)
    said = _said(e)
    if not e.right:
        return Verdict(False, text("{said}: at least one test flags this filter.", said=said))
    return Verdict(True, text("{said}: no test flags it.", said=said))


def _decoy(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] != "white" or o.design["q"] < 5:
        return Verdict(False, text("q = {q:.3g}; white sensor noise and q of at least 5 are wanted.",
                                   q=o.design["q"]))
    e = _expected(o)
    said = _said(e)
    if not e.nis_holds:
        return Verdict(False, text("{said}: NIS flags it already.", said=said))
    if e.flagged < ENOUGH:
        return Verdict(False, text("{said}: the innovations mostly look white.", said=said))
    return Verdict(True, text("{said}: NIS does not flag it; the whiteness test does.", said=said))


def _converter(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] == "white":
        return Verdict(False, text("Switch the sensor noise to the converter."))
    e = _expected(o)
    said = _said(e)
    if not e.right:
        return Verdict(False, text("{said}: the noise of the converter is still visible.", said=said))
    return Verdict(True, text("{said}: the coloured noise is now a state.", said=said))


def _report(o: Outcome[Study]) -> Verdict:
    line = o.design["line"]
    if line == NONE:
        return Verdict(False, text("Choose a line of the report."))
    if line not in WRONG_LINES:
        return Verdict(False, text("That line holds."))
    if line != NEAR_R:
        return Verdict(False, text("A line in doubt indeed, but not about what a converged filter's innovations "
                                   "should look like."))
    e = _expected(o)
    if not e.right:
        return Verdict(False, text("The right line; now show it with a filter that no test finds out."))
    return Verdict(True, text("Tuned, and yet the innovations have {over_r:.2f} R over all records; S is {s_over_r:.2f} R.",
                              over_r=e.over_R, s_over_r=e.S_over_R))


def _shy(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] != "white":
        return Verdict(False, text("This task is about white sensor noise."))
    e = _expected(o)
    found = text("Over all records NIS averages {nis:.3g} and whiteness flags {flagged:.2f} %", nis=e.nis, flagged=100 * e.flagged)
    if not NIS_BAND[0] <= e.nis <= NIS_BAND[1] or e.flagged > MAX_FLAGGED_SHARE:
        return Verdict(
            False,
            text(
                "{found}; wanted are {low:g} to {high:g} and at most {most:g} %.",
                found=found,
                low=NIS_BAND[0],
                high=NIS_BAND[1],
                most=100 * MAX_FLAGGED_SHARE,
            ),
        )
    return Verdict(True, text("{found}; NEES averages {nees:.2f} of 6: only its covariance is too large.", found=found, nees=e.nees))


SECOND_SENSOR = Typed("P*r/(P*r+(P+r)*s)", ("P", "r", "s"), slips=(
    ("P/(P+s)", text("After the first reading the variance is no longer P.")),
    ("r/(r+s)", text("That leaves out the uncertainty before the reading: P."))))

SHEET_R, SHEET_ACCURACY = 0.2**2 / (2 * DT) + 1 / 12, 0.02  # mm²/s² of the sensor that the task describes; how well it is known


def _sheet(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] != "white":
        return Verdict(False, text("This task is about white sensor noise."))
    believed = o.design["r"] * (MM * SENSOR_SIGMA) ** 2
    found = text("The filter assumes R = {believed:.3g} mm²/s²", believed=believed)
    if abs(believed / SHEET_R - 1) > SHEET_ACCURACY:
        return Verdict(False, text("{found}; the data sheet gives another value.", found=found))
    return Verdict(True, text("{found}, as the data sheet says.", found=found))


LATE = Typed("a^2*M*p", ("a", "M", "p"), slips=(
    ("M*p", text("That is what the reading takes away; the plant then multiplies the error by a.")),
    ("a^2*(1-M)*p", text("That part remains with the current estimate, too."))))

TASKS = (
    Task("tune", _tune, {"q": 1.0, "r": 1.0}),
    Task("decoy", _decoy, {"q": 20.0, "r": 0.47}),
    Task("converter", _converter, {"noise": "carried", "q": 1.0, "r": 1.0}),
    Task("report", _report, {"q": 1.0, "r": 1.0, "line": NEAR_R}),
    Task("shy", _shy, {"q": 2.0, "r": 2.0}),
    typed_task("second-sensor", SECOND_SENSOR),
    Task("sheet", _sheet, {"r": 0.583}),
    typed_task("late", LATE),
)
