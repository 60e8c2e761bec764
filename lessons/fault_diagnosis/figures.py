"""Draw the figures of lesson 17: residuals, isolation table, loop, false alarms."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, Dash, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, format_number, joined, listed, same, text, text_in

from .bank_figures import PAIR_TAB, VERDICT_TAB, bank, pair_figures, pair_reach, short
from .diagnosis import DETECTION_POWER
from .observer_bank import COIL_IDS, DT, FAULT_PLACES, MEMBER_NAMES, PLACE_NAMES, SAMPLE_COUNT, guard
from .results import BAND_PROBABILITY, Study, Trials
from .run_length import cusum, duration, member_run
from .runs import KEEP_LOOP_OPEN, NONE, SWITCH_LOOP
from .sensitivity import TONES, least, least_force
from .study import between, unknown_coil

RESIDUAL_TAB, LOOP_TAB = text("Residuals"), text("Loop")
RATE_TAB, REACH_TAB = text("False alarms"), text("Reach")
TIMES_S = DT * np.arange(SAMPLE_COUNT)
TIMES_S.setflags(write=False)
THRESHOLD_FLOOR = 0.1  # of the threshold: nothing lower is drawn
CURVE_STYLES: tuple[tuple[Dash, float], ...] = (("solid", 2.0), ("dash", 2.0), ("dot", 2.0), ("solid", 1.2))
CURRENT_MARK = "▶ "


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Everything on the right of the stage."""
    s: Study = outcome.study
    return FigureSet(
        tab_figures(
            RESIDUAL_TAB,
            lambda: (
                _residuals(s, "sensors", text("leaving out one sensor"), range(4)),
                _residuals(s, "coils", text("ignoring one coil"), range(4, 7)),
                _reading(s),
            ),
        ),
        tab_figures(VERDICT_TAB, lambda: (bank(s, decisive(s)), isolation(s), _members())),
        tab_figures(PAIR_TAB, lambda: pair_figures(outcome)),
        tab_figures(LOOP_TAB, lambda: (_pitch(s), _across(s), _forces(s))),
        tab_figures(RATE_TAB, lambda: (_rates(s), _counts(s), _cusum(s))),
        tab_figures(REACH_TAB, lambda: (_tones(s), _least(s), pair_reach(s, REACH_TAB))),
    )


# --- residuals ---------------------------------------------------------------------------------------------------------
def _residuals(s: Study, name: str, title: Text, which: range) -> LineFigure:
    at = decisive(s)
    over = {i: bool(s.verdict.values[at, i] > 1) for i in which}
    loud = [MEMBER_NAMES[i] for i, alarm in over.items() if alarm]
    odd = len(loud) == len(over) - 1  # one is not like the others: those are grey, under one name

    def curve(i: int) -> Curve:
        values = np.maximum(s.verdict.values[:, i], THRESHOLD_FLOOR)
        if not odd:
            return Curve(same(MEMBER_NAMES[i]), values, "error" if over[i] else "plant", *CURVE_STYLES[i % 4])
        return (Curve(listed(map(same, loud)), values, "muted", "solid", 1.4) if over[i] else
                Curve(same(MEMBER_NAMES[i]), values, "plant", "solid", 2.6))
    curves = [*map(curve, which), Curve(text("threshold"), np.ones(SAMPLE_COUNT), "reference", "dash", 1.4)]
    when = f"{DT * at:.2f} s"
    said = (text("At {when} over the threshold: {loud}.", when=when, loud=listed(map(same, loud))) if loud else
            text("At {when} none is over the threshold.", when=when))
    return LineFigure(name, title, TIMES_S, tuple(curves), "T / χ²", log_y=True, window=(0.1, 10.0), caption=said,
                      tab=RESIDUAL_TAB)


def decisive(s: Study) -> int:
    """The sample that is talked about: the verdict's, else the last of those with most alarms."""
    if s.verdict.decided is not None:
        return s.verdict.decided
    return SAMPLE_COUNT - 1 - int(np.argmax((s.verdict.values > 1).sum(axis=1)[::-1]))


