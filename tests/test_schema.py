"""What comes from outside is judged by its type: any misfit is told by the place, the key and the sentence of its own part."""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.text.schema import MAX_SHOWN_CHARACTERS, Checked, Misfit, fitting, judge, says

UNKNOWN = "has no {key}; it has {keys}"


class Part(Checked, frozen=True):
    """A table of a list."""

    first_name: Annotated[str, says("{key} must be a text; it is {value}", max_length=9)]
    share: Annotated[float, says("must be a share", ge=0, le=1)] | None = None


class Whole(Checked, frozen=True):
    """A file."""

    parts: Annotated[list[Annotated[Part, says("must be tables")]], says("is missing", min_length=1)]
    rates: Annotated[dict[str, Annotated[float, says("must be a number")]], says("must be a table")] = msgspec.field(default_factory=dict)


PART = {"first-name": "a", "share": 0.5}


@pytest.mark.parametrize(("data", "place", "key", "words"), [
    ({}, (), "parts", "is missing"),
    ({"parts": []}, (), "parts", "is missing"),
    ({"parts": 3}, (), "parts", "is missing"),
    ({"parts": [PART, 3]}, (), "parts", "must be tables"),
    ({"parts": [PART], "pears": 1}, (), "pears", "has no pears; it has parts, rates"),
    ({"parts": [PART, {**PART, "x`y": 1}]}, ("parts", 1), "x`y", "has no x`y; it has first-name, share"),
    ({"parts": [PART, {"share": 1}]}, ("parts", 1), "first-name", "first-name must be a text; it is None"),
    ({"parts": [{**PART, "first-name": "b" * 99}]}, ("parts", 0), "first-name", "first-name must be a text; it is " + "b" * 40),
    ({"parts": [{**PART, "share": 2}]}, ("parts", 0), "share", "must be a share"),
    ({"parts": [{**PART, "share": True}]}, ("parts", 0), "share", "must be a share"),
    ({"parts": [{**PART, "share": float("nan")}]}, ("parts", 0), "share", "must be a share"),
    ({"parts": [PART], "rates": {"a": "b"}}, (), "rates", "must be a number"),
], ids=[f"case {k}" for k in range(12)])
def test_a_misfit_is_told_by_its_place_and_its_own_sentence(data: Any, place: tuple[str | int, ...], key: str, words: str) -> None:
    with pytest.raises(Misfit) as refused:
        judge(data, Whole, UNKNOWN)
    assert (refused.value.place, refused.value.key, refused.value.words) == (place, key, words)
    assert fitting(data, Whole) is None


LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=50)
DATA = st.recursive(LEAVES, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
    st.sampled_from(["parts", "rates", "first-name", "share", "[0]", "a.b", "`"]), inner, max_size=4), max_leaves=12)


@given(DATA)
def test_any_data_fit_or_are_refused_in_words_of_bounded_length(data: Any) -> None:
    try:
        assert isinstance(judge(data, Whole, UNKNOWN), Whole)
    except Misfit as problem:
        assert len(problem.words) < 2 * MAX_SHOWN_CHARACTERS + 60
