"""The report's rules, and what this loop says of the one that is asked."""

from __future__ import annotations

import numpy as np

from app.lesson.figures import TableFigure
from app.lesson.lesson import Outcome
from app.text import same, text

from ..toolkit.latex import tiny
from .knobs import CAUTION, NONE, PROCESS, RULES, SENSOR, SLIPS, SPLIT, UNITS
from .study import Study

REPORT_TAB = text("Report")


def rules_figure(outcome: Outcome[Study]) -> TableFigure:
    """The rules one by one; the chosen one with its evidence."""
    study, chosen = outcome.study, outcome.design["rule"]
    m = {name: value if np.isfinite(value) else np.inf for name, value in study.answers.items()}
    evidence = {
        SPLIT: lambda: text("holds: the loop's poles are both sets, off by {union_error}",
                            union_error=tiny(m["union_error"])),
        SENSOR: lambda: text("slip: input from sensor noise ×{sensor_less:.3g} at β_R/10, ×{sensor_more:.3g} at "
                             "10 β_R",
                             sensor_less=m["sensor_less"], sensor_more=m["sensor_more"]),
        PROCESS: lambda: text("holds: at 10 β_Q the sum of the filter's poles ×{process_more:.3g}, input from "
                              "sensor noise ×{process_input:.3g}",
                              process_more=m["process_more"], process_input=m["process_input"]),
        CAUTION: lambda: text("holds: nothing is promised; here min |1 + ℓ| = {nearest:.3g}", nearest=study.real.margins.nearest),
        UNITS: lambda: text("slip: R_v = σ_v² I gives 1e-18; the figures use 1e-9 and 1e-6"),
    }
    rows = tuple((label, evidence[key]() if key == chosen else same("—")) for key, label in RULES if key != NONE)
    said = (text("Choose a line with the last knob.") if chosen == NONE else
            text("This line is wrong.") if chosen in SLIPS else text("This line holds."))
    return TableFigure("rules", text("lines of the report, section 5.2"),
                       (text("line"), text("this loop says")), rows, said, REPORT_TAB)
