"""Define the tasks of lesson 4."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import text

from ..toolkit.figures import settle_time
from ..toolkit.knobs import untouched
from ..toolkit.tasks import check_gentle_settling
from .knobs import KNOBS, MODEL
from .study import Study

SPRING_ERROR_PERCENT, COMMAND_MM, PLAY_MM = 10.0, 3.0, 0.05  # of the task that follows a command
SETTLING_BAND_S, MAX_FORCE_N = (0.8, 0.9), 1.0  # s and N


def _pairs(*upper: complex) -> tuple[complex, ...]:
    return tuple(pole for p in upper for pole in (p, p.conjugate()))


FAST_POLES = tuple(complex(3.0 * p.real, p.imag) for p in (-4 + 5j, -4 - 5j, -5 + 6j, -5 - 6j, -6 + 7j, -6 - 7j))
RATIO_TOLERANCE = 0.06  # of the ratio 3
UNTOUCHED = MappingProxyType({k.name: k.check(k.default) for k in KNOBS if k.name in ("method", "controller_poles", "observer_poles")})
EAGER = MappingProxyType({"method": "poles", "controller_poles": _pairs(-14 + 3j, -4 + 7j, -12 + 4j),
         "observer_poles": _pairs(-18 + 5j, -8 + 9j, -3 + 11j)})
GENTLE = (-8.4 + 9.8j, -7 + 8.4j, -5.6 + 7j), (-9.75 + 6j, -8.25 + 5.25j, -6.75 + 4.5j)


def fast_observer(outcome: Outcome[Study]) -> Verdict:
    """The slowest observer pole at least three times as fast as the slowest controller pole."""
    m = outcome.metrics
    if m["slowest_controller"] >= 0 or m["slowest_observer"] >= 0:
        return Verdict(False, text("A pole is not in the left half plane."))
    ratio = m["slowest_observer"] / m["slowest_controller"]
    if abs(ratio - 3) <= RATIO_TOLERANCE:
        return Verdict(True, text("The slowest observer pole is {ratio:.1f} times as fast as the slowest "
                                  "controller pole.",
                                  ratio=ratio))
    return Verdict(False, text("The ratio of the slowest poles is {ratio:.2f}; it should be 3 within 2 %.",
                               ratio=ratio))


def _break_the_wall(outcome: Outcome[Study]) -> Verdict:
    """The meter at a tenth and a run that dies down, with every pole where the lesson put it."""
    if any(outcome.design[name] != value for name, value in UNTOUCHED.items()):
        return Verdict(False, text("Leave the poles of both boards where the lesson put them; Reset brings them back."))
    meter = outcome.metrics["separation_meter"]
    stable = outcome.metrics["slowest_loop"] < 0 and bool(outcome.metrics["dies_down"])
    if abs(meter - 0.1) <= 0.005 and stable:
        return Verdict(True, text("The meter reads {meter:.2f} and the loop is still stable.", meter=meter))
    if not stable:
        return Verdict(False, text("The run does not decay; go back a little."))
    return Verdict(False, text("The meter reads {meter:.2g}; bring it to 0.1 within 5 %.", meter=meter))


def _unstable_compensator(outcome: Outcome[Study]) -> Verdict:
    own = float(np.max(np.real(outcome.poles["compensator"])))
    if own > 0 and outcome.metrics["slowest_loop"] < 0:
        return Verdict(True, text("The compensator has a pole with real part {own:+.3g}, and the loop is stable "
                                  "all the same.",
                                  own=own))
    return Verdict(False, text("The compensator's rightmost pole is {own:.3g}; it must cross into the right half "
                               "plane while the loop stays stable.",
                               own=own))


def _gentle(outcome: Outcome[Study]) -> Verdict:
    """Every motion of the deck at rest within a band of time, with little force, from the lesson's start."""
    d, run = outcome.design, outcome.run
    if run is None or d["stiffness_error"] or d["delay"] or d["limited"] or d["noise"] or not untouched(d):
        return Verdict(False, text("Keep the model right: no delay, no limit, no noise, no kick, no pull."))
    times = [settle_time(run.t, np.abs(signal.of(run.x[:, :MODEL.plant.n]))) for signal in MODEL.watched]
    late, peak = max(np.inf if t is None else t for t in times), outcome.metrics["largest_input"]
    if not np.isfinite(late):
        return Verdict(False, text("The deck is not at rest by the end of the run."))
    found = text("All three motions are below 2 % after {late:.2f} s, and the largest force asked for is {peak:.3g} N",
                 late=late, peak=peak)
    return check_gentle_settling(found, late, SETTLING_BAND_S, peak, MAX_FORCE_N)


def _follow(outcome: Outcome[Study]) -> Verdict:
    """The height at the command at the end of the run, with wrong springs and the poles of the start."""
    d, height = outcome.design, outcome.metrics["at_the_end"]
    if any(d[name] != value for name, value in UNTOUCHED.items()):
        return Verdict(False, text("Leave the poles of both boards where the lesson put them; Reset brings them back."))
    if d["stiffness_error"] != SPRING_ERROR_PERCENT or d["command"] != COMMAND_MM:
        return Verdict(False, text("Set the stiffness error to {error:g} % and the command to {command:g} mm.", error=SPRING_ERROR_PERCENT,
                                   command=COMMAND_MM))
    gap = abs(height - COMMAND_MM)
    return Verdict(gap <= PLAY_MM, text("The height at the end of the run is {height:.3g} mm; at most {most:g} mm beside {command:g} mm is "
                                        "allowed.", height=height, most=PLAY_MM, command=COMMAND_MM))


SPRING = Typed("c^2*o^2/(c^2+o^2+4*c*o)", ("c", "o"), slips=(
    ("c^2", text("That is the stiffness of the state feedback; the estimate does not trust the reading alone.")),
    ("-c^2*o^2/(c^2+o^2+4*c*o)", text("The size is right; −u was asked for."))))

WRONG_BELIEF = Typed("(a+c)^2*f^2/(2*c*o*(c+o))", ("a", "c", "o", "f"), slips=(
    ("c^2*f^2/(2*c*o*(c+o))", text("The gain is K = a + c: it moves the pole from a to −c.")),
    ("(a+c)^2*f^2/(2*o)", text("That is ∫(Ke)² dt, the push; the plant answers it with its own pole −c."))))

TASKS = (
    Task("fast-observer", fast_observer, {"method": "poles", "observer_poles": FAST_POLES}),
    Task("break-the-wall", _break_the_wall, {"stiffness_error": 13.0}),
    Task("unstable-compensator", _unstable_compensator, EAGER),
    Task("gentle", _gentle, {"method": "poles", "controller_poles": _pairs(*GENTLE[0]), "observer_poles": _pairs(*GENTLE[1])}),
    Task("follow", _follow, {"stiffness_error": SPRING_ERROR_PERCENT, "command": COMMAND_MM, "integral": True}),
    typed_task("spring", SPRING),
    typed_task("wrong-belief", WRONG_BELIEF),
)