def _reading(s: Study) -> LineFigure:
    coil = s.case.coil
    if coil is not None:
        return LineFigure("reading", text("force of the weak coil"), TIMES_S,
                          (Curve(text("asked"), s.record.asked[:, coil], "force", "dash"),
                           Curve(text("delivered"), s.record.applied[:, coil], "error")), "u [N]", window=(-1.0, 1.0),
                          tab=RESIDUAL_TAB, caption=text("{coils} delivers {case_size:.0f} % from {dt:.1f} s on; the bank only has the "
                                                         "commanded force.",
                                                         coils=COIL_IDS[coil], case_size=100 * (1 - s.case.size),
                                                         dt=DT * s.case.start))
    i = 1 if s.case.sensor is None else s.case.sensor
    said = (text("{places} is faulty from {dt:.1f} s on.", places=FAULT_PLACES[i], dt=DT * s.case.start)
            if s.case.sensor is not None else text("All four sensors are fault-free."))
    return LineFigure("reading", text("reading of {places}", places=FAULT_PLACES[i]), TIMES_S,
                      (Curve(text("reading"), 1e3 * s.record.y[:, i], "error", width=1.4),
                       Curve(text("true velocity"), 1e3 * s.record.honest[:, i])), "v [mm/s]", window=(-5.0, 5.0),
                      caption=said, tab=RESIDUAL_TAB)


# --- verdict -----------------------------------------------------------------------------------------------------------
def isolation(s: Study) -> MatrixFigure:
    """Fault against residual, and below it what this run shows; that row and the one that fits it now are lit."""
    signature, at = np.asarray(guard().bank.signature, dtype=bool), decisive(s)
    now, values = s.verdict.named[at], s.verdict.values[at]
    expected = signature.T
    kinds = np.vstack([np.where(expected, 0, -1), np.where(values > 1, 1, -1)])
    lit = (now, len(expected)) if now >= 0 else (len(expected),)
    rows = (*(text("{mark}{name}", mark=CURRENT_MARK if now == j else "", name=name) for j, name in enumerate(PLACE_NAMES)),
            text("T / χ², {dt:.2f} s", dt=DT * at))
    said = (text("No alarm: no row to look for.") if now == -1 else
            _unclear(values > 1) if now == -2 else
            text("The alarms fit the row of {place}, but too briefly for a diagnosis.", place=PLACE_NAMES[now])
            if s.verdict.decided is None else text("The alarms fit one row only: {place}.", place=PLACE_NAMES[now]))
    return MatrixFigure("isolation", text("isolation table"), np.vstack([expected.astype(float), values]), rows,
                        tuple(same(n) for n in MEMBER_NAMES), (), said, VERDICT_TAB,
                        ((text("expected alarm"), "plant"), (text("alarm in this run"), "error")), kinds, lit)


def _unclear(alarms: np.ndarray) -> Text:
    """Why no row fits: everybody gives an alarm, or more than one member is quiet."""
    quiet = [name for name, loud in zip(MEMBER_NAMES, alarms, strict=True) if not loud]
    if not quiet:
        return text("Every member gives an alarm: this is none of the seven faults alone.")
    names = listed(map(same, quiet[:3]))
    if len(quiet) > 3:
        return text("No row fits. Below the threshold ({count}): {names} …", count=len(quiet), names=names)
    return text("No row fits. Below the threshold: {names}.", names=names)


def _members() -> TableFigure:
    rows: list[tuple[Text | str, ...]] = []
    for i, m in enumerate(guard().bank.members):
        slow = -DT / np.log(np.max(np.abs(m.poles)))
        if i < 4:
            rows.append((MEMBER_NAMES[i], text("the other three"), "—", str(m.size), f"{slow:.2f} s"))
        else:
            zeros = unknown_coil(i - 4).zeros
            zero = "—" if zeros is None or not len(zeros) else f"s = {abs(zeros[0]):.0f}"
            rows.append((MEMBER_NAMES[i], text("all four"), zero, str(m.size), f"{slow:.2f} s"))
    return TableFigure("members", text("the seven members"),
                       (text("member"), text("sensors"), text_in("fault-diagnosis", "zero"), text("states"),
                        text("memory")), tuple(rows),
                       text("A coil has a zero at s = 0: a constant force leaves every velocity at zero. So no observer of all six "
                            "states can ignore the coil; the residual needs five."),
                       VERDICT_TAB)


