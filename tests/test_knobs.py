"""Knobs: what they accept, what they refuse, and that words read back as values."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laws import holds_for_all
from strategies import values_of

from observer_lab.course.knobs import MAX_TRACK, Choice, Knob, KnobError, Number, Poles, Switch, Track
from observer_lab.course.lesson import Design
from observer_lab.text import same, text

LINEAR = Number("gain", "g", text("gain"), "N", low=-2.0, high=3.0, default=1.0)
LOG = Number("weight", "w", text("weight"), low=1e-6, high=1e6, default=1.0, scale="log")
INTEGER = Number("seed", "s", text("seed"), low=0, high=9999, default=1, scale="integer")
CHOICE = Choice("mode", "", text("mode"), options=(("by-hand", same("a")), ("by-rule", same("b"))), default="by-hand")
SWITCH = Switch("limited", "", text("limited"))
POLES = Poles("poles", "p", text("poles"), default=(-1 + 1j, -1 - 1j, -2 + 0j), re_low=-10, re_high=1, im_high=8)
TRACK = Track("hand", "h", text("hand"), low=-1.0, high=1.0)
KNOBS = (LINEAR, LOG, INTEGER, CHOICE, SWITCH, POLES, TRACK)
every_knob = pytest.mark.parametrize("knob", KNOBS, ids=lambda k: k.name)
quick = settings(max_examples=150, derandomize=True, database=None)


@every_knob
@quick
@given(data=st.data())
def test_a_checked_value_is_hashable_and_checking_again_changes_nothing(knob: Knob, data: st.DataObject) -> None:
    value = knob.check(data.draw(values_of(knob)))
    assert knob.check(value) == value and hash(value) == hash(knob.check(value))


@every_knob
@quick
@given(data=st.data())
def test_a_value_travels_as_json(knob: Knob, data: st.DataObject) -> None:
    value = knob.check(data.draw(values_of(knob)))
    sent = json.dumps(value, default=lambda z: [z.real, z.imag], allow_nan=False)
    assert knob.check(json.loads(sent)) == value


@every_knob
@quick
@given(data=st.data())
def test_what_a_knob_shows_it_reads_back(knob: Knob, data: st.DataObject) -> None:
    """Files, reloads and the command line carry these words: a digit lost is another design."""
    value = knob.check(data.draw(values_of(knob)))
    assert knob.parse(knob.show(value)) == value


BAD = (None, float("nan"), float("inf"), 1e9, -1e9, "nonsense", "", [], [float("nan")], {}, object(), 10**400,
       [10**400], [[10**400, 0]], ["x"], [[1, 2, 3]], b"\xff", [None], [[0.0, float("nan")]], [[float("inf"), 0.0]])


def refuses(knob: Knob, bad: Any) -> None:
    """With one short sentence in both languages, which names the knob."""
    if knob is TRACK and isinstance(bad, list | str | dict) and not bad:
        assert knob.check(bad) == ()  # an empty track is a track
        return
    with pytest.raises(KnobError) as caught:
        knob.check(bad)
    assert knob.name in caught.value.text("en") and knob.name in caught.value.text("zh")
    assert knob.label("zh") in caught.value.text("zh") and "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


@every_knob
def test_what_a_knob_refuses_it_refuses_with_one_sentence_in_both_languages(knob: Knob) -> None:
    holds_for_all(BAD, lambda bad: refuses(knob, bad), lambda bad: repr(bad)[:40])


@quick
@given(st.floats(allow_nan=True, allow_infinity=True))
def test_a_number_is_kept_within_its_bounds_or_refused(value: float) -> None:
    try:
        assert LINEAR.low <= LINEAR.check(value) <= LINEAR.high
    except KnobError:
        assert not LINEAR.low <= value <= LINEAR.high


def test_the_bounds_belong_to_a_number_and_are_named_when_it_is_refused() -> None:
    assert LINEAR.check(-2.0) == -2.0 and LINEAR.check(3) == 3.0
    with pytest.raises(KnobError, match=r"-2 … 3 N"):
        LINEAR.check(3.0000001)


@quick
@given(st.floats(1e-9, 1e9), st.floats(1.001, 1e6))
def test_an_end_is_taken_as_it_is_shown(low: float, ratio: float) -> None:
    knob = Number("limit", "u", text("limit"), low=low, high=low * ratio, default=low, scale="log")
    for end in (knob.low, knob.high):
        taken = knob.check(f"{end:g}")
        assert knob.low <= taken <= knob.high and taken == pytest.approx(end, rel=1e-5)
    with pytest.raises(KnobError):
        knob.check(0.99 * low)


def test_integers_are_rounded_and_stay_inside() -> None:
    assert INTEGER.check(3.4) == 3.0 and INTEGER.check("7") == 7.0
    with pytest.raises(KnobError):
        INTEGER.check(9999.4)


def test_a_number_by_name_is_read_from_words() -> None:
    assert LOG.parse("1e-3") == 1e-3
    with pytest.raises(KnobError, match="gain"):
        LINEAR.parse("two")


def test_a_choice_names_its_options() -> None:
    with pytest.raises(KnobError, match="by-hand, by-rule"):
        CHOICE.check("by-chance")


@pytest.mark.parametrize("words, value", [("on", True), ("OFF", False), ("1", True), (0, False), ("yes", True), (True, True)])
def test_a_switch_reads_the_usual_words(words: object, value: bool) -> None:
    assert SWITCH.check(words) is value


@pytest.mark.parametrize("words", ["-2, -1+1j, -1-1j", "(-1+1i; -1-1i; -2)", "[-1 + 1j, -1 - 1j, -2]"])
def test_poles_are_read_in_the_usual_spellings_and_sorted(words: str) -> None:
    assert POLES.parse(words) == (-2 + 0j, -1 - 1j, -1 + 1j)


@quick
@given(values_of(POLES))
def test_poles_are_closed_under_conjugation_and_sorted(poles: tuple[complex, ...]) -> None:
    checked = POLES.check(poles)
    assert sorted(checked, key=lambda p: (p.real, p.imag)) == list(checked)
    assert sorted((p.conjugate() for p in checked), key=lambda p: (p.real, p.imag)) == list(checked)
    assert len(checked) == 3


def test_repeated_pairs_find_their_own_twins() -> None:
    knob = Poles("p", "p", same("p"), default=(0j,) * 4, re_low=-10, re_high=1, im_high=8)
    assert knob.check([-1 + 1j, -1 + 1j, -1 - 1j, -1 - 1j]) == (-1 - 1j, -1 - 1j, -1 + 1j, -1 + 1j)


@pytest.mark.parametrize("poles, why", [
    ([-1, -2], "exactly 3"), ([-1 + 1j, -1 - 2j, -2], "conjugate"), ([-1 + 1j, -1 + 1j, -2], "conjugate"),
    ([-11, -1, -2], "within"), ([2, -1, -2], "within"), ([-1 + 9j, -1 - 9j, -2], "within"),
    ([complex(float("nan"), 0), -1, -2], "within"),
])
def test_poles_that_no_gain_or_board_can_take(poles: list[complex], why: str) -> None:
    with pytest.raises(KnobError, match=why):
        POLES.check(poles)


def test_a_track_is_recorded_from_a_time_on_and_never_grows_without_end() -> None:
    track = TRACK.default
    for i in range(3 * MAX_TRACK):
        track = TRACK.record(track, i * 0.01, (-1) ** i * 0.5)
    assert len(track) == MAX_TRACK
    assert track[-1] == pytest.approx(((3 * MAX_TRACK - 1) * 0.01, -0.5))
    assert TRACK.record(((0.0, 0.1), (1.0, 0.2), (2.0, 0.3)), 1.5, -0.4) == ((0.0, 0.1), (1.0, 0.2), (1.5, -0.4))
    assert TRACK.record(((0.0, 0.1), (1.0, 0.2)), 1.0, 0.5) == ((0.0, 0.1), (1.0, 0.5))


def test_a_track_longer_than_allowed_or_outside_is_refused() -> None:
    with pytest.raises(KnobError, match="at most"):
        TRACK.check([(i, 0.0) for i in range(MAX_TRACK + 1)])
    for bad in ([(-1.0, 0.0)], [(0.0, 1.1)], "1:2:3", "1", "a:b"):
        with pytest.raises(KnobError):
            TRACK.parse(bad) if isinstance(bad, str) else TRACK.check(bad)
    assert TRACK.parse("1:0.5, 0:-0.5") == ((0.0, -0.5), (1.0, 0.5))


def test_a_design_is_a_value() -> None:
    a = Design("x", (("gain", 1.0), ("poles", (1j, -1j))))
    assert a == Design("x", (("gain", 1.0), ("poles", (1j, -1j)))) and hash(a) == hash(a.with_values())
    b = a.with_values(gain=2.0)
    assert (a["gain"], b["gain"], b["poles"]) == (1.0, 2.0, (1j, -1j))
    with pytest.raises(KnobError, match="Lesson x has no knob nobody; it has gain, poles"):
        a["nobody"]
    with pytest.raises(AttributeError):
        a.lesson = "y"  # type: ignore[misc]
