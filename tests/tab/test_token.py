"""A state is a word that comes back as the same state; a torn or hostile word is one sentence; old words stay readable."""

from __future__ import annotations

import json
import random
import zlib
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laws import holds_for_all
from strategies import designs

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.plants.examples import EXAMPLES, example
from observer_lab.plants.own_plant import canonical_text, plant_of
from observer_lab.session.state.saved_state import (
    MAX_CAMERA_DISTANCE,
    MAX_STATE_CHARACTERS,
    NO_STATE,
    OTHER_DEFAULTS,
    SavedState,
    check_state,
    short,
)
from observer_lab.session.state.token import DAMAGED_LINK, LONGEST_LINK, LONGEST_TOKEN, is_token, packed, read_token, unpacked, write_token

USUAL = 300  # characters of the token of a usual design
# Tokens as version 1 wrote them: what they say must be read for ever, and the same.
PROMISED = (
    ("1.w5Xo4HphedDQAiVzAhWhWm2UamCJ6T4AWIXtXg",
     "separation", {"delay": "18", "limited": "on", "u_max": "0.5"}),
    ("1.w5YE4PpgOQKpywzKPgZ6BkaInGCO5gYzCzMT4gIHtSmJPYxAQW8MDB1QNBgCaWM949haANtduuI",
     "kalman", {"noise": "coloured", "q": "0.02", "seed": "7"}),
    ("1.w5dW4fphmRraE4RmfWCIAL2kYKhnZGoFDDdzUzTHJFukmmKEUi0A86QFMw",
     "error-dynamics", {"input": "hand", "hand": "0.5:1, 1.25:-0.75"}),
    ("1.wxIiSBphTS1IvxhiirESkiOhrTMkJ6SkGiRhuhMApxkIaw",
     "sandbox", {"noisy": "on", "seed": "3"}),
    ("1.wxIimBpNlBDuqiZ72ErX1AA8VmVkCh2_ggxUGZlCRrAM9EwskYEFUAyoAzzQZQAf6YIOZUFGvCBCxnrGqMBUB6pPF1MKPkoGdgzEBBQSNmaG"
     "bBnusTNfSBcYMX4G7HEXpYIDAhx_CrDBhJLyTHCrPCc_MQUqiDK6VpafA-5qoQ6xlQD7nsB2I6hoRhpqg1sC7N6hWQTMRYkp-sVwC8F8VGsRSm"
     "B2Anuw4HYr3C6YklrU1JWSapCEmQQBxbuaTQ",
     "sandbox", {"seed": "4"}),
)


def saves(lesson: Lesson) -> st.SearchStrategy[SavedState]:
    """Random states of a lesson: any design, any look of the page."""
    place = st.floats(-MAX_CAMERA_DISTANCE + 1, MAX_CAMERA_DISTANCE - 1).map(lambda v: round(v, 2))
    cameras = st.tuples(*[place] * 5).map(lambda five: (*five, round(five[2] + 1.0, 2)))
    steps = st.integers(0, len(lesson.words["en"].steps) - 1)
    return st.builds(SavedState, designs(lesson), st.sampled_from(["en", "zh"]), st.booleans(), st.none() | st.just("Time"),
                     st.none() | steps, st.none() | cameras)


@pytest.mark.parametrize("lesson", LESSONS.values(), ids=list(LESSONS))
@settings(max_examples=8)
@given(data=st.data())
def test_every_state_survives_its_token(lesson: Lesson, data: st.DataObject) -> None:
    saved = data.draw(saves(lesson))
    token = write_token(lesson, saved)
    assert is_token(token) and read_token(token, LESSONS) == saved
    assert read_token(f"http://127.0.0.1:8080/#{token}", LESSONS) == saved
    assert len(token) < LONGEST_TOKEN


@pytest.mark.parametrize("plant", EXAMPLES)
def test_an_example_plant_is_named_and_an_own_one_is_carried_exactly(plant: str) -> None:
    lesson = LESSONS["sandbox"].fit(example(plant))
    named = SavedState(lesson.start())
    own = SavedState(LESSONS["sandbox"].fit(canonical_text(replace(plant_of(example(plant)), name="Mine"))).start())
    assert len(write_token(lesson, named)) < 100
    for saved in (named, own):
        token = write_token(lesson, saved)
        assert len(token) < LONGEST_LINK and read_token(token, LESSONS) == saved


def test_the_token_of_a_usual_design_is_short() -> None:
    def usual(lesson: Lesson) -> None:
        solved = [lesson.apply(lesson.start(), task.solution) for task in lesson.tasks]
        tokens = [write_token(lesson, SavedState(design, "zh", True, "Time", 2, (1.23, -9.87, 3.1, 0.5, 0.6, 1.38))) for design in solved]
        assert max(map(len, tokens)) <= USUAL, max(map(len, tokens))
    holds_for_all(LESSONS.values(), usual, lambda lesson: lesson.id)


@pytest.mark.parametrize("token, id, changed", PROMISED)
def test_tokens_of_version_1_are_read_for_ever(token: str, id: str, changed: dict[str, object]) -> None:
    saved = read_token(token, LESSONS)
    lesson = LESSONS[id].fit(saved.design.plant)
    assert saved.design.lesson == id
    wanted = lesson.apply(lesson.start(), {name: value for name, value in changes_of(lesson, changed)})
    assert {name: saved.design[name] for name in changed} == {name: wanted[name] for name in changed}


