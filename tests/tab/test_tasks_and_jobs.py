"""Tasks, and computations that take long: progress, cancelling, failing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest
from fakes import Tab, job_of, toy

from app.engine import EngineError
from app.lesson.lesson import Job, Outcome
from app.tab.commands import (
    CheckNextTask,
    CheckTask,
    Command,
    LookFrom,
    OpenLesson,
    Predict,
    Reset,
    RunJob,
    SetLanguage,
    ShowHint,
    ShowSolution,
    ToggleLecture,
    TurnPage,
    Undo,
)
from app.tab.drafts import KEPT, Drafts
from app.text import same


# --- tasks ---------------------------------------------------------------------------------------------------------
def test_a_check_gives_a_verdict_on_the_present_design() -> None:
    tab = Tab()
    tab.do(CheckTask("high"))
    assert not tab.picture.state.tasks["high"].verdict.solved
    assert [bad for _, bad in tab.view.of("say")] == [True]
    tab.set(gain=6.0)
    tab.do(CheckTask("high"))
    assert tab.shown.state.tasks["high"].verdict.solved
    assert [bad for _, bad in tab.view.of("say")] == [True, False]
    assert "low" not in tab.picture.state.tasks


def test_hints_come_one_by_one() -> None:
    tab = Tab()
    seen = []
    for _ in range(2):
        tab.do(ShowHint("high"))
        seen.append(tab.shown.state.tasks["high"].hints)
    assert seen == [1, 2]


def test_a_solution_sets_the_knobs_passes_and_can_be_undone() -> None:
    tab = Tab()
    tab.set(offset=0.5)
    tab.do(ShowSolution("high"))
    assert tab["gain"] == 5.0 and tab["offset"] == 0.5
    assert tab.shown.state.tasks["high"].solution
    tab.do(CheckTask("high"))
    assert tab.picture.state.tasks["high"].verdict.solved
    tab.do(Undo())
    assert (tab["gain"], tab["offset"]) == (1.0, 0.5)
    assert tab.picture.state.tasks["high"].solution  # what was seen stays seen


def test_the_next_unsolved_task_is_checked_in_order() -> None:
    tab = Tab()
    tab.do(ShowSolution("high"))
    for _ in range(3):
        tab.do(CheckNextTask())
    tasks = tab.picture.state.tasks
    assert tasks["high"].verdict.solved and not tasks["low"].verdict.solved
    tab.do(ShowSolution("low"))
    tab.do(CheckNextTask())
    assert tab.picture.state.tasks["low"].verdict.solved
    count = len(tab.view.sentences())
    tab.do(CheckNextTask())
    assert len(tab.view.sentences()) == count


# --- jobs ----------------------------------------------------------------------------------------------------------
class Worker:
    """A job of `steps` steps; a command put into the mailbox after each makes the session look up once a step."""

    def __init__(self, steps: int = 4, fail_at: int | None = None, problem: Exception | None = None,
                 study: Callable[[int], object] = lambda i: i) -> None:
        self.steps, self.fail_at, self.problem, self.study = steps, fail_at, problem, study
        self.started = self.ended = self.done = 0
        self.tab = Tab({"toy": toy(job=job_of(self.run)), "other": toy("other")})

    def run(self, outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
        self.started += 1
        try:
            for i in range(1, self.steps + 1):
                if i == self.fail_at and self.problem is not None:
                    raise self.problem
                self.done = i
                self.tab.session.post(LookFrom("all"))
                yield i / self.steps, replace(outcome, study=self.study(i))
        finally:
            self.ended += 1

    def step(self, count: int = 1) -> Tab:
        for _ in range(count):
            self.tab.session.step(0.0)
        return self.tab


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
    drafts, lesson = Drafts(), toy(job=Job(same("long"), lambda outcome: iter(()), key=lambda design: design["gain"],
                                           shown=lambda outcome, result: replace(outcome, study=result)))
    designs = [lesson.apply(lesson.start(), {"gain": k / 100}) for k in range(KEPT + 1)]
    for k, design in enumerate(designs):
        drafts.keep_found(lesson, design, k)
    shown = [drafts.draw(lesson, design)[0].study for design in designs]
    assert shown == [None, *range(1, KEPT + 1)]


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


# --- jobs that follow ------------------------------------------------------------------------------------------------
def following(work: Worker, rough: Callable[[Outcome], object] | None = None) -> Tab:
    """The worker's tab with a job that follows."""
    job = Job(same("long"), lambda outcome: ((share, after.study) for share, after in work.run(outcome)),
              key=lambda design: design["gain"], shown=lambda outcome, result: replace(outcome, study=result), follows=True, rough=rough)
    work.tab = Tab({"toy": toy(job=job)})
    return work.tab


