"""Handle the commands about predictions, tasks and the long computation."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

from ...course.exercises.typed_answers import MAX_TYPED_CHARACTERS
from ...course.knobs import KnobError
from ...course.lesson import Task, Verdict
from ...engine import EngineError
from ...text import text
from ..state.validate import check_number
from ..state.view import TaskState
from .playback import warn_if_locked
from .presenter import Presenter

log = logging.getLogger(__name__)

JUST_ENDED = 0.7  # s after a long job in which its button means "cancel" to a hand that was about to press it
NO_SOLUTIONS = text("This server shows no solutions to tasks; practise on one that was started without --exam.")
COURSE_NO_SOLUTION = text("The course shows no solution to this task.")
CANCELLED = text("Computation cancelled; the last picture stays.")


def _one_of(index: object, options: tuple[str, ...]) -> int:
    """The choice, −1 to skip. Raises KnobError."""
    choice = int(check_number(index))
    if not -1 <= choice < len(options):
        raise KnobError(text("There are {count} predictions.", count=len(options)))
    return choice


def reveal(show: Presenter) -> None:
    """Show the answer to the prediction."""
    if not warn_if_locked(show):
        show.change(replace(show.state, revealed=True, left=show.state.tab))


def predict(show: Presenter, index: object) -> None:
    """Note the predicted option and play the run. Raises KnobError."""
    choice = _one_of(index, show.lesson.words[show.state.language].options)
    runs = show.picture.horizon > 0
    show.change(replace(show.state, predicted=choice, revealed=show.state.revealed or not runs, left=show.state.tab,
                        playing=runs, loop=None, stopped=False, t=0.0))


def predict_again(show: Presenter, index: object) -> None:
    """Note the option chosen in the second prediction. Raises KnobError."""
    asked = show.lesson.words[show.state.language].again
    if not warn_if_locked(show):
        runs = show.picture.horizon > 0 and not show.state.calm
        show.change(replace(show.state, again=_one_of(index, () if asked is None else asked.options), playing=runs, loop=None,
                            stopped=False, t=0.0))


def show_again(show: Presenter) -> None:
    """Set the knobs so that the run shows the answer to the second prediction."""
    again = show.lesson.again
    if again is not None and show.state.again is not None:
        show.adopt_design(show.lesson.apply(show.lesson.start(), again.trial))
        show.view.open_figure(again.figures[0])


# --- tasks ---------------------------------------------------------------------------------------------------------
def _find(show: Presenter, task_id: object) -> Task:
    for task in show.lesson.tasks:
        if task.id == task_id:
            return task
    raise KnobError(text("There is no task {task_id}.", task_id=str(task_id)[:40]))


def _seen(show: Presenter, task: Task) -> TaskState:
    return show.state.tasks.get(task.id, TaskState())


def _see(show: Presenter, task: Task, seen: TaskState) -> None:
    show.change(replace(show.state, tasks={**show.state.tasks, task.id: seen}))


def check_task(show: Presenter, task: object, said: object) -> Verdict:
    """Judge a task by the present design and by what was typed, and show the verdict. Raises KnobError where there is no such task."""
    found = _find(show, task)
    words = said[:MAX_TYPED_CHARACTERS] if isinstance(said, str) else ""
    verdict = found.judge(show.picture.outcome, words)
    _see(show, found, replace(_seen(show, found), verdict=verdict, typed=words, judged=show.picture.design))
    show.view.say(verdict.text, not verdict.solved)
    return verdict


def check_next_task(show: Presenter) -> None:
    """Judge the first task that is not yet solved."""
    for task in show.lesson.tasks:
        seen = _seen(show, task)
        if seen.verdict is None or not seen.verdict.solved:
            check_task(show, task.id, seen.typed)
            return


def show_hint(show: Presenter, task: str) -> None:
    """Show one more hint for a task. Raises KnobError."""
    found = _find(show, task)
    seen = _seen(show, found)
    _see(show, found, replace(seen, hints=seen.hints + 1))


def show_solution(show: Presenter, task: str) -> None:
    """Set the knobs to a task's solution. Raises KnobError where no solutions are shown."""
    if not show.state.offers_solution(show.lesson.id, task):
        raise KnobError(NO_SOLUTIONS if show.state.course is None else COURSE_NO_SOLUTION)
    found = _find(show, task)
    show.adopt_design(show.lesson.apply(show.design, found.solution))
    _see(show, found, replace(_seen(show, found), solution=True))


# --- the long computation ------------------------------------------------------------------------------------------
def start_or_cancel_job(show: Presenter) -> None:
    """Start the lesson's long computation, or cancel it."""
    job = show.lesson.job
    if job is None:
        return
    if show.job.running and show.job.quiet:  # it was not known that it goes on already
        show.job.quiet = False
        show.view.progress(0.0, job.label)
    elif show.job.running:
        show.lesson_state.follows = False
        show.cancel_job()
        show.view.say(CANCELLED, False)
    elif not show.job.ended_within(JUST_ENDED):
        show.lesson_state.follows = job.follows
        show.job.start(job.run(show.picture.outcome))
        show.view.progress(0.0, job.label)


def follow(show: Presenter) -> None:
    """Start the long computation without a word where the knobs have come to rest, if it is wanted there and not done yet."""
    job = show.lesson.job
    if job is not None and job.follows and show.lesson_state.follows and not show.job.running and not show.job_ended:
        show.job.start(job.run(show.picture.outcome), quiet=True)


def go_on(show: Presenter, undisturbed: Callable[[], bool]) -> None:
    """Go on with the long job for a slice of time; a job that fails ends, and the last good picture stays.

    A quiet one shows what it found when it is through, and before that now and then where nothing rough is shown; it has nothing to
    say where this design gives it nothing to do.
    """
    job, quiet = show.lesson.job, show.job.quiet
    if not show.job.running or job is None:
        return
    try:
        fraction, found = show.job.go_on(undisturbed)
        if quiet:
            through = not show.job.running
            found = show.job.found if through or (job.rough is None and show.job.tells()) else None
        if found is not None:
            show.keep(found)
    except BaseException as problem:
        expected = quiet and isinstance(problem, (KnobError, EngineError))
        if not expected:
            log.exception("the job of lesson %s failed", show.lesson.id)
        show.cancel_job()
        if not expected:
            show.report_refusal(problem)
        return
    if not show.job.running:
        show.mark_job_ended()
    if not quiet:
        show.view.progress(fraction if show.job.running else None, job.label)
        if not show.job.running:
            show.view.open_figure(job.figure)
