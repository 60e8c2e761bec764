"""Check the report's tuning rules on the present loop."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.text import same, text

from ..toolkit.latex import tiny
from .knobs import CAUTION_RULE, NONE, PROCESS_RULE, RULES, SENSOR_RULE, SPLIT_RULE, UNITS_RULE, WRONG_RULES
from .study import Study

REPORT_TAB = text("Report")


def rules_figure(outcome: Outcome[Study]) -> TableFigure:
    """The rules one by one; the chosen one with its evidence."""
    study, chosen = outcome.study, outcome.design["rule"]
    m = {name: value if np.isfinite(value) else np.inf for name, value in study.answers.items()}
    evidence = {
        SPLIT_RULE: lambda: text("holds: the loop's poles are both sets, off by {union_error}",
                            union_error=tiny(m["union_error"])),
        SENSOR_RULE: lambda: text("slip: input from sensor noise ×{sensor_less:.3g} at β_R/10, ×{sensor_more:.3g} at "
                             "10 β_R",
                             sensor_less=m["sensor_less"], sensor_more=m["sensor_more"]),
        PROCESS_RULE: lambda: text("holds: at 10 β_Q the sum of the filter's poles ×{process_more:.3g}, input from "
                              "sensor noise ×{process_input:.3g}",
                              process_more=m["process_more"], process_input=m["process_input"]),
        CAUTION_RULE: lambda: text("holds: there is no guarantee; here min |1 + ℓ| = {nearest:.3g}", nearest=study.real.margins.nearest),
        UNITS_RULE: lambda: text("slip: R_v = σ_v² I gives 10⁻¹⁸; the figures use 10⁻⁹ and 10⁻⁶"),
    }
    rows = tuple((label, evidence[key]() if key == chosen else same("—")) for key, label in RULES if key != NONE)
    said = (text("Choose a line with the last knob.") if chosen == NONE else
            text("This line is wrong.") if chosen in WRONG_RULES else text("This line holds."))
    return TableFigure("rules", text("lines of the report, section 5.2"),
                       (text("line"), text("this loop says")), rows, said, REPORT_TAB)
