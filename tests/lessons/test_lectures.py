"""What is true of a lecture: its scenes exist, its minutes add up, and a wrong file is refused in one sentence."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from observer_lab.course.knobs import KnobError
from observer_lab.course.lectures import Lecture, read_lecture, words_in
from observer_lab.lessons import LESSONS
from observer_lab.text import languages

FOLDER = Path(__file__).parents[2] / "assets" / "lectures"
FILES = ("separation-30.toml", "kalman-45.toml", "demo-10.toml")
STOP = '[[stops]]\nlesson = "separation"\nscene = "meet"\n'


def lecture(name: str) -> Lecture:
    """A prepared lecture."""
    return read_lecture((FOLDER / name).read_text(encoding="utf-8"), LESSONS)


def test_all_prepared_lectures_are_tested() -> None:
    assert {path.name for path in FOLDER.glob("*.toml")} == set(FILES)


@pytest.mark.parametrize("name", FILES)
def test_every_scene_of_a_prepared_lecture_exists(name: str) -> None:
    for stop in lecture(name).stops:
        assert stop.scene in {scene.id for scene in LESSONS[stop.lesson].path}


@pytest.mark.parametrize("name", FILES)
def test_the_minutes_of_the_stops_add_up_to_those_of_the_title(name: str) -> None:
    found = lecture(name)
    for language in languages():
        promised = re.search(r"\d+", found.title[language])
        assert promised is not None and float(promised[0]) == found.minutes
    assert abs(sum(stop.minutes for stop in found.stops) - found.minutes) <= 0.2 * found.minutes


@pytest.mark.parametrize("name", FILES)
def test_a_prepared_lecture_is_written_in_every_language(name: str) -> None:
    found = lecture(name)
    for words in (found.title, *(stop.note for stop in found.stops if stop.note)):
        assert set(words) == set(languages())


def test_a_short_lecture_takes_minutes_and_words_as_they_are() -> None:
    scene = next(scene for scene in LESSONS["separation"].path if scene.id == "meet")
    found = read_lecture('title = "Mine"\n' + STOP + STOP + 'minutes = 3\nnote = "Wait."\n', LESSONS)
    assert [(stop.lesson, stop.scene, stop.minutes) for stop in found.stops] == [
        ("separation", "meet", scene.minutes), ("separation", "meet", 3.0)]
    assert found.minutes == found.planned == scene.minutes + 3.0
    assert words_in(found.title, "zh") == "Mine" and words_in(found.stops[1].note, "en") == "Wait."
    assert words_in(found.stops[0].note, "en") == ""


def test_words_are_given_in_the_language_asked_for() -> None:
    assert words_in({"en": "one", "zh": "一"}, "zh") == "一"
    assert words_in({"zh": "一"}, "en") == "一"


@pytest.mark.parametrize(("file", "said"), [
    ("title = ", "TOML"),
    (STOP, "title"),
    ('title = 3\n' + STOP, "title"),
    ('title = {en = 3}\n' + STOP, "title"),
    ('title = "a"\n', "stops"),
    ('title = "a"\nstops = 3\n', "stops"),
    ('title = "a"\nstops = [3]\n', "Stop 1 "),
    ('title = "a"\nspeaker = "b"\n' + STOP, "speaker"),
    ('title = "a"\nminutes = 0\n' + STOP, "minutes"),
    ('title = "a"\nminutes = "ten"\n' + STOP, "minutes"),
    ('title = "a"\n' + STOP + '[[stops]]\nlesson = "nowhere"\nscene = "meet"\n', "Stop 2: there is no lesson nowhere"),
    ('title = "a"\n' + STOP + '[[stops]]\nscene = "meet"\n', "Stop 2: there is no lesson"),
    ('title = "a"\n' + STOP + '[[stops]]\nlesson = ["separation"]\n', "Stop 2: there is no lesson"),
    ('title = "a"\n' + STOP + '[[stops]]\nlesson = "separation"\nscene = "no"\n', "Stop 2: the lesson separation has no scene no;"),
    ('title = "a"\n' + STOP + STOP + 'knobs = 3\n', "Stop 2 has an unknown key knobs"),
    ('title = "a"\n' + STOP + STOP + 'minutes = true\n', "Stop 2: the minutes"),
    ('title = "a"\n' + STOP + STOP + 'minutes = nan\n', "Stop 2: the minutes"),
    ('title = "a"\n' + STOP + STOP + 'note = 3\n', "Stop 2: the note"),
])
def test_a_wrong_lecture_is_refused_in_one_sentence(file: str, said: str) -> None:
    with pytest.raises(KnobError) as refused:
        read_lecture(file, LESSONS)
    sentence = refused.value.text("en")
    assert said in sentence and sentence.endswith(".") and "\n" not in sentence
    assert refused.value.text("zh") != sentence


def test_an_error_quotes_only_a_little_of_the_file() -> None:
    with pytest.raises(KnobError) as refused:
        read_lecture(f'title = "a"\n{"k" * 5000} = 1\n{STOP}', LESSONS)
    assert len(refused.value.text("en")) < 200
