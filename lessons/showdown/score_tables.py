"""Write the tables of lesson 13: sizes, times, trials, other decks, costs."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, format_number, text, text_in

from .controllers import CONTROLLER_NAMES, DECOUPLED, LQE, ORDER, SHORT_NAMES
from .friction import friction_of
from .study import Study, as_predicted

SCORE_TAB, TRIAL_TAB = text("Scores"), text("Trials")
HEADS = (text_in("channel", "vertical"), text_in("channel", "rotation"), text_in("channel", "horizontal"))
CELL_SEPARATOR = "\N{NO-BREAK SPACE}·\N{NO-BREAK SPACE}"  # between the three numbers of one cell, which must not part at a line's end
MIN_SHOWN_SPEED = 5e-4  # µm/s: less is nothing
CELLS_CAPTION = text("Cells: vertical, rotation, horizontal.")


def tried(outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """What the longer computation has found."""
    return _trials(outcome), _decks(outcome), _costs(outcome)


def cells(values: np.ndarray, stable: bool, form: str = ".1f") -> Text | str:
    """The three channels in one cell."""
    if not stable:
        return text("unstable")
    return CELL_SEPARATOR.join(format_number(v, form) for v in values)


def sizes(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    rows = tuple((CONTROLLER_NAMES[i], *(text("unstable") if not m.spectra[i].stable
                                         else format_number(m.rms[i, j], ".3g") for j in range(3)),
                  "–" if not m.spectra[i].stable else format_number(1e3 * m.forces[i].max(), ".3g")) for i in range(5))
    return TableFigure("sizes", text("RMS velocity in µm/s from 0.1 Hz up, RMS command in mN"),
                       (text("controller"), *HEADS, text("coil")), rows, tab=SCORE_TAB,
                       caption=as_predicted(outcome.design, text("Here what a controller adds above the resonances counts too.")))


def times(outcome: Outcome[Study]) -> TableFigure:
    """How the test goes, which nobody reads while a knob moves."""
    m = outcome.study
    rows = []
    for i in range(5):
        measured = m.measures[i]
        if measured is None:
            rows.append((SHORT_NAMES[i], text("unstable"), "–", "–", "–"))
            continue
        recovered = CELL_SEPARATOR.join(">12" if part.recovery is None else format_number(part.recovery, ".2g") for part in measured)
        over = CELL_SEPARATOR.join(f"{100 * part.overshoot:.0f}" for part in measured)
        rows.append((SHORT_NAMES[i], recovered, over, format_number(1e3 * measured[0].peak, ".3g"),
                     format_number(1e6 * measured[0].energy, ".4g")))
    return TableFigure("times", text("the test in time"),
                       (text("controller"), text("recovery [s]"), text("overshoot "
                                                                                                        "[%]"),
                        text("peak u [mN]"), text("energy [mN² s]")), tuple(rows), tab=SCORE_TAB,
                       caption=text("{split} Overshoot: largest swing to the other side, over the first.",
                                    split=CELLS_CAPTION))


NOT_YET = text("Not computed yet: press the button under the knobs.")


def friction(outcome: Outcome[Study], tab: Text) -> TableFigure:
    """What the guides' friction does to the isolation: motion without it and with it, and how often a guide sticks."""
    found = None if outcome.study.trials is None else outcome.study.trials.rubbing
    rows = tuple((SHORT_NAMES[i], "–", "–", "–") if found is None else
                 (SHORT_NAMES[i], *(cells(np.where(v < MIN_SHOWN_SPEED, 0.0, v), not np.isnan(v[0]), ".3g") for v in found[i, :2]),
                  cells(100 * found[i, 2], not np.isnan(found[i, 2, 0]), ".0f")) for i in range(5))
    said = (text("{split} Sticking: left, right, horizontal guide. A deck that sticks rides on the ground.", split=CELLS_CAPTION)
            if found is not None else NOT_YET if friction_of(outcome.design) else
            text("No friction is set. Its knob is there with the ground that falls as 1/f²: white displacement has no velocity to rub "
                 "against."))
    return TableFigure("friction", text("RMS velocity in µm/s, 0.5–3 Hz, without friction and with it; how often the guides stick"),
                       (text("controller"), text("smooth"), text("rubbing"), text("sticking [%]")), rows, tab=tab, caption=said)


