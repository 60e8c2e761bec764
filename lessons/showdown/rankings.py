"""Tabulate the ranking of the controllers: by runs with limit and friction, and at equal effort."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR
from observer_lab.course.figures.records import Curve, LineFigure, TableFigure, over_frequency
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, format_number, joined, text

from .controllers import CONTROLLER_NAMES, LQE, ORDER, SHORT_NAMES, SISO
from .equal_effort import Equal
from .race import BINS_HZ, leaders, places
from .score_tables import CELL_SEPARATOR, CELLS_CAPTION, HEADS, MIN_SHOWN_SPEED, NOT_YET, cells
from .simulation import BAND_HZ, loop_of
from .study import Study, acts
from .suppression import CURVE_STYLES, TIED, best_words, width

RACE_TAB = text("Ranking")
EFFORT_TAB = text("Equal effort")
CLIP_SIGMAS = 3.0  # standard deviations that a coil's limit should leave


def race_figures(outcome: Outcome[Study]) -> tuple[TableFigure, LineFigure]:
    """Who moves least, as predicted and in the runs, and the vertical spectra of the runs."""
    return _race(outcome), _spectrum(outcome)


def _race(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    stable = np.array([s.stable for s in m.spectra])
    predicted = np.where(stable[:, None], m.band_rms(*BAND_HZ), np.nan)
    raced = None if m.trials is None else m.trials.raced
    rows = []
    for i, name in enumerate(SHORT_NAMES):
        row: list[Text | str] = [name, _speeds(predicted[i]), _places(predicted, i)]
        rows.append((*row, *(("–",) * 3 if raced is None else
                             (_speeds(raced.rms[i]), _places(raced.rms, i),
                              "–" if np.isnan(raced.clipped[i]) else format_number(100 * raced.clipped[i], ".2g")))))
    said = (joined(leaders(raced.rms), CELLS_CAPTION) if raced is not None else NOT_YET if acts(outcome.design) else
            text("Neither a coil limit nor friction is set, so the prediction is the ranking."))
    return TableFigure("race", text("RMS velocity in µm/s, 0.5–3 Hz: predicted, and in runs with limit and friction"),
                       (text("controller"), text("predicted"), text("place"), text("in runs"), text("place in runs"),
                        text("clipped [%]")), tuple(rows), tab=RACE_TAB, caption=said)


def _speeds(rms: np.ndarray) -> Text | str:
    return cells(np.where(rms < MIN_SHOWN_SPEED, 0.0, rms), not np.isnan(rms[0]), ".2g")


def _places(rms: np.ndarray, i: int) -> str:
    return CELL_SEPARATOR.join("–" if np.isnan(rms[i, j]) else str(places(rms[:, j])[i]) for j in range(3))


def _spectrum(outcome: Outcome[Study]) -> LineFigure:
    """The densities of the runs, or the predicted ones where there are none."""
    m = outcome.study
    raced = None if m.trials is None else m.trials.raced
    f = np.sqrt(BINS_HZ[1:] * BINS_HZ[:-1]) if raced is None else raced.f
    lines = (np.array([np.interp(f, m.f, s.density[:, 0]) for s in m.spectra]) if raced is None
             else np.where(np.isnan(raced.density), 0.0, raced.density))
    curves = [Curve(CONTROLLER_NAMES[i], np.maximum(lines[i], LOG_AXIS_FLOOR), role, dash, width(outcome, i))
              for i, (role, dash) in enumerate(CURVE_STYLES)]
    said = text("Predicted, without limit and friction.")
    if raced is not None:
        chosen = ORDER.index(outcome.design["play"])
        curves.append(Curve(text("predicted"), np.maximum(np.interp(f, m.f, m.spectra[chosen].density[:, 0]), LOG_AXIS_FLOOR), "second",
                            "dot", 1.6))
        said = text("Mean of the runs, with limit and friction. Dotted: predicted without them for {name}.", name=SHORT_NAMES[chosen])
    top = max(float(curve.y.max()) for curve in curves)
    return over_frequency("race_spectrum", text("vertical velocity over frequency"), f, tuple(curves), "[(µm/s)²/Hz]", said, RACE_TAB,
                          (top * 1e-5, top))


def equal(outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """Each controller as bold as it takes to tell its coils as much as the full LQG does: how much moves, and what is taken out."""
    m = outcome.study
    found = None if m.trials is None else m.trials.equal
    waiting = (NOT_YET if loop_of(m.world, m.five[ORDER.index(LQE)]).stable else
               text("The full LQG is unstable with these settings: there is no effort to meet."))
    rows = tuple((SHORT_NAMES[i], *(("–", "–") if found is None else _row(found, i - 1))) for i in range(1, 5))
    taken = tuple((CONTROLLER_NAMES[i], *(("–",) * 3 if found is None or np.isnan(found.dials[i - 1]) else
                               (f"{db:.1f}".replace("-", "−") for db in found.band_db[i - 1]))) for i in range(1, 5))
    return (TableFigure("effort", text("RMS velocity in µm/s, all at the RMS command of the full LQG"),
                        (text("controller"), text("retuned"), text("velocity [µm/s]")), rows,
                        tab=EFFORT_TAB, caption=waiting if found is None else _said(found, m)),
            TableFigure("effort_db", text("suppression in dB, 0.5–3 Hz, at that effort"), (text("controller"), *HEADS), taken,
                        tab=EFFORT_TAB, caption=waiting if found is None else best_words(found.band_db)))


def _row(found: Equal, i: int) -> tuple[Text | str, ...]:
    dial = float(found.dials[i])
    if np.isnan(dial):
        return text("cannot reach this effort"), "–"
    made = text("gain × {dial:.3g}", dial=dial) if ORDER[i + 1] == SISO else text("V × {times:.3g}", times=1 / dial)
    return made, cells(found.rms[i], True, ".3g")


def _said(found: Equal, m: Study) -> Text:
    limit, lqe, siso = m.world.hardware.limit, *(ORDER.index(id) - 1 for id in (LQE, SISO))
    head = (
        text("{split} The coil with the largest command gets {force:.3g} mN RMS from each.", split=CELLS_CAPTION, force=1e3 * found.wanted)
        if np.isfinite(found.dials).all()
        else text(
            "{split} The coil with the largest command gets {force:.3g} mN RMS from each that reaches this effort.",
            split=CELLS_CAPTION, force=1e3 * found.wanted
        )
    )
    clipped = text("A coil that may give {limit:.3g} mN would be clipped often; that is left out.", limit=1e3 * limit)
    over = clipped if CLIP_SIGMAS * found.wanted > limit else NO_WORDS
    lead = 20 * np.log10(found.rms[siso] / found.rms[lqe])
    if np.isnan(lead).any():
        return joined(head, text("The SISO loops cannot be made to spend that, with any gain."), over)
    least, most = float(lead.min()), float(lead.max())
    apart = text("At this effort no controller leads in every channel. By RMS velocity the full LQG is {first:+.1f}, {second:+.1f} and "
                 "{third:+.1f} dB ahead of the SISO loops.", first=lead[0], second=lead[1], third=lead[2])
    ahead = text("The full LQG leads the SISO loops at this effort, or ties with them, in every channel. By RMS velocity it is "
                 "{first:+.1f}, {second:+.1f} and {third:+.1f} dB ahead.", first=lead[0], second=lead[1], third=lead[2])
    behind = text("The SISO loops lead the full LQG at this effort, or tie with it, in every channel. By RMS velocity it is "
                  "{first:+.1f}, {second:+.1f} and {third:+.1f} dB ahead of them.", first=lead[0], second=lead[1], third=lead[2])
    level = claim(text("At this effort full LQG and SISO loops tie in every channel, within {tied:.1g} dB.", tied=TIED),
                  max(abs(least), abs(most)), below=TIED, otherwise=ahead if least > -TIED else behind if most < TIED else apart)
    who = claim(text("At this effort the full LQG moves less than the SISO loops in every channel, by {least:.1f} to {most:.1f} dB.",
                     least=least, most=most), least, above=TIED, otherwise=claim(
        text("At this effort the SISO loops move less than the full LQG in every channel, by {least:.1f} to {most:.1f} dB.",
             least=-most, most=-least), most, below=-TIED, otherwise=level))
    return joined(head, who, over)
