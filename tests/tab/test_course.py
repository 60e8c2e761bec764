"""The lessons as a course: what needs what, three ways, and how far a person is, also after a reload."""

from __future__ import annotations

import json
import re

import pytest
from fakes import FakeView, Tab, toy
from laws import holds_for_all

from observer_lab.course.course_map import Progress
from observer_lab.course.learning_paths import ONWARD, next_lessons, paths_with_lessons
from observer_lab.course.prose import read_notes
from observer_lab.lessons import LESSONS, folder
from observer_lab.session.commands.commands import CheckTask, OpenLesson, Predict, ToggleCourse
from observer_lab.session.session import Session
from observer_lab.session.state.tab_memory import progress_in_saved_state

LARGEST = 10_000  # bytes of a card's picture


def test_every_lesson_has_its_place_and_needs_only_what_comes_before() -> None:
    def law(name: str) -> None:
        lesson, place = LESSONS[name], LESSONS[name].place
        assert place.picture is not None
        picture = place.picture.read_bytes()
        assert picture[:4] == b"RIFF" and picture[8:12] == b"WEBP" and len(picture) < LARGEST
        assert place.picture.parent == folder(name)
        minutes = re.search(r"## Time\n(\d+) minutes", read_notes(folder(name), "en"))
        assert minutes is not None and int(minutes[1]) == place.minutes
        assert all(LESSONS[need].number < lesson.number for need in place.needs)
        assert bool(place.needs) == (lesson.number > 1)
        led = next_lessons(lesson, LESSONS.values())
        assert len(led) == len(set(led)) <= ONWARD and all(other.number > lesson.number for other in led)
        for way in place.ways:
            later = [other for other in paths_with_lessons(LESSONS.values())[way] if other.number > lesson.number]
            assert not later or later[0] in led, "the next one on each way"
    holds_for_all(LESSONS, law)
    assert {way.id: len(on_it) for way, on_it in paths_with_lessons(LESSONS.values()).items()} == {
        "first": 8,
        "estimation": 8,
        "platform": 6,
    }


def test_the_page_of_lessons_tells_how_far_one_is_also_after_a_reload() -> None:
    tab = Tab({name: toy(name) for name in ("first", "second", "third")})
    tab.do(Predict(1))
    tab.set(gain=6.0)
    tab.do(CheckTask("high"))
    tab.do(OpenLesson("second"))
    tab.do(Predict(-1))
    tab.do(ToggleCourse())
    wanted = {"first": Progress(True, 1), "second": Progress(True, 0)}
    assert tab.view.of("course") == [wanted]
    view = FakeView()
    again = Session(tab.lessons, view, "first")
    again.restore(tab.view.kept)
    again.open()
    again.post(ToggleCourse())
    again.step()
    assert view.of("course") == [wanted]


@pytest.mark.parametrize("desk", [
    None, 3, [], {}, {"tasks": 3, "predicted": 1}, {"predicted": None, "tasks": {"a": 3, "b": [1], "c": [0, False, 1]}}])
def test_a_torn_desk_has_no_progress(desk: object) -> None:
    assert progress_in_saved_state(json.loads(json.dumps(desk))) == Progress()
