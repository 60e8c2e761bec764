"""Show the ranking by runs with coil limit and friction beside the predicted one."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR
from observer_lab.course.figures.records import Curve, LineFigure, TableFigure, over_frequency
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, format_number, joined, text

from .controllers import CONTROLLER_NAMES, ORDER, SHORT_NAMES
from .curve_styles import CURVE_STYLES, width
from .race import BINS_HZ, leaders, places
from .score_tables import CELL_SEPARATOR, CELLS_CAPTION, MIN_SHOWN_SPEED, NOT_YET, cells
from .simulation import BAND_HZ
from .study import Study, acts

RACE_TAB = text("Ranking")


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
