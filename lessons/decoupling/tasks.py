"""Define the tasks of lesson 11."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import Text, text

from .loops import BEST_MIX, BY_GAIN, BY_POLES, NO_MIX, OPEN_LOOP, SHAPED_LOOP, WHITE, close, lower_of, rightmost
from .sensors import GEOPHONE, Sensors
from .study import Study

AS_WELL = (93.0, 94.0)  # dB: the published C_v gives 93.5
TENFOLD = 10.0
FAR_ABOVE = 500.0  # Hz: a roll-off from there on is not felt at 10 Hz
CLAIMED = 0.5  # rad/s
MAX_UNAMPLIFIED, MAX_GAIN = 1.001, 88.0  # times the ground's motion; N s/m, a tenth more than the 79.6 that are needed
LEAST_CORNER, LEAST_VERTICAL, MAX_AMPLIFICATION = 0.1, 48.0, 2.0  # Hz, dB, times the ground's motion
LEAST_DRIFT = 0.1  # rad/s: growth by e in ten seconds
MIN_BANDWIDTH, LEAST_ROTATION, LEAST_HORIZONTAL = 1.0, 25.0, 15.0


def _constant(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    got = m["vertical"]
    if d["vertical"] != SHAPED_LOOP:
        return Verdict(False, text("Shape the vertical controller yourself."))
    if d["ground"] != WHITE:
        return Verdict(False, text("Take the white ground; on the falling one the published C_v gives less."))
    if not AS_WELL[0] <= got <= AS_WELL[1]:
        return Verdict(False, text("The vertical peak comes down by {got:.1f} dB; the published C_v gives 93.5 dB.",
                                   got=got))
    if m["rightmost"] >= 0 or m["drift"] > 0:
        worst = max(m["rightmost"], m["drift"])
        return Verdict(False, text("There is still a pole at {worst:+.2g} rad/s.", worst=worst))
    if d["lag"] > 0 or d["lead"] > 0 or d["roll_off"] < FAR_ABOVE:
        return Verdict(True, text("The peak comes down by {got:.1f} dB and no pole is on the right; a gain without lag, lead and "
                                  "early roll-off would do.", got=got))
    return Verdict(True, text("The gain {gain_v:.0f} N s/m alone brings the peak down by {got:.1f} dB, and no "
                              "pole is on the right.",
                              gain_v=d["gain_v"], got=got))


def _mixing(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    factor = m["J_plain"] / max(m["J"], 1e-300)
    band = text("{f_low:g} to {f_high:g} Hz", f_low=d["f_low"], f_high=d["f_high"])
    if d["mix"] == NO_MIX:
        return Verdict(False, text("Nothing is mixed yet: a = b = 0."))
    if d["f_high"] < 3 * d["f_low"]:
        return Verdict(False, text("Keep the band at least as wide as one to three."))
    if factor < TENFOLD:
        return Verdict(False, text("From {band} J is 1/{factor:.2g} of its value without mixing; one tenth is "
                                   "asked.",
                                   band=band, factor=factor))
    return Verdict(True, text("From {band} J is 1/{factor:.3g} of its value without mixing.",
                              band=band, factor=factor))


def _claim(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if not d["pitch"] or d["bandwidth"] > CLAIMED * (1 + 1e-9):
        return Verdict(False, text("Close the pitch loop with a bandwidth of at most 0.5 rad/s."))
    if m["rightmost_pitch_open"] >= 0:
        return Verdict(False, text("This loop is unstable with pitch open already; that proves nothing."))
    if m["rightmost"] < 0:
        return Verdict(False, text("The loop stays stable: rightmost pole {rightmost:.3g} rad/s. Try another C_h.",
                                   rightmost=m["rightmost"]))
    return Verdict(True, text("Pitch open: {rightmost_pitch_open:.2g} rad/s. Closed at {bandwidth:g} rad/s: "
                              "{rightmost:+.2g} rad/s. The claim is true for this C_h.",
                              rightmost_pitch_open=m["rightmost_pitch_open"], bandwidth=d["bandwidth"],
                              rightmost=m["rightmost"]))


def _close(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["horizontal"] != BY_POLES or not d["pitch"] or d["bandwidth"] < MIN_BANDWIDTH:
        return Verdict(False, text("Place the horizontal poles yourself and close pitch at 1 rad/s or more."))
    if m["rightmost"] >= 0:
        return Verdict(False, text("The loop is unstable: rightmost pole {rightmost:+.3g} rad/s.",
                                   rightmost=m["rightmost"]))
    both = text("Rotation {rotation:.1f} dB, horizontal {horizontal:.1f} dB",
                rotation=m["rotation"], horizontal=m["horizontal"])
    if m["rotation"] < LEAST_ROTATION or m["horizontal"] < LEAST_HORIZONTAL:
        return Verdict(False, text("{both}; asked are {least_rotation:g} and {least_horizontal:g} dB.",
                                   both=both, least_rotation=LEAST_ROTATION, least_horizontal=LEAST_HORIZONTAL))
    return Verdict(True, text("{both}, with all three loops closed and stable.", both=both))


def _pure_gain(outcome: Outcome[Study]) -> Text | None:
    """What keeps the vertical loop from being a stable pure gain, None if it is one."""
    d, m = outcome.design, outcome.metrics
    if d["vertical"] != SHAPED_LOOP or d["lag"] > 0 or d["lead"] > 0 or d["roll_off"] < FAR_ABOVE:
        return text("Shape the vertical loop as a pure gain, without lag, lead or early roll-off.")
    if m["rightmost"] >= 0:
        return text("The loop is unstable: rightmost pole {rightmost:+.3g} rad/s.", rightmost=m["rightmost"])
    return None


def _isolate(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if (hint := _pure_gain(outcome)) is not None:
        return Verdict(False, hint)
    most = m["amplification_vertical"]
    if most > MAX_UNAMPLIFIED:
        return Verdict(False, text("The vertical transmissibility reaches {most:.4g}.", most=most))
    if d["gain_v"] > MAX_GAIN:
        return Verdict(False, text("{gain:.4g} N s/m is more than needed; at most {most:g} are allowed.", gain=d["gain_v"], most=MAX_GAIN))
    return Verdict(True, text("With {gain:.4g} N s/m the transmissibility reaches {most:.4g} at most.", gain=d["gain_v"], most=most))


def _geophone(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["sensors"] != GEOPHONE or d["corner"] < LEAST_CORNER * (1 - 1e-9):
        return Verdict(False, text("Use geophones with a corner at 0.1 Hz or above."))
    if d["ground"] != WHITE:
        return Verdict(False, text("Take the white ground."))
    if (hint := _pure_gain(outcome)) is not None:
        return Verdict(False, hint)
    most, down = m["amplification_vertical"], m["vertical"]
    if most > MAX_AMPLIFICATION or down < LEAST_VERTICAL:
        return Verdict(False, text("The peak falls by {down:.1f} dB and the transmissibility reaches {most:.3g}; asked are at least "
                                   "{least:g} dB and at most {limit:g}.", down=down, most=most, least=LEAST_VERTICAL,
                                   limit=MAX_AMPLIFICATION))
    return Verdict(True, text("The peak falls by {down:.1f} dB, and the transmissibility reaches {most:.3g} at most.",
                              down=down, most=most))


def _tilt(outcome: Outcome[Study]) -> Verdict:
    m, d, s = outcome.metrics, outcome.design, outcome.study
    if d["sensors"] != GEOPHONE or not d["tilt"]:
        return Verdict(False, text("Use geophones that react to tilt."))
    if d["vertical"] != OPEN_LOOP or d["horizontal"] != BY_GAIN or d["pitch"]:
        return Verdict(False, text("Close the horizontal loop alone, by a pure gain."))
    level = Sensors(d["corner"])
    without, right = rightmost(close(s.controllers.whole, lower=lower_of(d), sensors=level), s.controllers.whole)[0], m["rightmost"]
    if without >= 0:
        return Verdict(False, text("Without tilt this loop is unstable too; that proves nothing."))
    if right < LEAST_DRIFT:
        return Verdict(False, text("With tilt the rightmost pole lies at {right:+.3g} rad/s; +0.1 or more is asked.", right=right))
    return Verdict(True, text("Without tilt {without:.2g} rad/s, with tilt {right:+.2g} rad/s: tilt alone makes this loop unstable.",
                              without=without, right=right))


NEAR_THE_ZEROS = (-0.3 + 7.42j, -0.3 - 7.42j)


ZERO_FREQUENCY = Typed("sqrt(k/(J+m*h^2))", ("J", "m", "h", "k"), slips=(
    ("sqrt(k/J)", text("That is the pitch about the centre of mass; while the line stands still the deck turns about the line.")),
    ("k/(J+m*h^2)", text("That is its square."))))

TASKS = (
    Task("constant", _constant, MappingProxyType({"vertical": SHAPED_LOOP, "gain_v": 31250.0, "lag": 0.0, "lead": 0.0})),
    Task("mixing", _mixing, MappingProxyType({"mix": BEST_MIX, "f_low": 2.0, "f_high": 10.0})),
    Task("claim", _claim, MappingProxyType({"horizontal": BY_POLES, "pitch": True, "bandwidth": 0.5})),
    Task("close-pitch", _close, MappingProxyType({
        "horizontal": BY_POLES, "pitch": True, "bandwidth": 5.0, "control_poles": (-20 + 15j, -20 - 15j, *NEAR_THE_ZEROS),
        "observer_poles": (-60 + 45j, -60 - 45j, *NEAR_THE_ZEROS)})),
    Task("isolate", _isolate, MappingProxyType({"vertical": SHAPED_LOOP, "gain_v": 80.0})),
    Task("geophone", _geophone, MappingProxyType({"vertical": SHAPED_LOOP, "gain_v": 350.0, "horizontal": OPEN_LOOP,
                                                  "sensors": GEOPHONE})),
    Task("tilt", _tilt, MappingProxyType({"vertical": OPEN_LOOP, "horizontal": BY_GAIN, "gain_h": 500.0, "lower": -5.0,
                                          "sensors": GEOPHONE, "tilt": True})),
    typed_task("zero", ZERO_FREQUENCY),
)
