"""Computations that take long: progress, cancelling, failing, what they found."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from fakes import Tab, Worker, job_of, toy

from observer_lab.course.lesson import Job, Outcome
from observer_lab.engine import EngineError
from observer_lab.session.commands.commands import Command, OpenLesson, Predict, Reset, RunJob, SetLanguage, ToggleLecture, TurnPage, Undo
from observer_lab.session.runtime.outcomes import CACHED_DESIGNS, OutcomeCache
from observer_lab.text import same


def test_a_job_shows_its_progress_and_its_pictures_and_ends() -> None:
    work = Worker()
    work.tab.do(RunJob())
    tab = work.step(6)
    assert tab.view.of("progress") == [0.0, 0.25, 0.5, 0.75, 1.0, None]
    assert [p.outcome.study for p in tab.view.of("show")] == [1, 2, 3, 4]
    assert tab.picture.outcome.study == 4
    assert (work.started, work.ended) == (1, 1)
    tab.view.clear()
    tab.run_for(0.5)
    assert not [call for call in tab.view.calls if call[0] != "camera"]


def test_a_job_started_twice_is_cancelled_and_keeps_the_last_picture() -> None:
    work = Worker(100)
    work.tab.do(RunJob())
    tab = work.step(3)
    tab.do(RunJob())
    assert tab.view.of("progress")[-1] is None
    assert [bad for _, bad in tab.view.of("say")] == [False]
    assert work.ended == 1  # the generator is closed at once, not some day
    reached = work.done
    assert tab.picture.outcome.study == reached
    tab = work.step(5)
    assert work.done == reached


def test_a_changed_knob_drops_the_job_and_its_stale_results() -> None:
    work = Worker(100)
    work.tab.do(RunJob())
    work.step(2)
    work.tab.set(gain=3.0)
    work.step(5)
    assert work.ended == 1
    assert work.tab["gain"] == 3.0 and work.tab.picture.outcome.study is None
    assert work.tab.view.of("progress")[-1] is None
    assert not work.tab.view.sentences()


@pytest.mark.parametrize("command", [OpenLesson("other"), TurnPage(+1), Undo(), Reset()], ids=repr)
def test_whatever_changes_the_design_or_the_lesson_drops_the_job(command: Command) -> None:
    work = Worker(100)
    work.tab.set(gain=2.0)
    work.tab.do(RunJob())
    work.step(2)
    work.tab.do(command)
    reached = work.done
    work.step(5)
    assert work.ended == 1 and work.done == reached
    assert work.tab.view.of("progress")[-1] is None


def test_a_job_lets_other_edits_through() -> None:
    work = Worker(100)
    work.tab.do(RunJob())
    work.step(2)
    work.tab.do(ToggleLecture())
    work.tab.do(SetLanguage())
    state = work.tab.picture.state
    assert state.lecture and state.language == "zh"
    reached = work.done
    work.step(2)
    assert work.done > reached and work.ended == 0


def test_a_run_goes_on_playing_while_a_job_works() -> None:
    work = Worker(100)
    work.tab.do(Predict(1))
    work.tab.do(RunJob())
    work.tab.run_for(0.5)
    assert work.tab.view.of("pose")[-1] == pytest.approx(0.5, abs=0.04)
    assert work.done >= 10


@pytest.mark.parametrize("problem",
                         [EngineError("This map needs a stable loop."), ZeroDivisionError("division by zero")])
def test_a_job_that_fails_says_one_sentence_and_keeps_the_last_good_picture(problem: Exception) -> None:
    work = Worker(fail_at=3, problem=problem)
    work.tab.do(RunJob())
    tab = work.step(6)
    assert len(tab.view.scolded()) == 1
    assert tab.view.of("progress")[-1] is None
    assert tab.picture.outcome.study == 2
    tab.set(gain=3.0)
    assert tab["gain"] == 3.0


def test_a_job_that_fails_at_once_says_one_sentence() -> None:
    def broken(_: Outcome) -> Iterator[tuple[float, Outcome]]:
        raise EngineError("No.")
    tab = Tab({"toy": toy(job=job_of(broken))})
    tab.do(RunJob())
    tab.session.step(0.0)
    assert [s("en") for s in tab.view.scolded()] == ["No."]
    assert not tab.view.of("progress") or tab.view.of("progress")[-1] is None


def test_a_job_whose_result_cannot_be_drawn_does_not_end_the_session() -> None:
    work = Worker(study=lambda i: "undrawable" if i == 2 else i)
    work.tab.do(RunJob())
    tab = work.step(6)
    assert len(tab.view.scolded()) == 1
    assert tab.picture.outcome.study == 1
    assert tab.view.of("progress")[-1] is None
    tab.set(gain=3.0)
    assert tab["gain"] == 3.0


def test_what_a_job_found_is_there_again_after_undo_and_redo() -> None:
    work = Worker()
    work.tab.do(RunJob())
    tab = work.step(6)
    tab.set(gain=3.0)
    tab.do(Undo())
    assert tab.picture.outcome.study == 4
    assert work.started == 1


def test_what_a_job_found_is_shown_in_every_design_of_its_key_and_in_no_other() -> None:
    """The frame keeps results by lesson, plant and key; a design of another key shows nothing of them."""
    work = Worker()
    found = Job(same("long"), lambda outcome: ((share, after.study) for share, after in work.run(outcome)),
                key=lambda design: design["mode"], shown=lambda outcome, result: replace(outcome, study=result))
    work.tab = Tab({"toy": toy(job=found), "other": toy("other", job=replace(found))})
    work.tab.do(RunJob())
    tab = work.step(6)
    tab.set(gain=3.0)
    assert tab["gain"] == 3.0 and tab.picture.outcome.study == 4
    assert tab.picture.outcome.metrics["gain"] == 3.0
    tab.set(mode="b")
    assert tab.picture.outcome.study is None
    tab.do(OpenLesson("other"))
    assert tab.picture.outcome.study is None
    tab.do(OpenLesson("toy"))
    tab.set(mode="a", gain=5.0)
    assert tab.picture.outcome.study == 4
    assert work.started == 1


def test_results_of_jobs_are_kept_within_bounds() -> None:
    drafts, lesson = OutcomeCache(), toy(job=Job(same("long"), lambda outcome: iter(()), key=lambda design: design["gain"],
                                           shown=lambda outcome, result: replace(outcome, study=result)))
    designs = [lesson.apply(lesson.start(), {"gain": k / 100}) for k in range(CACHED_DESIGNS + 1)]
    for k, design in enumerate(designs):
        drafts.store_job_result(lesson, design, k)
    shown = [drafts.draw(lesson, design)[0].study for design in designs]
    assert shown == [None, *range(1, CACHED_DESIGNS + 1)]


def test_a_lesson_without_a_job_ignores_the_command() -> None:
    tab = Tab()
    tab.do(RunJob())
    assert not tab.view.calls


def test_a_cancel_that_comes_just_after_the_end_does_not_start_the_job_again() -> None:
    """A hand aims at the word "cancel" and the job ends before it presses."""
    work = Worker(steps=2)
    work.tab.do(RunJob())
    tab = work.step(4)
    assert tab.view.of("progress")[-1] is None
    tab.do(RunJob())
    assert work.started == 1
    tab.clock.advance(1.0)
    tab.do(RunJob())
    assert work.started == 2