def changes_of(lesson: Lesson, changed: dict[str, object]) -> list[tuple[str, object]]:
    return [(name, lesson.knob(name).parse(str(value))) for name, value in changed.items()]


# --- hostile words -------------------------------------------------------------------------------------------------------
def one_sentence(token: str) -> bool:
    """Whether a token is refused; fails where it is refused otherwise than by one sentence."""
    try:
        read_token(token, LESSONS)
    except KnobError as problem:
        assert "\n" not in problem.text("zh") and 0 < len(str(problem)) < 1000
        return True
    return False


def mutated(token: str, chance: random.Random) -> str:
    """A token with letters changed, lost, doubled or cut off."""
    letters = list(token)
    for _ in range(chance.randint(1, 3)):
        if not letters:
            break
        place = chance.randrange(len(letters))
        match chance.randrange(4):
            case 0:
                letters[place] = chance.choice("abcXYZ019-_.# é\0")
            case 1:
                del letters[place]
            case 2:
                letters.insert(place, letters[place])
            case _:
                letters = letters[:place + 1]
    return "".join(letters)


def test_a_token_changed_on_its_way_is_one_sentence_or_the_same_state() -> None:
    chance = random.Random(7)
    lesson = LESSONS["separation"]
    saved = SavedState(lesson.apply(lesson.start(), lesson.tasks[0].solution), "zh", True)
    token = write_token(lesson, saved)
    refused = 0
    for word in (mutated(token, chance) for _ in range(1000)):
        if one_sentence(word):
            refused += 1
        else:
            assert read_token(word, LESSONS) == saved, word  # a letter put back, or one before a '#'
    assert refused > 900


NESTED = "[" * 90_000
HOSTILE = ("", "1.", "x", "1.AAAA", "2.AAAA", "999.AAAA", "1." + "A" * 70_000, "1.é", *(packed(words) for words in (
    "", "null", "3", "[]", "{}", '{"knobs":3}', '{"knobs":{}}', '{"lesson":"nope","knobs":{}}', NESTED,
    '{"lesson":["separation"],"knobs":{}}', '{"lesson":"separation","knobs":{"delay":NaN}}',
    '{"lesson":"separation","knobs":{"delay":1e999}}', '{"lesson":"separation","knobs":{"delay":[[[]]]}}',
    '{"lesson":"separation","knobs":{"controller_poles":"' + "1," * 50_000 + '"}}', '{"lesson":"separation","knobs":{},"plant":3}',
    '{"lesson":"separation","knobs":{},"plant":"nope"}', '{"lesson":"separation","knobs":{},"plant":{"A":[[1e999]]}}',
    '{"lesson":"separation","knobs":{},"plant":{"A":[[1' + "0" * 500 + ']],"B":[[1]],"C":[[1]]}}',
    '{"lesson":"saturation","knobs":{"kick":"1' + "0" * 5000 + '"}}')))


def test_a_hostile_token_is_one_sentence() -> None:
    assert [token[:60] for token in HOSTILE if not one_sentence(token)] == []


def test_a_token_that_would_unpack_without_end_is_not_unpacked() -> None:
    bomb = packed(" " * (40 * MAX_STATE_CHARACTERS))
    assert len(bomb) < LONGEST_TOKEN
    with pytest.raises(KnobError, match=str(DAMAGED_LINK)):
        unpacked(bomb)


def test_what_is_unknown_is_left_out_with_a_note() -> None:
    lesson = LESSONS["separation"]
    data = {"version": 1, **short(lesson, SavedState(lesson.apply(lesson.start(), {"delay": 18.0})))}
    saved = check_state({**data, "wings": 2, "knobs": {**data["knobs"], "feathers": "3"}}, LESSONS)
    assert saved.design["delay"] == 18.0
    assert [note.id.partition(":")[0] for note in saved.notes] == [
        "Left out, because lesson {id} has no such knob", "Left out, because this Observer Lab has no such part"]
    assert "feathers" in str(saved.notes[0]) and "wings" in str(saved.notes[1])


def test_a_link_made_at_other_defaults_says_so() -> None:
    lesson = LESSONS["separation"]
    data = {"version": 1, **short(lesson, SavedState(lesson.start()))}
    assert check_state(data, LESSONS).notes == ()
    assert check_state({**data, "defaults": "zzzz"}, LESSONS).notes == (OTHER_DEFAULTS,)


@pytest.mark.parametrize("look", [{"camera": [0, 0, 0, 0, 0, 0]}, {"camera": [1e9] * 6}, {"camera": "x"}, {"step": 99}, {"step": True},
                                  {"tab": "x" * 1000}, {"tab": 3}, {"language": "xx"}, {"language": []}, {"print": "yes"}])
def test_a_look_that_cannot_be_is_the_usual_one(look: dict[str, object]) -> None:
    lesson = LESSONS["separation"]
    assert check_state({"version": 1, **short(lesson, SavedState(lesson.start())), **look}, LESSONS) == SavedState(lesson.start())


def test_what_is_no_object_is_no_state() -> None:
    for data in (None, 3, [], {"knobs": 1}, json.loads("{}")):
        with pytest.raises(KnobError, match=str(NO_STATE)):
            check_state(data, LESSONS)


def test_the_words_of_version_1_are_those_it_began_with() -> None:
    """Whoever changes them makes every link of version 1 unreadable: make version 2 instead."""
    from observer_lab.session.state.token import WORDS
    assert zlib.crc32(WORDS.read_bytes()) == 4244540247
