"""A long fit of a person's record: its progress, its cancel button, and the last good picture where it fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from fakes import Clock, Tab
from test_own_records import file_of, heater

from observer_lab.course.knobs import KnobError
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import Notice
from observer_lab.session.commands.records import DropRecord, SetColumnRole, StopFit, UploadRecord, UseRecord
from observer_lab.session.handlers.tasks import CANCELLED
from observer_lab.session.runtime.background_jobs import BackgroundJobs
from observer_lab.session.state import record_file
from observer_lab.session.state.record_file import MOST_FIT_S, TOO_LONG, FitStopped, RecordFitting


class Held:
    """Background jobs that go on when they are told to."""

    def __init__(self, post: Callable[[Notice], object]) -> None:
        self.post, self.waiting = post, list[Callable[[], Notice]]()
        self.here = True

    def send(self, job: Callable[[], Notice]) -> bool:
        self.waiting.append(job)
        return True

    def tell(self, notice: Notice) -> bool:
        self.post(notice)
        return self.here

    def work(self) -> None:
        self.post(self.waiting.pop(0)())


class Bench:
    """A tab with a record that can be used, and a fit that does what a test says between its words."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.jobs: Held
        self.clock = Clock()
        self.between: Callable[[float], object] = lambda share: None

        def jobs(post: Callable[[Notice], object]) -> Held:
            self.jobs = Held(post)
            return self.jobs

        def fitting(told: Callable[[RecordFitting], bool]) -> RecordFitting:
            return RecordFitting(told, self.clock)

        def taken(lesson: Any, record: Any, progress: Callable[[float], object]) -> Any:
            def heard(share: float) -> None:
                self.clock.advance(1.0)
                progress(share)
                self.between(share)
            return real(lesson, record, progress=heard)
        monkeypatch.setattr("observer_lab.session.session.BackgroundJobs", jobs)
        monkeypatch.setattr("observer_lab.session.handlers.records.RecordFitting", fitting)
        real = LESSONS["record"].take_record
        assert real is not None
        self.tab = Tab({"record": replace(LESSONS["record"], take_record=taken), "kalman": LESSONS["kalman"]}, "record")
        self.tab.do(UploadRecord("heater.csv", heater("t;u;y;raum")))
        self.tab.do(SetColumnRole(3, ""))
        self.tab.view.clear()
        self.before = self.tab.picture.design

    def end(self) -> None:
        """Run the fit to its end, and give the tab its result."""
        self.jobs.work()
        self.tab.session.step(0.0)

    @property
    def stays(self) -> bool:
        """Whether the picture is still that of before, and no fit goes on."""
        return self.tab.picture.design == self.before and file_of(self.tab).fitting is None


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


def test_a_fit_tells_how_far_it_is_and_the_lesson_then_opens(bench: Bench) -> None:
    tab, shares, left = bench.tab, [], []

    def look(share: float) -> None:
        tab.session.step(0.0)
        fitting = file_of(tab).fitting
        assert fitting is not None and tab.picture.design == bench.before
        shares.append(fitting.share)
        left.append(fitting.seconds_left)
    bench.between = look
    tab.do(UseRecord())
    tab.do(UseRecord())  # a second press begins no second fit
    assert len(bench.jobs.waiting) == 1 and tab.picture.design == bench.before
    bench.end()
    assert tab["data"] == "own" and tab.picture.state.record_file is None and not tab.view.scolded()
    assert shares == sorted(shares) and shares[0] == 0 and shares[-1] == 1 and len(shares) > 10
    assert left[0] is None and left[-1] == 0
    rough = [seconds + k for k, seconds in enumerate(left) if seconds is not None]  # each word takes one second of the fake clock
    assert 0.3 * len(left) < min(rough) and max(rough) < 4 * len(left)


@pytest.mark.parametrize("end", [StopFit(), SetColumnRole(2, "y"), UploadRecord("heater.csv", heater("t;u;y;raum"))],
                         ids=["cancel", "role", "file"])
def test_a_fit_that_is_ended_leaves_the_last_picture(bench: Bench, end: Any) -> None:
    tab, words = bench.tab, []

    def stop(share: float) -> None:
        words.append(share)
        if len(words) == 3:
            tab.do(end)
    bench.between = stop
    tab.do(UseRecord())
    bench.end()
    assert bench.stays and len(words) == 3
    assert ("say", (CANCELLED, False)) in tab.view.calls if isinstance(end, StopFit) else not tab.view.scolded()
    bench.between = lambda share: None
    tab.do(UploadRecord("heater.csv", heater("t;u;y;raum")))
    tab.do(SetColumnRole(3, ""))
    tab.do(UseRecord())
    bench.end()
    assert tab["data"] == "own"


def test_a_file_that_is_left_out_ends_its_fit(bench: Bench) -> None:
    bench.tab.do(UseRecord())
    bench.tab.do(DropRecord())
    bench.end()
    assert bench.tab.picture.design == bench.before and bench.tab.picture.state.record_file is None


@pytest.mark.parametrize("problem", [EngineError("This record tells nothing."), RuntimeError("a mistake")], ids=["refused", "broken"])
def test_a_fit_that_fails_costs_one_sentence(bench: Bench, problem: Exception) -> None:
    def fail(share: float) -> None:
        if share > 0.9:
            raise problem
    bench.between = fail
    bench.tab.do(UseRecord())
    bench.end()
    if isinstance(problem, EngineError):  # the lesson opens and says itself that there is no filter of the suggested order
        assert bench.tab["data"] == "own" or len(bench.tab.view.scolded()) == 1
    else:
        assert bench.stays and len(bench.tab.view.scolded()) == 1


def test_a_fit_that_takes_too_long_is_ended_in_one_sentence(bench: Bench) -> None:
    bench.between = lambda share: bench.clock.advance(MOST_FIT_S)
    bench.tab.do(UseRecord())
    bench.end()
    assert bench.stays and [words("en") for words in bench.tab.view.scolded()] == [TOO_LONG("en")]


def test_a_fit_ends_where_its_tab_has_gone(bench: Bench) -> None:
    words: list[float] = []
    bench.between = words.append
    bench.jobs.here = False
    bench.tab.do(UseRecord())
    bench.end()
    assert len(words) <= 2


def test_a_job_of_a_tab_that_has_gone_hears_of_it() -> None:
    heard: list[Any] = []
    jobs = BackgroundJobs(heard.append)
    assert jobs.tell(StopFit()) and heard == [StopFit()]
    jobs.forget()
    assert not jobs.tell(StopFit()) and len(heard) == 1


def test_a_stopped_fit_raises_at_its_next_word() -> None:
    fitting = RecordFitting(lambda it: True)
    fitting.hear(0.5)
    fitting.stop()
    with pytest.raises(FitStopped):
        fitting.hear(0.6)
    assert fitting.share == 0.5 and not issubclass(FitStopped, KnobError | EngineError)
    assert record_file.SAID_EVERY_S < 1
