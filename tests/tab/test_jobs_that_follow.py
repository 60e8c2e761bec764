"""Jobs that follow the knobs: begun once by hand, done again wherever the design rests, and silent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from fakes import Tab, Worker, toy

from observer_lab.course.lesson import Job, Outcome
from observer_lab.engine import EngineError
from observer_lab.session.commands.commands import RunJob
from observer_lab.text import same


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
