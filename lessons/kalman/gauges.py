"""Show the four tests of a record as gauges."""

from __future__ import annotations

from collections.abc import Mapping

from observer_lab.course.figures.gauges import MIDDLE, UPPER, Gauge, place_of
from observer_lab.engine.filters import InnovationTest, SquaredError
from observer_lab.text import Text, format_number, text, text_in

from .p_values import chance

LEAST_P = 0.05 / 3  # three tests of one record share five percent
HEADS = (text_in("kalman", "test"), text("value"), text("band"), text("verdict"))


def gauges_of(test: InnovationTest, settled: SquaredError, held: Mapping[str, bool], bias_judged: bool,
              digits: str = ".3g") -> tuple[Gauge, ...]:
    """Means of NIS and NEES between the ends of their bands, and two p-values above the least; `digits` are those of NIS."""
    return (
        _mean(text("mean of NIS"), test.nis, held["nis"], digits),
        _mean(text("mean of NEES"), settled, held["nees"], ".3g"),
        _chance(text("whiteness, p"), test.whiteness.p_value, held["white"]),
        _chance(text("bias, p"), test.bias_p_value, held["centred"] if bias_judged else None),
    )


def _mean(name: Text, found: SquaredError, held: bool, digits: str) -> Gauge:
    low, high = found.mean_band
    ends = format(low, digits), format(high, digits)
    return Gauge(name, place_of(found.mean, low, high), MIDDLE, format_number(found.mean, digits), ends,
                 f"{ends[0]} … {ends[1]}", _verdict(held), "right" if held else "wrong")


def _chance(name: Text, p: float, held: bool | None) -> Gauge:
    verdict = text("not judged: it assumes white innovations of covariance S") if held is None else _verdict(held)
    role = "muted" if held is None else "right" if held else "wrong"
    return Gauge(name, place_of(p, LEAST_P, 1.0, UPPER), UPPER, chance(p), ("0.017", "1"), "≥ 0.017", verdict, role)


def _verdict(held: bool) -> Text:
    return text("passes") if held else text("flagged")