# --- loop --------------------------------------------------------------------------------------------------------------
def _motion(s: Study, name: str, title: Text, i: int, unit: str) -> LineFigure:
    true, guess = 1e3 * s.record.x[:, i], 1e3 * s.record.xhat[:, i]
    curves = [Curve(text("true"), true), Curve(text("the estimate that the loop uses"), guess, "estimate", "dash")]
    if s.record is not s.blind:
        curves.append(Curve(text("had nobody acted"), 1e3 * s.blind.x[:, i], "muted", "dot"))
    late = slice(-SAMPLE_COUNT // 6, None)
    mean, error = float(true[late].mean()), float((true - guess)[late].mean())
    said = text("Mean of the last 2 s: {mean:.2f} {unit}; the estimate is off by {error:.2f} {unit}.", mean=mean, unit=unit,
                error=error)
    return LineFigure(name, title, TIMES_S, tuple(curves), f"[{unit}]", window=(-2.0, 2.0), caption=said, tab=LOOP_TAB)


def _pitch(s: Study) -> LineFigure:
    return _motion(s, "pitch", text("pitch of the deck θ"), 2, "mrad")


def _across(s: Study) -> LineFigure:
    return _motion(s, "across", text("horizontal position x"), 0, "mm")


def _forces(s: Study) -> LineFigure:
    looks: tuple[tuple[str, Dash], ...] = (("force", "solid"), ("disturbance", "dash"), ("second", "dot"))
    curves = tuple(Curve(same(COIL_IDS[j]), s.record.applied[:, j], *looks[j]) for j in range(3))
    said = (text("Open loop: only the known force is commanded.") if s.case.loop == KEEP_LOOP_OPEN else
            _acted(s) if s.case.loop == SWITCH_LOOP else
            text("The loop goes on using all four sensors."))
    return LineFigure("forces", text("forces delivered"), TIMES_S, curves, "u [N]", window=(-1.0, 1.0), caption=said,
                      tab=LOOP_TAB)


def _acted(s: Study) -> Text:
    who, at = s.verdict.who, s.verdict.decided
    if who is None or at is None:
        return text("No fault is diagnosed: the loop stays as it is.")
    if who in COIL_IDS:
        return text("From {dt:.2f} s on {who} is asked for nothing; two coils do the work.", dt=DT * at, who=who)
    return text("From {dt:.2f} s on the loop uses the member without {who}.", dt=DT * at, who=who)


# --- false alarms --------------------------------------------------------------------------------------------------------
def _rates(s: Study) -> PlaneFigure:
    x = np.array([0.5, 7.5])
    curves = [Curve(text("designed"), np.ones(2), "reference", "dash", 1.6, x)]
    points: list[Point] = []
    top = 2.0
    if s.trials is not None:
        low, high = (v / s.test.rate for v in s.trials.band(s.test.rate))
        shares = s.trials.alarms / s.trials.windows / s.test.rate
        top = max(top, 1.4 * high, 1.2 * float(shares.max()))
        curves.append(Curve(text("99 % band"), np.array([low, high, high, low, low]), "disturbance", "dot", 1.6,
                            np.array([0.5, 0.5, 7.5, 7.5, 0.5])))
        points = [Point(i + 1.0, float(v), "plant" if low <= v <= high else "error", "dot", same(MEMBER_NAMES[i]))
                  for i, v in enumerate(shares)]
        inside = int(sum(low <= v <= high for v in shares))
        said = text("{windows} windows: {inside} of 7 members lie in the binomial {level:.0f} % band.", windows=s.trials.windows,
                    inside=inside, level=100 * BAND_PROBABILITY)
    else:
        said = text("Press the button: healthy runs are drawn and their alarms counted.")
    return PlaneFigure("rates", text("false alarms, measured over designed"), tuple(curves), tuple(points),
                       "", "α̂ / α", (0.0, 8.0), (0.0, top), caption=said, tab=RATE_TAB)


def _counts(s: Study) -> TableFigure:
    a, all_seven = s.test.rate, between(s)
    rows: list[tuple[Text | str, ...]] = [
        (text("threshold"), f"{s.test.threshold:.2f}"),
        (text("χ² degrees of freedom"), str(s.test.dof)),
        (text("designed, per window and member"), format_number(a, ".2g")),
        (text("mean time between false alarms, one member"), duration(DT * member_run(s.test))),
        (text("mean time between false alarms, all seven"), duration(all_seven)),
        (text("λ for {power:.0f} % power", power=100 * DETECTION_POWER), f"{s.test.needed:.1f}"),
    ]
    t = s.trials
    rows += [(text("all seven, measured"), "—" if t is None else _measured(t, s.test.window)),
             (text("one window of at least one of seven, measured"), "—" if t is None else format_number(t.any / t.windows, ".2g"))]
    if t is not None and s.case.place != NONE:
        middle = f"{np.median(t.delays):.2f} s" if t.delays else "—"
        rows += [(text("diagnosis right / wrong / none"), f"{t.right} / {t.wrong} / {t.nobody}"),
                 (text("median delay"), middle)]
    else:
        rows += [(text("diagnosis right / wrong / none"), "—"), (text("median "
                                                                                                           "delay"), "—")]
    said = joined(text("A healthy bank gives a false alarm every {time} on average. Its windows are tested at every sample and are emptied "
                       "after an alarm.", time=duration(all_seven)), _wrong_model(s))
    return TableFigure("counts", text("design of the threshold"), (text("quantity"), text("value")),
                       tuple(rows), said, RATE_TAB)


def _cusum(s: Study) -> LineFigure:
    """The window of the loudest member beside its cumulative sum, both over their thresholds."""
    both = cusum(s.test, s.blind)
    member = int(np.argmax(s.verdict.values.max(axis=0)))
    curves = [values[:, member] for values in (judged(s), both.values)]
    window, total = (_crossing(values) for values in curves)
    said = text("The window crosses at {window}, the sum at {total}. Both have the same mean time between false alarms of one member: "
                "{time}.", window=window, total=total, time=duration(both.mean * DT))
    return LineFigure("cusum", text("window and cumulative sum of {member}", member=MEMBER_NAMES[member]), TIMES_S,
                      (Curve(text("window"), np.maximum(curves[0], THRESHOLD_FLOOR), "plant"),
                       Curve(text("cumulative sum"), np.maximum(curves[1], THRESHOLD_FLOOR), "error", "dash"),
                       Curve(text("threshold"), np.ones(SAMPLE_COUNT), "reference", "dash", 1.4)), text("over its threshold"), log_y=True,
                      window=(0.1, 10.0), caption=said, tab=RATE_TAB)


def _measured(t: Trials, window: int) -> Text:
    """The mean time that healthy runs show, with how many alarms it rests on."""
    return (text("{time}; alarms: {count}", time=duration(t.between(window)), count=t.false) if t.false else
            text("no alarm in {time}", time=duration(DT * t.full)))


def _wrong_model(s: Study) -> Text:
    """That the mean time is of a true model, where the model is wrong."""
    return NO_WORDS if s.case.stiffer == 0 else text("This time is for springs as the model has them. Here they differ: press the button "
                                                     "and count.")


def judged(s: Study) -> np.ndarray:
    """The window's statistic over its threshold in the run in which nobody acts (SAMPLE_COUNT, 7)."""
    return s.test.values(s.blind.residuals) / s.test.threshold


def _crossing(values: np.ndarray) -> Text:
    over = np.flatnonzero(values > 1)
    return text("{at:.2f} s", at=DT * over[0]) if len(over) else text("no time")


# --- reach -------------------------------------------------------------------------------------------------------------
def _tones(s: Study) -> LineFigure:
    values = np.clip(least_force(s.test), 1e-2, 1e2)
    missing = 0.0
    if s.case.coil is not None:
        lost = s.silent.asked - s.silent.applied
        missing = float(np.abs(lost[s.case.start:, s.case.coil]).max(initial=0.0))
    curves = [Curve(same("u1, u2"), values[:, 0], "plant"), Curve(same("u3"), values[:, 2], "estimate", "dash")]
    if missing > 0:
        curves.append(Curve(text("missing now"), np.full(len(TONES), max(missing, 1e-2)), "error", "dot"))
    best = TONES[int(np.argmin(values[:, 0]))]
    said = text("A missing force of u1 is seen best at {best:.2f} Hz, from {values:.2g} N on.",
                best=best, values=values[:, 0].min())
    return over_frequency("tones", text("least missing force that all six see"), TONES, tuple(curves),
                          "N", window=(0.1, 10.0), caption=said, tab=REACH_TAB)


def _least(s: Study) -> TableFigure:
    values = least(s.test, s.case.tone)
    rows: list[tuple[Text | str, ...]] = []
    for j, name in enumerate(FAULT_PLACES):
        scale, unit = (1e3, "mm/s") if j < 4 else (1.0, "N")
        cells = [short(scale * v) for v in values[:, j]]
        rows.append((f"{name} [{unit}]", *cells))
    weak = int(np.argmax(np.where(np.isfinite(values[:, 0]), values[:, 0], 0)))
    said = text("Bias, or missing amplitude at {tone:.2g} Hz. An error of VL is hardest to detect for {names}: it looks "
                "almost like what that member ignores.",
                tone=s.case.tone, names=MEMBER_NAMES[weak])
    return TableFigure("least", text("least fault that each member detects with 99 %"),
                       (text("fault"), *(same(n) for n in MEMBER_NAMES)), tuple(rows), said, REACH_TAB)