def test_a_job_that_follows_waits_until_somebody_wants_it() -> None:
    work = Worker()
    tab = following(work)
    tab.set(gain=2.0)
    tab.rest()
    work.step(3)
    assert work.started == 0


def test_a_job_that_follows_shows_what_it_finds_wherever_the_knobs_rest_and_says_nothing() -> None:
    work = Worker()
    tab = following(work, rough=lambda outcome: "rough")
    tab.do(RunJob())
    work.step(6)
    tab.view.clear()
    tab.set(gain=2.0)
    assert tab.picture.outcome.study == "rough" and work.started == 1
    tab.rest()
    work.step(6)
    assert tab.picture.outcome.study == 4 and work.started == 2
    assert set(tab.view.of("progress")) <= {None} and not tab.view.of("open_figure") and not tab.view.sentences()
    tab.set(gain=2.5)
    tab.set(gain=2.0)  # found already
    assert tab.picture.outcome.study == 4
    tab.rest()
    work.step(3)
    assert work.started == 2


def test_a_job_that_follows_and_was_broken_off_in_its_middle_goes_on_when_its_design_comes_back() -> None:
    work = Worker()
    tab = following(work)
    tab.do(RunJob())
    work.step(2)
    tab.set(gain=2.0)
    tab.set(gain=1.0)
    assert tab.picture.outcome.study == work.done < work.steps
    tab.rest()
    work.step(6)
    assert tab.picture.outcome.study == 4


def test_a_long_job_that_follows_shows_what_it_has_now_and_then_unless_something_rough_stands_there() -> None:
    for rough in (None, lambda outcome: "rough"):
        work = Worker(9)
        tab = following(work, rough)
        tab.do(RunJob())
        work.step(12)
        tab.set(gain=2.0)
        tab.rest()
        work.step(1)
        assert tab.picture.outcome.study == (None if rough is None else "rough")
        tab.clock.advance(0.5)
        work.step(1)
        assert tab.picture.outcome.study == (work.done if rough is None else "rough") and 1 < work.done < 9


def test_to_cancel_a_job_is_to_want_it_no_longer() -> None:
    work = Worker(100)
    tab = following(work, rough=lambda outcome: "rough")
    tab.do(RunJob())
    work.step(2)
    tab.do(RunJob())
    tab.set(gain=2.0)
    tab.rest()
    work.step(3)
    assert work.started == 1 and tab.picture.outcome.study is None


def test_a_press_while_a_job_follows_shows_how_far_it_is_and_does_not_cancel_it() -> None:
    work = Worker(6)
    tab = following(work)
    tab.do(RunJob())
    work.step(8)
    tab.set(gain=2.0)
    tab.rest()
    work.step(2)
    tab.view.clear()
    tab.do(RunJob())
    work.step(6)
    assert tab.view.of("progress")[0] == 0.0 and tab.view.of("progress")[-1] is None and tab.picture.outcome.study == 6


@pytest.mark.parametrize(("problem", "told"), [(EngineError("No start comes home."), 0), (ZeroDivisionError("division by zero"), 1)])
def test_a_job_that_follows_into_a_design_it_cannot_do_says_nothing_and_tells_of_every_other_fault(problem: Exception, told: int) -> None:
    work = Worker()
    tab = following(work)
    tab.do(RunJob())
    work.step(6)
    work.fail_at, work.problem = 1, problem
    tab.set(gain=2.0)
    tab.rest()
    work.step(3)
    assert len(tab.view.scolded()) == told and tab["gain"] == 2.0 and not tab.session._show.job.running
