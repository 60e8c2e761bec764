"""Define the tasks of lesson 13."""

from __future__ import annotations

from dataclasses import replace

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import format_number, text

from .controllers import DT, LQE, ORDER, SISO
from .simulation import loop_of
from .study import Study
from .suppression import WANTED_SUPPRESSION_DB, transmissibility

BEST_SENSOR = 1e-11  # (m/s)² s: the quietest that can be bought in the first task
MIN_LEAD_DB = 10.0  # dB by which the optimum is to be beaten
DELAY_TOLERANCE_MS = 0.2  # ms within which the least delay is to be found
KEPT_SUPPRESSION_DB = 12.0  # dB that the full LQG is to keep while the SISO pair is lost
MODEL_ERRORS = ("stiffness", "damping", "placement")  # of the model
UNTOUCHED = (*MODEL_ERRORS, "delay", "drift", "adc", "limited")  # zero or off at the start
CHANNEL_NAMES = ("vertical", "rotation", "horizontal")
TRUE_SENSOR, COARSE, INTENSITY_RTOL = 1e-10, 1000.0, 0.05  # of the start, (m/s)² s; µm/s; share by which V may be off
MIN_SUPPRESSION_DB, MAX_FORCE_MN = 21.0, 32.0  # dB, mN
MAX_TRANSMISSIBILITY, MAX_COOL_MN = 1.1, 24.0  # times the ground's motion; mN RMS that a coil gives without getting hot


def _band(outcome: Outcome[Study], player: str) -> list[float]:
    return [outcome.metrics[f"{player}_{channel}_band_db"] for channel in CHANNEL_NAMES]


def _words(values: list[float]) -> str:
    return " / ".join(format_number(v, ".1f") for v in values)


def _twenty(outcome: Outcome[Study]) -> Verdict:
    d, m, got = outcome.design, outcome.metrics, _band(outcome, "lqe")
    if d["sensor"] < BEST_SENSOR * (1 - 1e-9) or d["ground"] != "white":
        return Verdict(False, text("V₀ = {sensor:.1e}: no better sensors than 10⁻¹¹ are for sale, and the ground "
                                   "is white.",
                                   sensor=d["sensor"]))
    if any(d[error] for error in MODEL_ERRORS):
        return Verdict(False, text("The plant must equal the design model: leave the errors of stiffness, damping and placement at 0."))
    if not m["lqe_stable"] or min(got) < WANTED_SUPPRESSION_DB:
        return Verdict(False, text("Vertical, rotation, horizontal: {got} dB; {wanted:g} dB are wanted in each.",
                                   got=_words(got), wanted=WANTED_SUPPRESSION_DB))
    return Verdict(True, text("{got} dB: more than {wanted:g} dB in every channel.", got=_words(got), wanted=WANTED_SUPPRESSION_DB))


def _beaten(outcome: Outcome[Study]) -> Verdict:
    m, siso, lqg = outcome.metrics, _band(outcome, "siso"), _band(outcome, "lqe")
    if not (m["siso_stable"] and m["lqe_stable"]):
        return Verdict(False, text("Both loops must be stable."))
    ahead = [a - b for a, b in zip(siso, lqg, strict=True)]
    if min(ahead) < MIN_LEAD_DB:
        return Verdict(False, text("The SISO loops are ahead by {ahead} dB; {ahead2:g} dB are wanted in every "
                                   "channel.",
                                   ahead=_words(ahead), ahead2=MIN_LEAD_DB))
    if min(ahead) > MIN_LEAD_DB + 1:
        return Verdict(False, text("Ahead by {ahead} dB: more than is wanted, {least:g} to {most:g} dB where the lead is least.",
                                   ahead=_words(ahead), least=MIN_LEAD_DB, most=MIN_LEAD_DB + 1))
    return Verdict(True, text("Ahead by {ahead} dB: the LQG is optimal for noise that is not there.",
                              ahead=_words(ahead)))


def _holds_without(outcome: Outcome[Study], less: float) -> bool:
    """Whether the SISO loops are stable in the same world with so many ms of delay less."""
    world = outcome.study.world
    earlier = replace(world.hardware, delay=max(world.hardware.delay - less / 1000, 0.0))
    return loop_of(replace(world, hardware=earlier), outcome.study.five[ORDER.index(SISO)]).stable


def _late(outcome: Outcome[Study]) -> Verdict:
    d, m, got = outcome.design, outcome.metrics, _band(outcome, "lqe")
    if d["pair"] != "own" or d["limited"]:
        return Verdict(False, text("Use our SISO pair, and coils without a limit."))
    if m["siso_stable"]:
        return Verdict(False, text("With a delay of {delay:g} ms the SISO loops are still stable.",
                                   delay=d["delay"]))
    if not _holds_without(outcome, d["delay"]):
        return Verdict(False, text("The SISO loops are lost without any delay as well: something else does it."))
    if not _holds_without(outcome, DELAY_TOLERANCE_MS):
        return Verdict(False, text("At {delay:g} ms the SISO loops are lost, but they are at {earlier:g} ms too; find where it begins.",
                                   delay=d["delay"], earlier=d["delay"] - DELAY_TOLERANCE_MS))
    if not m["lqe_stable"] or min(got) < KEPT_SUPPRESSION_DB:
        return Verdict(False, text("The SISO loops are lost, but the full LQG gains only {got} dB; keep {kept:g} "
                                   "dB.",
                                   got=_words(got), kept=KEPT_SUPPRESSION_DB))
    return Verdict(True, text("At {delay:g} ms the SISO loops are lost; the full LQG still gains {got} dB.",
                              delay=d["delay"], got=_words(got)))


