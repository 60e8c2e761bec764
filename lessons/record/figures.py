"""Draw lesson 21: output and prediction, order and poles, innovations, whiteness, NIS."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.curves import thin_samples
from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine.identification.evidence import WHITE
from observer_lab.text import Text, format_number, joined, text

from .knobs import ONE_SENSOR
from .study import Study

RECORD_TAB, ORDER_TAB, INNOVATIONS_TAB, NIS_TAB, NUMBERS_TAB = (
    text("Record"), text("Order"), text("Innovations"), text("Consistency"), text("Numbers"))
SINGLE_WIDTH = 0.6  # px: single values lie behind their mean
MOST_VALUES = 12  # singular values that are drawn
WHOLE_CIRCLE = 1.2  # half the side of a square around the unit circle
TOP, MOST_ARROWS = 4.0, 40  # of the NIS figure: its least upper edge, in means; arrows there


def figures(outcome: Outcome[Study]) -> FigureSet:
    """All figures; those of hidden tabs are made when they are looked at."""
    study = outcome.study
    return FigureSet(tab_figures(RECORD_TAB, lambda: (_output(outcome), _gap(outcome), _sigma(study))),
                 tab_figures(ORDER_TAB, lambda: (_values(study), _poles(study))),
                 tab_figures(INNOVATIONS_TAB, lambda: (_innovations(study), _whiteness(study))),
                 tab_figures(NIS_TAB, lambda: (_nis(study),)),
                 tab_figures(NUMBERS_TAB, lambda: (_numbers(outcome),)))


def _unit(study: Study) -> str:
    record = study.found.record
    unit = record.unit(record.output_names[0])
    return f"{record.output_names[0]} [{unit}]" if unit else record.output_names[0]


def _output(outcome: Outcome[Study]) -> LineFigure:
    """The first output of the rows that judge: measured, predicted one step ahead, estimated."""
    study, smoothed = outcome.study, bool(outcome.design["smoother"])
    estimate = study.estimate(smoothed)[:, 0]
    measured = np.where(np.isfinite(study.measured[:, 0]), study.measured[:, 0], study.predicted[:, 0])
    t, y, before, after = thin_samples(study.t, measured, study.predicted[:, 0], estimate)
    name = text("smoothed") if smoothed else text("filtered")
    return LineFigure("output", text("output on the unused part"), t,
                      (Curve(text("measured"), y, "plant"), Curve(text("predicted one step ahead"), before, "second", "dash"),
                       Curve(name, after, "estimate")), _unit(study), tab=RECORD_TAB,
                      caption=text("The model was fitted to the first {share:.0f} % of the record; this is the rest.",
                                   share=outcome.design["share"]))


def _gap(outcome: Outcome[Study]) -> LineFigure:
    """What is left of the estimate beside the truth, where that is known, and beside the measurement where it is not."""
    study, clean = outcome.study, outcome.study.clean
    beside = study.measured if clean is None else clean
    curves = []
    for name, smoothed, role in ((text("filter"), False, "second"), (text("smoother"), True, "estimate")):
        if smoothed and not outcome.design["smoother"]:
            continue
        away = np.nan_to_num(study.estimate(smoothed)[:, 0] - beside[:, 0])
        t, drawn = thin_samples(study.t, away)
        curves.append(Curve(name, drawn, role))
    words = text("Here nobody knows the true output, so the estimate is compared with the measurement.")
    if clean is not None:
        m = outcome.metrics
        words = text("Root mean square: filter {filter:.3g}, smoother {smoother:.3g}.", filter=m["filter_error"],
                     smoother=m["smoother_error"])
    title = text("estimate less measured output") if clean is None else text("estimate less true output")
    return LineFigure("gap", title, t, tuple(curves), _unit(study), tab=RECORD_TAB, caption=words)


def _sigma(study: Study) -> LineFigure:
    """The standard deviation of the estimated output, with one sensor and with a second one."""
    fusion, record = study.fusion, study.found.record
    t = study.t[0] + record.dt * np.arange(len(fusion.alone))
    curves = [Curve(text("one sensor"), fusion.alone, "second")]
    words = text("With one sensor it is {sigma:.2g}.", sigma=fusion.alone[-1])
    if study.second != ONE_SENSOR:
        curves.append(Curve(text("two sensors"), fusion.both, "estimate"))
        words = text("With one sensor it is {sigma:.2g}; with both it runs from {low:.2g} to {high:.2g}.", sigma=fusion.alone[-1],
                     low=fusion.period.min(), high=fusion.period.max())
    return LineFigure("sigma", text("standard deviation of the estimated output"), t, tuple(curves), _unit(study), tab=RECORD_TAB,
                      caption=words)


def _values(study: Study) -> PlaneFigure:
    """Singular values and what noise alone would give."""
    s = study.found.subspace
    values, count = s.singular_values[:MOST_VALUES], min(len(s.singular_values), MOST_VALUES)
    used = len(s.A)
    points = tuple(Point(k + 1.0, float(v), "estimate" if k < used else "muted", "dot") for k, v in enumerate(values))
    edge = Curve(text("noise alone"), np.full(2, s.edge), "reference", "dash", x=np.array([0.5, count + 0.5]))
    return PlaneFigure("values", text("singular values of the record"), (edge,), points, text("number"), text("correlation"),
                       (0.5, count + 0.5), (0.0, 1.05), tab=ORDER_TAB,
                       caption=text("Singular values above what noise alone would give: {count}. States of the model: {used}.",
                                    count=int(np.count_nonzero(s.singular_values > s.edge)), used=used))


def _poles(study: Study) -> PlaneFigure:
    """Fitted poles with their standard deviations, true poles where they are known, one of each pair; and the unit circle."""
    s, angle = study.found.subspace, np.linspace(0, 2 * np.pi, 121)
    curves = [Curve(text("unit circle"), np.sin(angle), "muted", x=np.cos(angle))]
    for pole, spread in zip(s.poles, s.spread, strict=True):
        if pole.imag < 0:
            continue
        root = np.linalg.cholesky(spread + 1e-12 * np.eye(2))
        x, y = 3.0 * root @ np.vstack([np.cos(angle), np.sin(angle)])
        name = text("three standard deviations")
        curves.append(Curve(name, np.clip(pole.imag + y, -1.5, 1.5), "estimate", "dot", x=np.clip(pole.real + x, -1.5, 1.5)))
    points = [Point(float(p.real), float(p.imag), "estimate", "cross") for p in s.poles if p.imag >= 0]
    if study.true_poles is not None:
        points += [Point(float(p.real), float(p.imag), "plant", "circle") for p in study.true_poles if p.imag >= 0]
    words = (text("Crosses: fitted poles with Im z ≥ 0. The farthest true pole (circle) is {away:.2g} standard deviations from a fitted "
                  "one.", away=study.away) if study.true_poles is not None else
             text("Crosses: fitted poles with Im z ≥ 0. The true ones of a measured record are not known."))
    x_range, y_range = _around(np.concatenate([[(p.x, p.y) for p in points], *(np.column_stack([c.xs, c.y]) for c in curves[1:])]))
    return PlaneFigure("poles", text("poles of the sampled model"), tuple(curves), tuple(points), "Re z", "Im z", x_range, y_range,
                       equal=True, caption=words, tab=ORDER_TAB)


def _around(places: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
    """The ranges of a square around places (k, 2), no larger than one around the unit circle."""
    low, high = places.min(axis=0), places.max(axis=0)
    half, (x, y) = 0.7 * float(max(*(high - low), 0.05)), 0.5 * (low + high)
    return ((x - half, x + half), (y - half, y + half)) if half < WHOLE_CIRCLE else ((-WHOLE_CIRCLE, WHOLE_CIRCLE),) * 2


def _innovations(study: Study) -> LineFigure:
    """The innovations of the rows that judge, with the band of two standard deviations."""
    track, first = study.judged.track, study.first
    nu = np.nan_to_num(track.innovations[first:, 0])
    band = 2 * np.sqrt(track.S[first:, 0, 0])
    t, drawn, high = thin_samples(study.t, nu, band)
    outside = float(np.mean(np.abs(nu) > band))
    return LineFigure("innovations", text("innovations y − ŷ"), t,
                      (Curve(text("innovation"), drawn, "error", width=1.2),
                       Curve(text("two standard deviations"), high, "reference", "dash"),
                       Curve(text("two standard deviations"), -high, "reference", "dash")), _unit(study), tab=INNOVATIONS_TAB,
                      caption=text("{outside:.1f} % lie outside; a consistent filter has about 4.6 %.", outside=100 * outside))


def _whiteness(study: Study) -> PlaneFigure:
    """The autocorrelation of the innovations over the lag, with its band."""
    white, p_value = study.judged.whiteness, study.judged.evidence.white
    if p_value >= WHITE:
        said = text("The innovations are white (p = {p:.2g}), the errors of the fit allowed for.", p=p_value)
    else:
        said = text("The innovations are not white (p = {p:.2g}): a better model could predict a part of them.", p=p_value)
    if white is None:
        said = joined(said, text("Rows without a measurement are left out."))
        return PlaneFigure("whiteness", text("autocorrelation of the innovations"), (), (), text("lag"), text("correlation"),
                           (0, 20), (-1, 1), tab=INNOVATIONS_TAB, caption=said)
    r = white.correlation[:, 0]
    lags = len(r)
    points = tuple(Point(k + 1.0, float(v), "estimate" if abs(v) <= white.band else "error", "dot") for k, v in enumerate(r))
    lines = tuple(Curve(text("band of white noise"), np.full(2, side * white.band), "reference", "dash", x=np.array([0.5, lags + 0.5]))
                  for side in (1, -1))
    high = max(1.2 * float(np.abs(r).max()), 2 * white.band)
    return PlaneFigure("whiteness", text("autocorrelation of the innovations"), lines, points, text("lag"), text("correlation"),
                       (0.5, lags + 0.5), (-high, high), tab=INNOVATIONS_TAB, caption=said)


def _nis(study: Study) -> PlaneFigure:
    """NIS of each row that judges, its running mean, and the band of the mean at the end; an arrow stands where a value is above the frame,
    which has room for the whole mean."""
    judged = study.judged
    seen = np.isfinite(judged.nis.values)
    values = np.nan_to_num(judged.nis.values) / judged.nis.dof
    mean = np.cumsum(values) / np.maximum(np.cumsum(seen), 1)
    mean = mean * judged.mean_nis / mean[-1]  # behind a gate a good filter has a mean below 1; `mean_nis` allows for it
    t, single, running = thin_samples(study.t, values, mean)
    top = TOP if judged.mean_nis <= TOP else round_up_nicely(1.3 * judged.mean_nis)
    ends, beyond = np.array([t[0], t[-1]]), np.flatnonzero(values > top)
    arrows = tuple(Point(float(study.t[k]), top, "error", "up") for k in beyond[::max(1, -(-len(beyond) // MOST_ARROWS))])
    said = text("A consistent filter has a mean of 1. At the end it is {mean:.3g}; the 99 % band is {low:.2f} to {high:.2f}.",
                mean=judged.mean_nis, low=judged.band[0], high=judged.band[1])
    if len(beyond):
        said = joined(said, text("Arrows: {count} of {rows} are larger than {top:g}.", count=len(beyond), rows=len(values), top=top))
    return PlaneFigure("nis", text("normalised innovation squared (NIS)"),
                       (Curve(text("single NIS"), np.minimum(single, top), "fog", width=SINGLE_WIDTH, x=t),
                        Curve(text("mean so far"), np.minimum(running, top), "estimate", width=2.6, x=t),
                        *(Curve(text("band of the whole mean"), np.full(2, edge), "reference", "dash", 1.6, ends) for edge in judged.band)),
                       arrows, "t [s]", "NIS", (float(t[0]), float(t[-1])), (0.0, top), tab=NIS_TAB, caption=said)


def _numbers(outcome: Outcome[Study]) -> TableFigure:
    """What is known of the record and what was found."""
    study, found = outcome.study, outcome.study.found
    record, truth = found.record, study.given.truth
    rows: list[tuple[Text | str, ...]] = [
        (text("rows of the record"), f"{record.rows}", ""), (text("rows for the fit"), f"{study.first}", ""),
        (text("step"), f"{record.dt:.3g} s", ""),
        (text("steps of past and of future"), f"{found.subspace.horizon}", ""),
        ("R", format_number(found.fitted.R[0, 0], ".3g"), format_number(truth.R[0, 0], ".3g") if truth else ""),
    ]
    true = study.true_poles
    s = found.subspace
    for k, (pole, deviation, ends) in enumerate(zip(s.poles, s.deviations, s.intervals, strict=True)):
        beside = "" if true is None else _pole(true[np.abs(true - pole).argmin()])
        interval = f" [{ends[0]:.3f}; {ends[1]:.3f}]".replace("-", "−") if np.isfinite(ends).all() else ""
        rows.append((text("pole {number}", number=k + 1), f"{_pole(pole)} ± {deviation:.2g}{interval}", beside))
    return TableFigure("numbers", text("what was found"), (text("quantity"), text("fitted"), text("true")), tuple(rows), tab=NUMBERS_TAB,
                       caption=text("± is one standard deviation; in brackets stands the 95 % interval of a real pole."))


def _pole(pole: complex) -> str:
    return f"{pole.real:.3f}" + (f" {'+' if pole.imag > 0 else '−'} {abs(pole.imag):.3f}j" if abs(pole.imag) > 1e-9 else "")
