"""The tasks of lesson 4."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from app.lesson.lesson import Outcome, Task, Verdict, pencil
from app.lesson.typed import Typed
from app.text import text

from .knobs import KNOBS
from .study import Study


def _pairs(*upper: complex) -> tuple[complex, ...]:
    return tuple(pole for p in upper for pole in (p, p.conjugate()))


FAST = tuple(complex(3.0 * p.real, p.imag) for p in (-4 + 5j, -4 - 5j, -5 + 6j, -5 - 6j, -6 + 7j, -6 - 7j))
CLOSE = 0.06  # of the ratio 3
UNTOUCHED = MappingProxyType({k.name: k.check(k.default) for k in KNOBS if k.name in ("method", "controller_poles", "observer_poles")})
EAGER = MappingProxyType({"method": "poles", "controller_poles": _pairs(-14 + 3j, -4 + 7j, -12 + 4j),
         "observer_poles": _pairs(-18 + 5j, -8 + 9j, -3 + 11j)})


def fast_observer(outcome: Outcome[Study]) -> Verdict:
    """The slowest observer pole at least three times as fast as the slowest controller pole."""
    m = outcome.metrics
    ratio = m["slowest_observer"] / m["slowest_controller"]
    if m["slowest_controller"] >= 0 or m["slowest_observer"] >= 0:
        return Verdict(False, text("A pole is not in the left half plane."))
    if abs(ratio - 3) <= CLOSE:
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
        return Verdict(False, text("The run does not die down; go back a little."))
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


SPRING = Typed("c^2*o^2/(c^2+o^2+4*c*o)", ("c", "o"), slips=(
    ("c^2", text("That is the stiffness of the state feedback; the estimate does not trust the reading alone.")),
    ("-c^2*o^2/(c^2+o^2+4*c*o)", text("The size is right; −u was asked for."))))

TASKS = (
    Task("fast-observer", fast_observer, {"method": "poles", "observer_poles": FAST}),
    Task("break-the-wall", _break_the_wall, {"stiffness_error": 13.0}),
    Task("unstable-compensator", _unstable_compensator, EAGER),
    pencil("spring", SPRING),
)
