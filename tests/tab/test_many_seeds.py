"""Many seeds of one design: progress, cancel, the class, and what ends them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
import pytest
from fakes import Tab, toy

from observer_lab.classroom.room import ClassRuns, RoomView, read_runs
from observer_lab.course.lesson import Outcome
from observer_lab.course.many_seeds import SEED_COUNT, SeedErrors
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import Command, LookFrom, OpenLesson, SetLanguage
from observer_lab.session.commands.room import RunSeeds
from observer_lab.text import same

STEPS = 6
SEATS = {7: 70, 3: 30, 9: 90}  # seeds by the followers' numbers


class Desk:
    """A room that notes what it is asked."""

    audience = ""

    def __init__(self, seeds: Mapping[int, int]) -> None:
        self.seeds, self.shown = seeds, list[ClassRuns | None]()

    def draw_seeds(self) -> Mapping[int, int]:
        return self.seeds

    def show_runs(self, runs: ClassRuns | None) -> None:
        self.shown.append(runs)

    def open_vote(self, *_: object) -> RoomView:
        return RoomView()

    def close_vote(self, *_: object) -> RoomView:
        return RoomView()

    lower_hands = show_counts = discuss = reveal = close_vote


class Class:
    """A tab whose lesson runs seeds in STEPS steps, one for each look at the mailbox; the error of a seed is (seed, −seed)."""

    def __init__(self, seeds: Mapping[int, int] = SEATS, problem: Exception | None = None) -> None:
        self.desk, self.problem, self.ran, self.ended = Desk(seeds), problem, list[list[int]](), 0
        lessons = {"toy": toy(seeds=self.run), "other": toy("other")}
        self.tab = Tab(lessons, desk=self.desk)

    def run(self, outcome: Outcome, seeds: np.ndarray) -> Iterator[tuple[float, SeedErrors | None]]:
        self.ran.append([int(seed) for seed in seeds])
        try:
            for k in range(1, STEPS + 1):
                if k == 3 and self.problem is not None:
                    raise self.problem
                self.tab.session.post(LookFrom("all"))
                yield k / STEPS, errors_of(seeds)
        finally:
            self.ended += 1

    def step(self, count: int = STEPS + 2) -> Tab:
        for _ in range(count):
            self.tab.clock.advance(0.25)
            self.tab.session.step(0.0)
        return self.tab


def errors_of(seeds: np.ndarray) -> SeedErrors:
    e = np.column_stack([seeds, -seeds]).astype(float)
    return SeedErrors(1.0, e, 2000.0 * np.eye(2), np.eye(2), (same("a"), same("b")), np.array([0.0, 1.0]),
                      np.column_stack([0 * seeds, seeds]), np.array([1.0, 2.0]))


def test_the_class_runs_the_seeds_of_its_seats_and_each_seat_gets_its_own() -> None:
    lecture = Class()
    lecture.tab.do(RunSeeds())
    fractions = []
    for _ in range(STEPS + 2):
        lecture.step(1)
        many = lecture.tab.picture.many
        assert many is not None
        fractions.append(many.fraction)
    assert fractions[0] is not None and fractions[-1] is None and lecture.ran == [[70, 30, 90]]
    many = lecture.tab.picture.many
    assert many is not None and many.found is not None and many.followers and many.found.count == 3
    assert len(lecture.desk.shown) == 1 and lecture.desk.shown[0] is not None
    sent = read_runs(lecture.desk.shown[0].write())
    assert {seat: round(run.path[-1], 9) for seat, run in sent.runs.items()} == SEATS and sent == lecture.desk.shown[0]
    assert {seat for seat, run in sent.runs.items() if run.inside} == {3, 7}, "90² + 90² is beyond 5.99 · 2000, 70² + 70² is not"


def test_what_the_presenter_sees_does_not_say_whose_run_a_point_is() -> None:
    """The points stand in an order of their own, which is the same however the seats lie."""
    some, others = (errors_of(np.array(seeds)).shown for seeds in ([70, 30, 90], [90, 70, 30]))
    np.testing.assert_array_equal(some, others)


def test_a_second_press_cancels() -> None:
    lecture = Class()
    lecture.tab.do(RunSeeds())
    lecture.step(2)
    lecture.tab.do(RunSeeds())
    assert lecture.ended == 1 and lecture.tab.picture.many is None
    lecture.step()
    assert lecture.desk.shown == [], "nobody is shown half a class"
    lecture.tab.do(RunSeeds())
    assert lecture.step().picture.many is not None and len(lecture.desk.shown) == 1


@pytest.mark.parametrize("change", [lambda tab: tab.set(gain=3.0), lambda tab: tab.do(OpenLesson("other"))], ids=["knob", "lesson"])
def test_another_design_takes_the_cloud_away_from_all_pages(change: Callable[[Tab], None]) -> None:
    for steps, taken in ((2, 0), (STEPS + 2, 2)):
        lecture = Class()
        lecture.tab.do(RunSeeds())
        lecture.step(steps)
        change(lecture.tab)
        assert lecture.tab.picture.many is None and lecture.ended == 1
        lecture.step()
        assert lecture.tab.picture.state.many is None
        assert lecture.desk.shown[1:] == [None] * (taken // 2) and len(lecture.desk.shown) == taken


@pytest.mark.parametrize("problem", [EngineError("No."), RuntimeError("no")], ids=["refused", "failed"])
def test_seeds_that_fail_end_with_one_sentence(problem: Exception) -> None:
    lecture = Class(problem=problem)
    lecture.tab.do(RunSeeds())
    tab = lecture.step()
    assert len(tab.view.scolded()) == 1 and tab.picture.many is None and lecture.desk.shown == []


def test_another_language_keeps_the_cloud() -> None:
    lecture = Class()
    lecture.tab.do(RunSeeds())
    lecture.step()
    lecture.tab.do(SetLanguage("zh"))
    assert lecture.tab.picture.many is not None and lecture.desk.shown[1:] == []


def test_a_lesson_without_seeds_says_which_have_them() -> None:
    tab = Tab()
    tab.do(RunSeeds())
    assert "noise, kalman, showdown" in tab.view.scolded()[0]("en") and tab.picture.many is None


@pytest.mark.parametrize("command", [RunSeeds()])
def test_without_a_class_seeds_of_the_design_run_in_the_lab(command: Command) -> None:
    tab = Tab(LESSONS, "noise")
    tab.do(command)
    for _ in range(2000):
        tab.clock.advance(0.25)
        tab.session.step(0.0)
        if (many := tab.picture.many) is not None and many.fraction is None:
            break
    assert many is not None and many.found is not None and many.found.count == SEED_COUNT and not many.followers
