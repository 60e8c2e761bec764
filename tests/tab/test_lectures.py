"""A lecture is given stop by stop, there and back, survives a reload, and can be recorded while its scenes are tried out."""

from __future__ import annotations

import pytest
from fakes import FakeView, Tab

from observer_lab.course.lectures import Lecture, prepared_lectures, read_lecture, words_in, write_lecture
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import OpenLesson, SetLanguage, TurnPage, Undo
from observer_lab.session.commands.guide import EndLecture, GoToScene, OpenLecture, RecordStop, SaveLecture, SetMode, TurnScene
from observer_lab.session.session import Session
from observer_lab.session.state.view import Picture

PREPARED = {words_in(lecture.title, "en"): lecture for lecture in prepared_lectures(LESSONS)}
SHORT = '''title = "Short"
[[stops]]
lesson = "separation"
scene = "predict"
minutes = 4
note = "Ask the hall."
[[stops]]
lesson = "duality"
scene = "meet"
'''


def where(picture: Picture) -> tuple[str, str]:
    assert picture.scene is not None
    return picture.lesson.id, picture.scene.id


def test_three_lectures_are_prepared_and_a_lecture_is_written_as_it_is_read() -> None:
    assert len(PREPARED) == 3
    odd = Lecture({"en": 'a "quoted" \\ title\t\x7f', "zh": "讲"}, next(iter(PREPARED.values())).stops, 7.5)
    for lecture in (*PREPARED.values(), odd):
        assert read_lecture(write_lecture(lecture), LESSONS) == lecture


@pytest.mark.parametrize("title", list(PREPARED))
def test_a_prepared_lecture_is_walked_there_and_back(title: str) -> None:
    lecture = PREPARED[title]
    tab = Tab(LESSONS)
    tab.do(OpenLecture(write_lecture(lecture).encode()))
    assert tab.picture.state.mode == "present" and tab.picture.state.lecture
    seen = []
    for k, stop in enumerate(lecture.stops):
        assert where(tab.picture) == (stop.lesson, stop.scene) and tab.picture.place == (k, len(lecture.stops))
        assert tab.picture.note == (words_in(stop.note, "en") or tab.picture.scene_words.note) != ""
        assert (tab.picture.next_title == "") == (k + 1 == len(lecture.stops))
        assert not tab.view.of("say"), "a lecture was interrupted"
        seen.append(tab.picture.design)
        tab.do(TurnScene(1))
    assert tab.picture.place[0] == len(lecture.stops) - 1, "there is nothing behind the end"
    for k in reversed(range(len(lecture.stops))):
        tab.do(GoToScene(k))
        assert where(tab.picture) == (lecture.stops[k].lesson, lecture.stops[k].scene)
    tab.do(EndLecture())
    assert tab.picture.state.talk is None and (tab.picture.state.mode, tab.picture.state.lecture) == ("guide", False)


def test_a_lecture_is_given_in_the_language_chosen_and_its_notes_come_before_those_of_the_scene() -> None:
    tab = Tab(LESSONS, "duality")
    tab.do(OpenLecture(SHORT))
    assert where(tab.picture) == ("separation", "predict") and tab.picture.note == "Ask the hall."
    tab.do(TurnScene(1))
    tab.do(SetLanguage("zh"))
    assert where(tab.picture) == ("duality", "meet")
    assert tab.picture.note == LESSONS["duality"].words["zh"].scenes["meet"].note


def test_keys_for_lessons_turn_the_stops_of_a_lecture_and_the_scenes_before_a_hall() -> None:
    tab = Tab(LESSONS, "duality")
    tab.do(OpenLecture(SHORT))
    tab.do(TurnPage(+1))
    assert where(tab.picture) == ("duality", "meet") and tab.picture.state.talk is not None
    tab.do(TurnPage(-1))
    assert where(tab.picture) == ("separation", "predict")
    hall = Tab(LESSONS, "separation", mode="present")
    hall.do(TurnPage(+1))
    assert where(hall.picture) == ("separation", LESSONS["separation"].path[1].id)
    for mode in ("guide", "lab"):
        tab = Tab(LESSONS, "separation", mode=mode)
        tab.do(TurnPage(+1))
        assert tab.picture.lesson.id == "duality"


def test_a_wrong_lecture_is_one_sentence_and_nothing_is_lost() -> None:
    tab = Tab(LESSONS, "separation", mode="guide")
    before = where(tab.picture)
    for words in (b"\xff\xfe\xff", b"title = ", SHORT.replace("meet", "nowhere"), 3):
        tab.view.clear()
        tab.do(OpenLecture(words))
        (said,) = tab.view.of("say")
        assert said[1] and str(said[0]("en")).endswith(".")
        assert where(tab.picture) == before and tab.picture.state.talk is None


def test_a_reload_comes_back_to_the_stop_and_a_new_tab_of_the_server_begins_at_the_first() -> None:
    tab = Tab(LESSONS)
    tab.do(OpenLecture(SHORT))
    tab.do(TurnScene(1))
    view = FakeView()
    again = Session(LESSONS, view, "separation")
    again.restore(tab.view.kept)
    again.open()
    assert again.picture is not None and where(again.picture) == ("duality", "meet") and again.picture.place == (1, 2)
    fresh = Tab(LESSONS, "separation", mode="present", insists=True, talk=read_lecture(SHORT, LESSONS))
    assert where(fresh.picture) == ("separation", "predict")


def test_what_is_tried_out_is_recorded_and_saved_as_a_lecture() -> None:
    tab = Tab(LESSONS, "separation", mode="lab")
    tab.do(RecordStop())
    tab.do(SaveLecture())
    assert [bad for _, bad in tab.view.of("say")] == [True, True] and not tab.view.of("file")
    tab.do(SetMode("guide"))
    tab.do(GoToScene(2))
    tab.do(RecordStop())
    noted = [where(tab.picture)]
    tab.do(OpenLesson("duality"))
    tab.do(RecordStop())
    noted.append(where(tab.picture))
    tab.do(Undo())
    tab.do(SaveLecture())
    ((name, content),) = tab.view.of("file")
    found = read_lecture(content.decode(), LESSONS)
    assert name == "lecture.toml" and [(stop.lesson, stop.scene) for stop in found.stops] == noted
    assert tab.picture.state.recorded == ()
