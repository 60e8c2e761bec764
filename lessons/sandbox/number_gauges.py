"""Show what the analyses of a plant and its loop answer as gauges, one number each."""

from __future__ import annotations

from observer_lab.course.figures.gauges import LOWER, MIDDLE, UPPER, Gauge, GaugeFigure, place_of
from observer_lab.engine.structure import Controllability, Observability
from observer_lab.text import Text, format_number, same, text

from ..toolkit.latex import tiny
from .analyses import Refusal
from .loop_figures import VERDICT_TAB
from .study import LEAST_DISK, MOST_ERROR, NIS_SHARE, Study, times_the_least

LOST = 1e-10  # of the plant's size: the staircase takes a smaller coupling for rounding
HEADS = (text("question"), text("value"), text("band"), text("verdict"))


def numbers(study: Study) -> GaugeFigure:
    """Distances to hidden modes, the observer's error, NIS and the disk margin, each beside what is accepted."""
    trial, margins = study.trial, study.margins
    return GaugeFigure("numbers", text("one number for each question"), (
        _distance(text("distance to unobservability"), study.structure.seen),
        _distance(text("distance to uncontrollability"), study.structure.reached),
        _error(times_the_least(study.noise)),
        _refused(text("NIS of the Kalman filter, on average"), trial) if isinstance(trial, Refusal) else
        _nis(trial.expected, trial.test.dof),
        _refused(text("disk margin α"), margins) if isinstance(margins, Refusal) else _disk(margins.together)),
        HEADS, text("Green: the band that is accepted. A number outside it has an arrow or a needle in another colour."), VERDICT_TAB)


def _distance(name: Text, report: Observability | Controllability | Refusal) -> Gauge:
    if isinstance(report, Refusal):
        return _refused(name, report)
    weakest = report.weakest
    hidden = any(not mode.visible for mode in report.modes)
    if weakest is None or weakest.margin <= 0 or hidden:
        return Gauge(name, -1.0, UPPER, "0", (tiny(LOST), "1"), f"> {tiny(LOST)}", _verdict(False), "wrong")
    at = min(max(place_of(weakest.margin, LOST, 1.0, UPPER), UPPER[0]), 1.0)
    return Gauge(name, at, UPPER, format_number(weakest.margin, ".2g"), (tiny(LOST), "1"), f"> {tiny(LOST)}", _verdict(True))


def _error(ratio: float | Refusal) -> Gauge:
    name = text("error over the Kalman filter's")
    if isinstance(ratio, Refusal):
        return _refused(name, ratio)
    held = ratio < MOST_ERROR
    return Gauge(name, place_of(max(ratio, 1.0), 1.0, MOST_ERROR, LOWER), LOWER, format_number(ratio, ".3g"), ("1", f"{MOST_ERROR:g}"),
                 f"< {MOST_ERROR:g}", _verdict(held), _role(held))


def _nis(expected: float, outputs: int) -> Gauge:
    low, high = (1 - NIS_SHARE) * outputs, (1 + NIS_SHARE) * outputs
    held = abs(expected / outputs - 1) < NIS_SHARE
    ends = format_number(low, ".3g"), format_number(high, ".3g")
    return Gauge(text("NIS of the Kalman filter, on average"), place_of(expected, low, high), MIDDLE, format_number(expected, ".3g"), ends,
                 f"{ends[0]} … {ends[1]}", _verdict(held), _role(held))


def _disk(alpha: float) -> Gauge:
    held = alpha >= LEAST_DISK
    return Gauge(text("disk margin α"), min(place_of(alpha, LEAST_DISK, 2.0, UPPER), 1.0), UPPER, format_number(alpha, ".3g"),
                 (f"{LEAST_DISK:g}", "2"), f"≥ {LEAST_DISK:g}", _verdict(held), _role(held))


def _refused(name: Text, refusal: Refusal) -> Gauge:
    return Gauge(name, None, UPPER, "—", ("", ""), same("—"), refusal.text, "muted")


def _verdict(held: bool) -> Text:
    return text("passes") if held else text("flagged")


def _role(held: bool) -> str:
    return "right" if held else "wrong"
