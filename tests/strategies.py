"""Random valid values for every kind of knob, made from the knob's own bounds."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from observer_lab.course.knobs import Choice, Knob, Number, Poles, Switch, Track
from observer_lab.course.lesson import Design, Lesson

LONGEST_TRACK = 6  # pairs of a random hand track
LATEST = 20.0  # s


def values_of(knob: Knob) -> st.SearchStrategy[Any]:
    """Values that `knob.check` must accept."""
    if isinstance(knob, Number):
        return _numbers(knob)
    if isinstance(knob, Choice):
        return st.sampled_from([name for name, _ in knob.options])
    if isinstance(knob, Switch):
        return st.booleans()
    if isinstance(knob, Poles):
        return poles(len(knob.default), knob.re_low, knob.re_high, knob.im_high)
    if isinstance(knob, Track):
        pair = st.tuples(st.floats(0.0, LATEST), st.floats(knob.low, knob.high))
        return st.lists(pair, max_size=LONGEST_TRACK).map(lambda pairs: tuple(sorted(pairs)))
    raise TypeError(f"no strategy for {type(knob).__name__}")


def _numbers(knob: Number) -> st.SearchStrategy[float]:
    if knob.scale == "integer":
        return st.integers(round(knob.low), round(knob.high)).map(float)
    if knob.scale == "log":
        ratio = knob.high / knob.low
        return st.floats(0.0, 1.0).map(lambda share: min(max(knob.low * ratio**share, knob.low), knob.high))
    return st.floats(knob.low, knob.high)


def poles(count: int, re_low: float, re_high: float, im_high: float) -> st.SearchStrategy[tuple[complex, ...]]:
    """Sets of `count` poles closed under conjugation within a window; some of them coincide."""
    real = st.floats(re_low, re_high)
    # below 1e-3 an imaginary part is nobody's wish, and `Poles` takes what is tiny for zero
    imaginary = st.floats(min(1e-3, im_high), im_high) if im_high > 0 else st.just(0.0)

    def build(pairs: list[tuple[float, float]], singles: list[float]) -> tuple[complex, ...]:
        out = [p for re, im in pairs for p in (complex(re, im), complex(re, -im))] + [complex(re, 0.0) for re in singles]
        return tuple(sorted(out, key=lambda p: (p.real, p.imag)))

    def of(n_pairs: int) -> st.SearchStrategy[tuple[complex, ...]]:
        n_singles = count - 2 * n_pairs
        return st.builds(build, st.lists(st.tuples(real, imaginary), min_size=n_pairs, max_size=n_pairs),
                         st.lists(real, min_size=n_singles, max_size=n_singles))
    return st.integers(0, count // 2 if im_high > 0 else 0).flatmap(of)


def designs(lesson: Lesson) -> st.SearchStrategy[Design]:
    """Random designs of a lesson: every knob, hidden ones too, has some valid value."""
    return st.fixed_dictionaries({knob.name: values_of(knob) for knob in lesson.knobs}).map(
        lambda values: lesson.apply(lesson.start(), values))
