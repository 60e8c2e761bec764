"""Draw the figures of lesson 9 that only the deck has: ellipses, updates of P, spectra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from observer_lab.course.figures.diagram import DIAGRAM, DiagramFigure
from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import TabFigures, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import psd
from observer_lab.text import same, text, text_in

from ..toolkit.diagram import LoopSignals, loop
from .data_sheet import SHEET_TAB, estimators_figure, sheet_figure
from .deck_study import LOOK, DeckStudy, formulas, live, numbers, stage, studied
from .figure_eleven import ELEVEN_TAB, eleven_figures
from .figures import GAIN_TAB, STEP_TAB
from .filters import COMPARED_STEPS, UNTESTED_SAMPLES
from .knobs import CARRIED, DT, GAIN_LINE, JOSEPH, MEANS, MODEL, NEAR_R, NONE, REPORT_LINES, SHORT_FORM_LINE, WRONG_LINES
from .noise_identification import FIT_TAB, fit_figure
from .one_number import NUMBER_TAB, number_figure
from .study import Setting

SPECTRUM_TAB = text("Spectrum")
CIRCLE_ANGLES_RAD = np.linspace(0, 2 * np.pi, 61)
UNIT_CIRCLE = np.column_stack([np.cos(CIRCLE_ANGLES_RAD), np.sin(CIRCLE_ANGLES_RAD)])
REPORT_TAB = text("Report")
PRINTED_MEAN, PRINTED_SIGMA, PRINTED_SAMPLES = 5.46e-10, 1e-9, 20_000  # (61), (77), 20 s at 1 kHz as assumed here


def further_tabs(outcome: Outcome[DeckStudy]) -> tuple[TabFigures, ...]:
    """What the deck has beside the figures of every plant."""
    return (
        tab_figures(GAIN_TAB, lambda: (_forms(outcome),)),
        tab_figures(SPECTRUM_TAB, lambda: (_tracking(outcome), _colour(outcome))),
        tab_figures(REPORT_TAB, lambda: (report_figure(outcome),)),
        tab_figures(ELEVEN_TAB, lambda: eleven_figures(outcome.design)),
        tab_figures(FIT_TAB, lambda: (fit_figure(outcome),)),
        tab_figures(SHEET_TAB, lambda: (estimators_figure(outcome), sheet_figure(outcome))),
        tab_figures(NUMBER_TAB, lambda: (number_figure(outcome),)),
        tab_figures(DIAGRAM, lambda: (loop_of(outcome),)),
    )


def _ellipse(mean: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The 2σ ellipse of height and vertical speed in mm and mm/s."""
    at, part = 1e3 * mean[[1, 4]], 1e6 * P[np.ix_([1, 4], [1, 4])]
    values, vectors = np.linalg.eigh(part)
    ring = at + 2 * UNIT_CIRCLE @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
    return ring[:, 0], ring[:, 1]


def planes(outcome: Outcome[DeckStudy]) -> tuple[PlaneFigure]:
    """The last estimate moved on, the prediction, and after the sample the new estimate."""
    s, k = outcome.study, int(outcome.design["k"])
    plan, updated = s.watcher.schedule, outcome.design["phase"] == "update"
    before, at = int(plan.index[k - 1]), int(plan.index[k])
    prior = plan.prior[at]
    old, new = (_ellipse(s.track.predicted[k], P) for P in (plan.posterior[before], prior))
    middle = 1e3 * s.track.predicted[k][[1, 4]]
    half = [round_up_nicely(float(2.6e3 * np.sqrt(max(P[i, i] for P in (prior, plan.posterior[before]))))) for i in (1, 4)]
    curves = [Curve(text("last estimate, moved here"), old[1], "muted", "dot", 2.0, old[0]),
              Curve(text("prediction"), new[1], "disturbance", "dash", 2.0, new[0])]
    x = 1e3 * s.truth.x[k]
    points = [Point(float(x[1]), float(x[4]), "plant", "circle", text("true")),
              Point(float(middle[0]), float(middle[1]), "disturbance", "cross")]
    said = text("Prediction: σ(z) = {prior:.3g} mm, σ(vz) = {prior2:.3g} mm/s.",
                prior=1000.0 * np.sqrt(prior[1, 1]), prior2=1000.0 * np.sqrt(prior[4, 4]))
    if updated:
        after = plan.posterior[at]
        ring = _ellipse(s.track.means[k], after)
        read = 1e3 * float(s.truth.y[k, 0] + s.truth.y[k, 2]) / 2
        curves += [Curve(text("estimate"), ring[1], "estimate", "solid", 2.0, ring[0]),
                   Curve(text("reading (VL + VR)/2"), np.full(2, read), "second", "solid", 1.4,
                         middle[0] + half[0] * np.array([-1.0, 1.0]))]
        mean = 1e3 * s.track.means[k]
        points.append(Point(float(mean[1]), float(mean[4]), "estimate", "cross"))
        said = text("This sample shrinks σ(vz) from {prior:.3g} to {after:.3g} mm/s and σ(z) from {prior2:.3g} to "
                    "{after2:.3g} mm.",
                    prior=1000.0 * np.sqrt(prior[4, 4]), after=1000.0 * np.sqrt(after[4, 4]),
                    prior2=1000.0 * np.sqrt(prior[1, 1]), after2=1000.0 * np.sqrt(after[1, 1]))
    return (PlaneFigure("ellipses", text("height and vertical speed, 2σ"), tuple(curves), tuple(points),
                       "z [mm]", "vz [mm/s]", (float(middle[0] - half[0]), float(middle[0] + half[0])),
                       (float(middle[1] - half[1]), float(middle[1] + half[1])), caption=said, tab=STEP_TAB),)


