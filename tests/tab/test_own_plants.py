"""The user's own plant in a tab: upload, undo, reload, and refusals that cost one sentence and nothing else."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from fakes import FakeView, Tab, toy

from observer_lab.course.knobs import KnobError, Number
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.engine import Plant, from_json, to_json
from observer_lab.plants import Model
from observer_lab.plants.examples import DATA, EXAMPLES, example
from observer_lab.plants.own_plant import canonical_text
from observer_lab.session.commands.commands import ChoosePlant, OpenLesson, Predict, Redo, Reset, Seek, Undo, UploadPlant
from observer_lab.session.handlers.design import YOURS
from observer_lab.session.session import Session
from observer_lab.session.state.history import MERGE_WINDOW_S
from observer_lab.session.state.view import Picture
from observer_lab.text import Text, text

SMALL = Plant(np.diag([-1.0, -2.0]), np.ones((2, 1)), np.ones((1, 2)), name="small")
LARGE = Plant(-np.eye(5), np.ones((5, 1)), np.ones((1, 5)), name="large")


def wear(_: Lesson, model: Model, name: str = "toy") -> Lesson:
    """The toy for a plant: a knob of its own for each state, and none of the tasks. Refuses three states, breaks on
    six."""
    n = model.plant.n
    if n == 3:
        raise KnobError(text("Three states do not fit this lesson."))
    extra = tuple(Number(f"state{i}", "x", Text(f"state {i}", f"状态 {i}"), low=0.0, high=1.0, default=0.5)
                  for i in range(n))
    lesson = toy(name)

    def compute(design: Design) -> Outcome:
        if n == 6:
            raise ZeroDivisionError("division by zero")
        return lesson.compute(design)
    return replace(lesson, knobs=(*lesson.knobs, *extra), compute=compute, tasks=())


def tab_of(**options: object) -> Tab:
    return Tab({"toy": toy(adapt=wear), "plain": toy("plain")}, **options)


def file_of(plant: Plant, name: str = "mine.json") -> tuple[str, bytes]:
    return name, to_json(plant).encode()


def test_an_upload_opens_the_lesson_with_the_plant() -> None:
    tab = tab_of()
    tab.do(UploadPlant(*file_of(SMALL)))
    assert tab.picture.design.plant == canonical_text(SMALL) and tab["state1"] == 0.5
    assert [name for name, _ in tab.view.calls if name in ("build", "show", "pose")][:3] == ["build", "show", "pose"]
    assert "small" in tab.shown.lesson.words["en"].introduction and "small" in tab.shown.lesson.words["zh"].introduction
    assert not tab.shown.lesson.tasks and not tab.view.scolded()
    tab.set(state1=0.75)
    assert tab["state1"] == 0.75 and tab.picture.design.plant == canonical_text(SMALL)


def test_undo_and_redo_walk_across_plants() -> None:
    tab = tab_of()
    tab.set(gain=3.0)
    tab.clock.advance(MERGE_WINDOW_S + 0.1)
    tab.do(UploadPlant(*file_of(SMALL)))
    tab.do(UploadPlant(*file_of(LARGE)))
    tab.view.clear()
    tab.do(Undo())
    assert tab.picture.design.plant == canonical_text(SMALL) and len(tab.shown.lesson.knobs) == len(toy().knobs) + 2
    tab.do(Undo())
    assert tab.picture.design.plant == "" and tab["gain"] == 3.0 and tab.shown.lesson.tasks
    assert len(tab.view.of("build")) == 2
    tab.do(Redo())
    tab.do(Redo())
    assert tab.picture.design.plant == canonical_text(LARGE) and tab["state4"] == 0.5
    assert not tab.view.scolded()


def test_back_to_the_lessons_own_plant_and_to_ones_own_again() -> None:
    tab = tab_of()
    tab.do(UploadPlant(*file_of(SMALL)))
    tab.do(ChoosePlant(""))
    assert tab.picture.design == tab.lessons["toy"].start()
    assert tab.picture.state.plant == canonical_text(SMALL)
    tab.do(ChoosePlant(YOURS))
    assert tab.picture.design.plant == canonical_text(SMALL)
    tab.do(ChoosePlant("aircraft"))
    assert tab.picture.design.plant == example("aircraft") and tab.picture.state.plant == canonical_text(SMALL)


def test_reset_keeps_the_plant() -> None:
    tab = tab_of()
    tab.do(UploadPlant(*file_of(SMALL)))
    tab.set(state0=0.9)
    tab.do(Reset())
    assert tab["state0"] == 0.5 and tab.picture.design.plant == canonical_text(SMALL)


def test_a_reload_brings_the_plant_back_shown_or_not() -> None:
    for shown in (True, False):
        tab = tab_of()
        tab.do(UploadPlant(*file_of(SMALL)))
        tab.set(state0=0.25)
        if not shown:
            tab.do(ChoosePlant(""))
        tab.rest()
        again = Session(tab.lessons, FakeView(), "plain")
        again.restore(tab.view.kept)
        again.open()
        assert again.picture is not None and again.picture.design == tab.picture.design
        assert again.picture.state.plant == canonical_text(SMALL)


def test_the_plant_comes_along_to_the_next_lesson_only_while_it_is_shown() -> None:
    lessons = {"toy": toy(adapt=wear), "other": toy("other", adapt=partial(wear, name="other")),
               "third": toy("third", adapt=partial(wear, name="third")), "plain": toy("plain")}
    tab = Tab(lessons)
    tab.do(UploadPlant(*file_of(SMALL)))
    tab.do(OpenLesson("other"))
    assert tab.picture.design.plant == canonical_text(SMALL)
    tab.do(ChoosePlant(""))
    tab.do(OpenLesson("third"))
    assert tab.picture.design.plant == ""
    tab.do(OpenLesson("toy"))
    assert tab.picture.design.plant == canonical_text(SMALL)  # every lesson keeps its own desk
    tab.do(OpenLesson("plain"))
    assert tab.picture.design == lessons["plain"].start() and not tab.view.scolded()


def test_a_server_may_bring_a_plant_for_every_tab() -> None:
    tab = tab_of(plant=canonical_text(SMALL))
    assert tab.picture.design.plant == canonical_text(SMALL)
    tab.do(OpenLesson("plain"))
    assert tab.picture.design.plant == ""


def test_two_tabs_do_not_see_each_others_plants() -> None:
    lessons = {"toy": toy(adapt=wear)}
    a, b = Tab(lessons), Tab(lessons)
    a.do(UploadPlant(*file_of(SMALL)))
    assert b.picture.design.plant == "" and b.picture.state.plant == ""
    b.do(ChoosePlant(YOURS))
    assert b.picture.design.plant == ""


HOSTILE = [
    ("mine.json", b""), ("mine.json", b"{"), ("mine.json", b"[1, 2]"), ("mine.json", b"\xff\xfe\x00"),
    ("mine.mat", b"nothing"), ("mine.mat", b""), ("mine.exe", b"MZ"), ("", b"{}"), ("mine.json", b"[" * 100_000),
    ("mine.json", b"9" * 1_000_001), ("mine.json", json.dumps({"A": [[1e999]], "B": [[1]], "C": [[1]]}).encode()),
    ("mine.json", json.dumps({"A": [[0.0] * 31] * 31, "B": [[1]] * 31, "C": [[1] * 31]}).encode()),
    ("mine.json", json.dumps({"A": [[1, 2]], "B": [[1]], "C": [[1]]}).encode()),
    file_of(Plant(-np.eye(3), np.ones((3, 1)), np.ones((1, 3)))),  # the lesson does not take it
    file_of(Plant(-np.eye(6), np.ones((6, 1)), np.ones((1, 6)))),  # the lesson breaks on it
]


@pytest.mark.parametrize("file", HOSTILE, ids=[f"{i}-{name}" for i, (name, _) in enumerate(HOSTILE)])
@pytest.mark.parametrize("before", [None, SMALL], ids=["own", "uploaded"])
def test_a_refused_file_costs_one_sentence_and_the_last_picture_stays(file: tuple[str, bytes],
                                                                      before: Plant | None) -> None:
    tab = tab_of()
    if before is not None:
        tab.do(UploadPlant(*file_of(before)))
    tab.set(gain=2.0)
    tab.view.clear()
    good = tab.picture
    tab.do(UploadPlant(*file))
    assert len(tab.view.scolded()) == 1
    said = tab.view.scolded()[0]
    assert said("en").strip() and said("zh").strip() and "\n" not in said("en")
    assert tab.picture.design == good.design and tab.picture.lesson is good.lesson
    assert tab.picture.outcome is good.outcome
    kept = canonical_text(from_json(file[1].decode())) if file in HOSTILE[-2:] else good.state.plant  # for the lessons that take it
    assert tab.picture.state.plant == kept
    assert ("kept for the lessons" in said("en")) == (file in HOSTILE[-2:])
    tab.set(gain=4.0)
    assert tab.shown.design["gain"] == 4.0 and tab.shown.design.plant == good.design.plant


@pytest.mark.parametrize("argument",
                         [(None, b""), (3, b"{}"), ("mine.json", "{}"), ("mine.json", [1, 2]), ("mine.json", None),
                                      ("mine.json", 10**12)])
def test_an_upload_of_nonsense_costs_one_sentence(argument: tuple[object, object]) -> None:
    tab = tab_of()
    tab.do(UploadPlant(*argument))
    assert len(tab.view.scolded()) == 1 and tab.picture.design == tab.lessons["toy"].start()


def test_a_lesson_that_takes_no_plant_says_so() -> None:
    tab = tab_of()
    tab.do(OpenLesson("plain"))
    tab.do(UploadPlant(*file_of(SMALL)))
    assert "about its own plant" in tab.view.scolded()[0]("en") and tab.picture.design.plant == ""


def test_a_screen_that_cannot_show_the_new_plant_is_laid_out_for_the_old_one_again() -> None:
    class Fragile(FakeView):
        def show(self, picture: Picture) -> None:
            if picture.design.plant:
                raise RuntimeError("the screen cannot draw this")
            super().show(picture)
    view = Fragile()
    session = Session({"toy": toy(adapt=wear)}, view, "toy")
    session.open()
    tab = tab_of()
    tab.session, tab.view = session, view
    tab.do(UploadPlant(*file_of(SMALL)))
    built = [picture.design.plant for picture in view.of("build")]
    assert built[-1] == "" and built[-2] == canonical_text(SMALL)
    assert view.of("show")[-1].design.plant == "" and len(view.scolded()) == 1


def test_names_from_a_file_are_plain_words_wherever_they_go() -> None:
    """They end in HTML, Markdown and LaTeX: nothing in them may mean anything there."""
    evil = Plant(-np.eye(2), np.ones((2, 1)), np.ones((1, 2)), None, 0.0, ("<img src=x onerror=1>", "$\\frac"),
                 ("`u`",), ("**y**",), (("**y**", "</b>"),), "<script>alert(1)</script>")
    text = canonical_text(evil)
    assert not set("<>&$\\`*{}|#'[]") & set(json.loads(text)["name"] + "".join(json.loads(text)["states"]))
    tab = tab_of()
    tab.do(UploadPlant(*file_of(evil)))
    assert "<" not in tab.picture.lesson.words["en"].introduction
    long = Plant(-np.eye(1), np.eye(1), np.eye(1), state_names=("x" * 90,), name="n" * 99)
    assert len(json.loads(canonical_text(long))["states"][0]) <= 18
    assert canonical_text(long) == canonical_text(replace(long, name="n" * 40, state_names=("x" * 18,)))


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_plants_pass_the_gate_of_a_strangers_file(name: str) -> None:
    tab = tab_of()
    file = EXAMPLES[name].file
    tab.do(UploadPlant(file, (DATA / file).read_bytes()))
    assert tab.picture.design.plant == example(name)


def test_a_new_plant_stands_at_the_start_of_its_run_on_the_stage_too() -> None:
    tab = tab_of()
    tab.do(Predict(0))
    tab.clock.advance(0.3)
    tab.do(Seek(0.3))
    tab.do(UploadPlant(*file_of(SMALL)))
    assert tab.shown.state.t == 0.0 and not tab.shown.state.playing
    assert tab.view.of("pose")[-1] == 0.0


@pytest.mark.parametrize("odd", [{"A": [[1e300]]}, {"B": [[-1e300]]}, {"dt": 1e308}, {"A": [[-1e31]], "C": [[1e300]]}], ids=str)
def test_numbers_beyond_reach_cost_one_sentence_and_no_traceback(odd: dict[str, object], caplog: pytest.LogCaptureFixture) -> None:
    tab = tab_of()
    tab.do(UploadPlant("mine.json", json.dumps({"A": [[-1.0]], "B": [[1.0]], "C": [[1.0]], **odd}).encode()))
    (said,) = tab.view.scolded()
    assert "10³⁰" in said("en") and "10³⁰" in said("zh")
    assert not [record for record in caplog.records if record.exc_info]