def _noise(outcome: Outcome[Study]) -> float:
    """V₀ + Δ² h / 12 in (m/s)² s: sensors and rounding together."""
    d = outcome.design
    return d["sensor"] + (1e-6 * d["adc"]) ** 2 * DT / 12


def _coarse(outcome: Outcome[Study]) -> Verdict:
    d, rms = outcome.design, outcome.metrics["lqe_vertical_rms"]
    if d["adc"] != COARSE or abs(d["sensor"] / TRUE_SENSOR - 1) > 1e-6:
        return Verdict(False, text("Let the converter read in steps of {step:g} µm/s, and leave the sensors at V₀ = 10⁻¹⁰.", step=COARSE))
    off = d["v"] / _noise(outcome) - 1
    if off < -INTENSITY_RTOL:
        return Verdict(False, text("The filters assume V = {v:.3g}, too little: the vertical RMS velocity is {rms:.2f} µm/s.",
                                   v=d["v"], rms=rms))
    if off > INTENSITY_RTOL:
        return Verdict(False, text("The filters assume V = {v:.3g}, too much: the vertical RMS velocity is {rms:.2f} µm/s.",
                                   v=d["v"], rms=rms))
    return Verdict(True, text("The vertical RMS velocity is {rms:.2f} µm/s.", rms=rms))


def _yardsticks(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["sensor"] < TRUE_SENSOR * (1 - 1e-9) or d["ground"] != "white":
        return Verdict(False, text("Keep the sensors at V₀ = 10⁻¹⁰ or noisier and the ground white."))
    if any(d[error] for error in MODEL_ERRORS):
        return Verdict(False, text("The plant must equal the design model: leave the errors of stiffness, damping and placement at 0."))
    if not m["lqe_stable"]:
        return Verdict(False, text("The full LQG is unstable here."))
    got, force = m["lqe_vertical_band_db"], 1e3 * m["lqe_force_rms"]
    if got < MIN_SUPPRESSION_DB or force > MAX_FORCE_MN:
        return Verdict(False, text("{got:.2f} dB vertically with {force:.1f} mN; wanted: at least {least:.1f} dB with at most {most:g} mN.",
                                   got=got, force=force, least=MIN_SUPPRESSION_DB, most=MAX_FORCE_MN))
    return Verdict(True, text("{got:.2f} dB vertically with {force:.1f} mN; the SISO pair asks for {siso:.0f} mN.", got=got, force=force,
                              siso=1e3 * m["siso_force_rms"]))


def _calm(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    as_given = abs(d["sensor"] / TRUE_SENSOR - 1) <= 1e-6 and (d["ground"], d["driver"]) == ("white", "ideal")
    if not as_given or any(d[knob] for knob in UNTOUCHED):
        return Verdict(False, text("Leave sensors, ground and real life as they are at the start."))
    found = transmissibility(outcome.study, ORDER.index(LQE))
    if found is None:
        return Verdict(False, text("The full LQG is unstable here."))
    most, force = float(found.max()), 1e3 * m["lqe_force_rms"]
    if most > MAX_TRANSMISSIBILITY or force > MAX_COOL_MN:
        return Verdict(False, text("The transmissibility reaches {most:.3g} with {force:.1f} mN; at most {allowed:g} and {cool:g} mN are "
                                   "allowed.", most=most, force=force, allowed=MAX_TRANSMISSIBILITY, cool=MAX_COOL_MN))
    return Verdict(True, text("The transmissibility reaches {most:.3g} at most, with {force:.1f} mN.", most=most, force=force))


ROUNDED = Typed(_noise, slips=(
    ("1e-9/12", text("That is the rounding alone; the sensors are noisy too.")),
    ("1e-10+1e-9", text("An error spread evenly over a step has a twelfth of its square for a variance.")),
    ("1e-10+1e-6/12", text("A variance of one sample is not an intensity: it counts h times."))))
TOO_LATE = Typed("d/(360*f)", ("d", "f"), slips=(
    ("d/(2*pi*f)", text("The margin is given in degrees: a turn has 360.")),
    ("d/360", text("That is a share of a turn; how long does a turn take at f?"))))

TASKS = (
    Task("twenty", _twenty, {"sensor": 1e-11, "v": 1e-11}),
    Task("calm", _calm, {"v": 6e-11}),
    Task("beaten", _beaten, {"sensor": 4e-13}),
    Task("late", _late, {"delay": 4.2}),
    typed_task("too-late", TOO_LATE),
    Task("coarse", _coarse, {"adc": COARSE, "v": 1.83e-10}, ROUNDED),
    Task("yardsticks", _yardsticks, {"v": 3e-11}),
)