def _forms(outcome: Outcome[DeckStudy]) -> LineFigure:
    f = outcome.study.forms
    short_gap, joseph_gap = float(f.short.max()), float(f.joseph.max())
    single = outcome.design["arithmetic"] == "single"
    lost = (text("; neither is a covariance any more.") if f.least_joseph < 0 else
            text("; the short form is no covariance any more.") if f.least_short < 0 else
            text("."))
    said = (text("Single precision: the short form is off by up to {short_gap:.1e}, Joseph's by "
                 "{joseph_gap:.1e}{lost}",
                 short_gap=short_gap, joseph_gap=joseph_gap, lost=lost) if single else
            text("With the final gain from the start the short form is wrong by up to {short_gap:.1e}; Joseph's "
                 "is right for every gain.",
                 short_gap=short_gap))
    return LineFigure("forms", text("two updates of P, distance to the right one"), outcome.study.truth.t[:COMPARED_STEPS],
                      (Curve(text("short form"), np.maximum(f.short, 1e-12), "error"),
                       Curve(text("Joseph's form"), np.maximum(f.joseph, 1e-12), "force", "dash")), "‖ΔP‖ / ‖P‖", log_y=True,
                      window=(1e-9, 1.0), caption=said, tab=GAIN_TAB)


def _tracking(outcome: Outcome[DeckStudy]) -> LineFigure:
    s = outcome.study
    clean, guess = (x[UNTESTED_SAMPLES:] @ s.watcher.filter.C[0, :6] for x in (s.truth.x, s.means))
    both = psd(1e3 * np.column_stack([clean, clean - guess]), 1 / DT, segment=len(clean))
    f, floor = both.frequency[1:], np.maximum(both.density[1:], 1e-9)
    near = int(np.argmin(np.abs(f - 0.16)))
    drop = 10 * np.log10(floor[near, 0] / floor[near, 1])
    said = (text("At 0.16 Hz the error lies {drop:.0f} dB below the output.", drop=drop)
            if drop >= 0 else
            text("At 0.16 Hz the error lies {drop:.0f} dB above the output.", drop=-drop))
    return over_frequency("tracking", text("output VL and its error"), f,
                           (Curve(text("true output"), floor[:, 0]),
                            Curve(text("output error"), floor[:, 1], "error", "dash")), "(mm/s)²/Hz", tab=SPECTRUM_TAB,
                           window=(1e-4, 1e3), caption=said)


def _colour(outcome: Outcome[DeckStudy]) -> LineFigure:
    s = outcome.study
    seen = psd(1e3 * s.track.innovations[UNTESTED_SAMPLES:, 0], 1 / DT, segment=64)
    f, promised = seen.frequency[1:], 2e6 * DT * float(s.track.S[-1, 0, 0])
    carried = outcome.design["noise"] == CARRIED
    low, high = (float(np.mean(seen.density[1:][part])) for part in (f < 3.0, f > 6.0))
    said = text("Below 3 Hz {low:.2g} times as dense as above 6 Hz; white noise is flat.", low=low / high)
    if carried:
        said = text("{said} The converter's noise is carried as 16 states.", said=said)
    return over_frequency("colour", text("spectrum of the innovation of VL"), f,
                           (Curve(text_in("kalman", "seen"), np.maximum(seen.density[1:], 1e-9), "error"),
                            Curve(text("predicted by S"), np.full(len(f), promised), "reference", "dash", 1.4)),
                           "(mm/s)²/Hz", window=(1e-2, 10.0), caption=said, tab=SPECTRUM_TAB)


DECK_SETTING = Setting(studied, stage, numbers, formulas, live, LOOK, planes, further_tabs)


def loop_of(outcome: Outcome[DeckStudy]) -> DiagramFigure:
    """Plant and filter; of the gain M, which has two dozen entries, stands the size alone."""
    truth, track = outcome.study.truth, outcome.study.track
    signals = LoopSignals(DT * np.arange(len(truth.y)), truth.u, truth.y, truth.y - track.innovations, track.means)
    M = outcome.gains["M"]
    drawn = loop(MODEL.plant, signals, M, gain="M", sampled=True)
    sized = rf"M\quad ({M.shape[0]}\times {M.shape[1]})"
    return replace(drawn, blocks=tuple(replace(block, law=sized) if block.id == "L" else block for block in drawn.blocks))


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
