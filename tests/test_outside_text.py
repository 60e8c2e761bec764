"""JSON from outside gives text that can be sent and written, or is refused; it never gives text that no encoder takes."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.course.knobs import KnobError
from observer_lab.lessons import LESSONS
from observer_lab.page.viser_private.browser_storage import check_browser_memory
from observer_lab.page.viser_private.message_transport import pack_any_text
from observer_lab.session.state.saved_state import VERSION, check_state, read_saved_designs, read_state
from observer_lab.session.state.tab_memory import read_memory
from observer_lab.session.state.token import packed, read_token
from observer_lab.text import read_outside_json, replace_surrogates

ODD = st.text(st.characters() | st.characters(categories=["Cs"]), max_size=8)
DATA = st.recursive(ODD | st.integers() | st.booleans() | st.none(),
                    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(ODD, inner, max_size=3), max_leaves=8)


def encodable(data: object) -> bool:
    """Whether every text in plain data has an encoding in UTF-8."""
    match data:
        case str():
            return data == data.encode("utf-8", "ignore").decode()
        case list():
            return all(map(encodable, data))
        case dict():
            return all(encodable(key) and encodable(value) for key, value in data.items())
    return True


@given(DATA, st.booleans())
def test_whatever_json_says_can_be_sent(data: object, escaped: bool) -> None:
    """Halves of surrogate pairs come as escapes or, where a text was decoded before, as they are."""
    words = json.dumps(data, ensure_ascii=escaped)
    read = read_outside_json(words)
    assert encodable(read)
    plain = words.encode("utf-8", "ignore").decode()
    if encodable(json.loads(words)) and plain == words:
        assert read == json.loads(words), "what can be sent is read as it is"


@given(ODD)
def test_replaced_words_are_as_long_and_differ_in_odd_characters_alone(words: str) -> None:
    plain = replace_surrogates(words)
    assert encodable(plain) and len(plain) == len(words)
    assert all(a == b or "\ud800" <= a <= "\udfff" for a, b in zip(words, plain, strict=True))


@pytest.mark.parametrize("words", ['{"a": 1, "a": 2}', '{"knobs": {"q": 1, "q": 2}}', "[" * 100_000, "{", '"'], ids=lambda w: w[:20])
def test_what_has_two_meanings_or_none_is_refused(words: str) -> None:
    with pytest.raises(ValueError):
        read_outside_json(words)


FIELDS = {"version": VERSION, "lesson": "separation", "knobs": {"delay": "6"}}


@pytest.mark.parametrize("odd", [{"lesson": "\ud800"}, {"knobs": {"\udfff": "1"}}, {"knobs": {"delay": "\ud800"}}, {"\ud800": 1},
                                 {"plant": "\udead"}, {"tab": "\ud800"}, {"language": "\ud800"}], ids=str)
def test_a_state_with_half_a_character_is_one_sentence_that_can_be_sent(odd: dict[str, object]) -> None:
    written = json.dumps(FIELDS | odd)
    for read in (lambda: read_state(written, LESSONS), lambda: read_token(packed(written), LESSONS)):
        try:
            saved = read()
        except KnobError as problem:
            assert all(encodable(str(said)) for said in (problem, problem.text("en"), problem.text("zh")))
        else:
            assert all(encodable(note("en")) for note in saved.notes) and encodable(saved.tab)


@pytest.mark.parametrize("hostile", ["\ud800", json.dumps({"version": 1, "lesson": "\ud800", "desks": {"\ud800": {}}}),
                                     json.dumps({"name \ud800": json.dumps({**FIELDS, "lesson": "\ud800"})})], ids=ascii)
def test_what_a_browser_kept_is_passed_over_or_can_be_sent(hostile: str) -> None:
    said = check_browser_memory(json.dumps([hostile, hostile, True, hostile, hostile, hostile]))
    assert all(encodable(part) for part in said if isinstance(part, str))
    assert read_memory(said[0], LESSONS) is None
    assert all(encodable(design.name) for design in read_saved_designs(said[5], LESSONS))
    with pytest.raises(KnobError):
        check_state(read_outside_json(json.dumps({"lesson": hostile})), LESSONS)


def test_an_answer_with_half_a_character_is_sent_without_it() -> None:
    def strict(content: object) -> bytes:
        return json.dumps(content, ensure_ascii=False).encode()
    pack = pack_any_text(strict)
    assert pack({"a": ["\ud800b", 1]}) == strict({"a": ["\ufffdb", 1]})
    assert pack({"a": [b"", 1][1:]}) == strict({"a": [1]})