def _trials(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    rows = []
    for i in range(5):
        tried = None if m.trials is None else m.trials.noise[i]
        if tried is None:
            rows.append((SHORT_NAMES[i], cells(m.rms[i], m.spectra[i].stable, ".3g"), "–", "–"))
            continue
        keep = ~tried.diverged
        rms = 1e6 * np.sqrt(np.mean(tried.rms[keep, :3] ** 2, axis=0)) if keep.any() else np.zeros(3)
        rows.append((SHORT_NAMES[i], cells(m.rms[i], True, ".3g"), cells(rms, bool(keep.any()), ".3g"),
                     format_number(100 * float(tried.clipped.mean()), ".2g")))
    done = m.trials is not None and any(one is not None for one in m.trials.noise)
    said = (text("24 runs of 32 s each, with clipping and rounding as they are. {split}", split=CELLS_CAPTION) if done else NOT_YET)
    return TableFigure("trials", text("RMS velocity in µm/s: predicted, and from Monte-Carlo"),
                       (text("controller"), text("predicted"), text("Monte-Carlo"),
                        text("clipped [%]")), tuple(rows), tab=TRIAL_TAB, caption=said)


def _decks(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    decks = None if m.trials is None else m.trials.decks
    rows = []
    for i in range(1, 5):
        if decks is None:
            rows.append((SHORT_NAMES[i], "–", "–", "–"))
            continue
        good = ~np.isnan(decks[:, i, 0])
        if not good.any():
            rows.append((SHORT_NAMES[i], *(text("unstable"),) * 3))
            continue
        low, high = np.quantile(decks[good, i], (0.05, 0.95), axis=0)
        lost = "" if good.all() else f" ({np.sum(~good)} ✕)"
        rows.append((SHORT_NAMES[i], *(f"{a:.1f} … {b:.1f}{lost}".replace("-", "−") for a, b in zip(low, high, strict=True))))
    if decks is None or m.trials is None:
        said = NOT_YET
    else:
        k, c, s = m.trials.tolerance
        said = text("60 decks, stiffness ±{k:.3g} %, damping ±{c:.3g} %, sensors ±{s:.3g} mm: nine in ten lie "
                    "between. ✕: unstable.",
                    k=k, c=c, s=s)
    return TableFigure("decks", text("suppression in dB, 0.5–3 Hz, on decks that are not quite the model"),
                       (text("controller"), *HEADS), tuple(rows), tab=TRIAL_TAB, caption=said)


SWITCHES = (
    (text("driver"), "Hz"), (text("delay"), "ms"), (text("converter"), "µm/s"),
    (text("drift"), "µm/s/√s"), (text("stiffness"), "%"), (text("damping"), "%"),
    (text("placement"), "mm"),
)


def _costs(outcome: Outcome[Study]) -> TableFigure:
    shown, trials = (1, ORDER.index(LQE), ORDER.index(DECOUPLED)), outcome.study.trials
    if trials is None or trials.costs is None:
        rows: tuple[tuple[Text | str, ...], ...] = tuple((name, "–", "–", "–") for name, _ in SWITCHES)
        said = NOT_YET
    else:
        rows = tuple(
            (text("{name} {size:.3g} {unit}", name=name, size=size, unit=unit),
             *(cells(np.round(cost[k], 1) + 0.0, not np.isnan(cost[k, 0]), "+.1f") for k in shown))
            for (name, unit), size, cost in zip(SWITCHES, trials.sizes, trials.costs, strict=True))
        said = text("Change of the suppression in dB by one switch alone: vertical, rotation, horizontal. A knob "
                    "at rest counts with a usual size.")
    return TableFigure("costs", text("what each switch costs"),
                       (text("switch"), *(SHORT_NAMES[k] for k in shown)), rows, tab=TRIAL_TAB, caption=said)
