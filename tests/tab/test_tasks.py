"""Tasks: verdicts on the present design, hints, solutions, the next unsolved one."""

from __future__ import annotations

from fakes import Tab

from observer_lab.session.commands.commands import CheckNextTask, CheckTask, ShowHint, ShowSolution, Undo


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
