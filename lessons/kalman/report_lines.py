"""Check the lines of the report's algorithm against this filter."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.text import same, text, text_in

from .deck_study import DeckStudy
from .knobs import GAIN_LINE, JOSEPH, MEANS, NEAR_R, NONE, REPORT_LINES, SHORT_FORM_LINE, WRONG_LINES

REPORT_TAB = text("Report")
PRINTED_MEAN, PRINTED_SIGMA, PRINTED_SAMPLES = 5.46e-10, 1e-9, 20_000  # (61), (77), 20 s at 1 kHz as assumed here


def report_figure(outcome: Outcome[DeckStudy]) -> TableFigure:
    """The lines one by one; the chosen one with its evidence."""
    study, chosen = outcome.study, outcome.design["line"]
    sigmas = PRINTED_MEAN / (PRINTED_SIGMA / np.sqrt(PRINTED_SAMPLES))
    evidence = {
        GAIN_LINE: lambda: text("holds: S = C P Cᵀ + R"),
        JOSEPH: lambda: text("holds: right for every gain"),
        SHORT_FORM_LINE: lambda: text("exact for the optimal gain only, against (59)'s advice; off by up to {short_gap:.1e} here, "
                    "Joseph {joseph_gap:.1e}",
                    short_gap=float(study.forms.short.max()), joseph_gap=float(study.forms.joseph.max())),
        NEAR_R: lambda: text("slip: it is S; S/R = {s_over_r:.2f}, seen {seen_over_r:.2f}; with σ_v = 10⁻⁹ at 1 kHz, 8 million",
                     s_over_r=study.over_R[0], seen_over_r=study.over_R[1]),
        MEANS: lambda: text("slip: {sigmas:.0f} σ of the mean (σ_v = 10⁻⁹, 20 000 samples); HL and HR of one sign, though HR = −HL",
                    sigmas=sigmas),
    }
    printed = {
        GAIN_LINE: same("K = P Hᵀ S⁻¹"), JOSEPH: same("(I−KH) P (I−KH)ᵀ + K R Kᵀ"), SHORT_FORM_LINE: same("P = (I − K C) P"),
        NEAR_R: same("cov ν ≈ R"), MEANS: same("5.46e-10 ≈ 0"),
    }
    rows = tuple((label, printed[key], evidence[key]() if key == chosen else same("—")) for key, label in REPORT_LINES if key != NONE)
    said = (text("Choose a line with the last knob.") if chosen == NONE else
            text("This line goes against what the report advises.") if chosen == SHORT_FORM_LINE else
            text("This line is a slip.") if chosen in WRONG_LINES else text("This line holds."))
    return TableFigure("report", text("lines of the report"),
                       (text("line"), text_in("kalman", "printed"), text("this filter says")), rows, said, REPORT_TAB)
