"""What a person can do in a tab: play, kick, undo, predict, check, pick, change lesson or language.

Every command of `app.edits.COMMANDS` and every button of the frame ends in one method `_do_<name>` here; how edits are
taken, computed and shown is in `app.tab`.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ..lesson.knobs import KnobError, Track
from ..lesson.lesson import Task, Verdict
from ..plants.examples import example
from ..plants.own import read
from ..text.words import Text
from .edits import SetKnobs
from .picture import TaskState
from .tab import FRAME, JUST_ENDED, REST, TabWorker

__all__ = ["FRAME", "PREDICT_FIRST", "REST", "SPEEDS", "YOURS", "Session"]

YOURS = "yours"
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
PREDICT_FIRST = Text("Choose a prediction first; then the run unlocks.", "请先作出预测，之后才能播放。")
NONSENSE = Text("The browser sent a value that this widget cannot take; nothing was changed.",
                "浏览器发来的数值不适用于这个控件，未作任何更改。")
TOO_LARGE = Text("The file is larger than 1 MB, or is not for this button; a plant with 30 states needs far less.",
                 "文件超过 1 MB，或不是交给这个按钮的；30 个状态的对象远用不了这么大。")
NOTHING_TO_UNDO = Text("Nothing to undo.", "没有可以撤销的操作。")
NOTHING_TO_REDO = Text("Nothing to redo.", "没有可以重做的操作。")


def _number(value: Any, finite: bool = True) -> float:
    """A number out of what a browser sent, a finite one unless told otherwise. Raises KnobError."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = None
    if number is None or (finite and not math.isfinite(number)):
        shown = str(value)[:40]
        raise KnobError(Text(f"{shown} is not a finite number; nothing was changed.", f"{shown} 不是有限的数，未作任何更改。"))
    return number


class Session(TabWorker):
    """One tab at work: `post` an edit, and the view shows what it leads to."""

    def _do_play(self, _: Any) -> None:
        if self._state.predicted is None:
            self._view.say(PREDICT_FIRST, False)
            return
        if self._picture is None or self._picture.horizon <= 0:
            return
        restart = not self._state.playing and self._state.t >= self._picture.horizon - 1e-9
        self._last_tick = self._clock()
        self._change(playing=not self._state.playing, t=0.0 if restart else self._state.t)
        self._view.pose(self._state.t)

    def _do_rewind(self, _: Any) -> None:
        self._do_seek(0.0)

    def _do_seek(self, t: Any) -> None:
        if self._state.predicted is None:
            self._view.say(PREDICT_FIRST, False)
            self._redraw()
            return
        assert self._picture is not None
        self._change(t=min(max(_number(t), 0.0), self._picture.horizon))
        self._view.pose(self._state.t)

    def _do_faster(self, _: Any) -> None:
        self._change(speed=SPEEDS[min(SPEEDS.index(self._state.speed) + 1, len(SPEEDS) - 1)])

    def _do_slower(self, _: Any) -> None:
        self._change(speed=SPEEDS[max(SPEEDS.index(self._state.speed) - 1, 0)])

    def _do_kick(self, _: Any) -> None:
        if not self._lesson.kick:
            return
        if self._state.predicted is None:
            self._view.say(PREDICT_FIRST, False)
            return
        assert self._picture is not None
        ended = self._state.t >= self._picture.horizon - 1e-9
        if ended:
            self._state = replace(self._state, t=0.0)
        self._last_tick = self._clock()
        self._adopt(self._lesson.apply(self._desk().history.design, {"kick": self._state.t}), None)
        self._change(playing=True)

    def _do_hand(self, argument: Any) -> None:
        """Record a hand-drawn input: (knob name, value) from the present time on."""
        name, value = argument
        knob = self._lesson.knob(name)
        if not isinstance(knob, Track):
            raise KnobError(Text(f"{name} is not drawn by hand.", f"{name} 不是手动输入。"))
        design = self._desk().history.design
        self._set([SetKnobs({name: knob.record(design[name], self._state.t, _number(value))})])

    def _do_refuse_value(self, _: Any) -> None:
        raise KnobError(NONSENSE)

    def _do_refuse_file(self, _: Any) -> None:
        raise KnobError(TOO_LARGE)

    def _do_undo(self, _: Any) -> None:
        self._walk(-1, NOTHING_TO_UNDO)

    def _do_redo(self, _: Any) -> None:
        self._walk(+1, NOTHING_TO_REDO)

    def _walk(self, step: int, nothing: Text) -> None:
        history = self._desk().history
        before = history.save()
        if not history.move(step):
            self._view.say(nothing, False)
            return
        self._draw_present(before)

    def _do_reset(self, _: Any) -> None:
        self._adopt(self._lesson.start(), None)
        self._change(playing=False, t=0.0)
        self._view.pose(0.0)

    def _do_upload(self, file: Any) -> None:
        """The plant in a file that the person chose: (name, bytes)."""
        name, data = file
        plant = read(str(name), bytes(data))
        self._wear(plant)
        self._change(plant=plant)

    def _do_plant(self, which: Any) -> None:
        """The plant to show: "" for the lesson's own, "yours" for the one that was brought, or an example's name."""
        self._wear("" if not which else self._state.plant if which == YOURS else example(str(which)))

    def _wear(self, plant: str) -> None:
        """Open the lesson at its start with a plant, as one step of undo."""
        lesson = self._lessons[self._lesson.id].fit(plant)
        self._adopt(lesson.start(), None)
        self._change(playing=False, t=0.0)
        self._view.pose(0.0)

    def _do_predict(self, index: Any) -> None:
        options = self._lesson.words[self._state.language].options
        choice = int(_number(index))
        if not -1 <= choice < len(options):
            raise KnobError(Text(f"There are {len(options)} predictions.", f"共有 {len(options)} 个预测选项。"))
        self._last_tick = self._clock()
        runs = self._picture is not None and self._picture.horizon > 0
        self._change(predicted=choice, revealed=self._state.revealed or not runs, playing=runs, t=0.0)

    def _do_reveal(self, _: Any) -> None:
        if self._state.predicted is None:
            self._view.say(PREDICT_FIRST, False)
            return
        self._change(revealed=True)

    def _do_lesson(self, lesson: Any) -> None:
        if lesson not in self._lessons:
            raise KnobError(Text(f"There is no lesson {str(lesson)[:40]}.", f"没有课程 {str(lesson)[:40]}。"))
        if self._job.running:
            self._cancel(silent=True)
        before = self._lesson
        self._lesson = self._lessons[lesson]
        try:
            self.open()
        except Exception:
            self._lesson = before
            self.open()
            raise

    def _do_next(self, _: Any) -> None:
        self._neighbour(+1)

    def _do_previous(self, _: Any) -> None:
        self._neighbour(-1)

    def _neighbour(self, step: int) -> None:
        ids = list(self._lessons)
        self._do_lesson(ids[(ids.index(self._lesson.id) + step) % len(ids)])

    def _do_language(self, language: Any) -> None:
        self._rebuild(language=language if language in ("en", "zh") else ("zh" if self._state.language == "en" else "en"))

    def _do_lecture(self, _: Any) -> None:
        self._rebuild(lecture=not self._state.lecture)

    def _rebuild(self, **changes: Any) -> None:
        """Lay the screen out anew: the language or the size of the print has changed."""
        self._state = replace(self._state, **changes)
        assert self._picture is not None
        self._picture = self._make(self._picture.design, self._picture.outcome, self._picture.figures)
        self._view.build(self._picture)
        self._view.show(self._picture)
        self._view.pose(self._state.t)
        self._remember()

    def _do_landscape(self, _: Any) -> None:
        self._change(landscape=not self._state.landscape)

    def _do_camera(self, preset: Any) -> None:
        self._view.camera(preset)

    def _do_help(self, _: Any) -> None:
        self._view.open_help()

    def _do_check(self, task_id: Any) -> None:
        assert self._picture is not None
        task = self._find_task(task_id)
        verdict = task.check(self._picture.outcome)
        self._task(task.id, verdict=verdict)
        self._view.say(verdict.text, not verdict.solved)

    def _do_check_next(self, _: Any) -> None:
        for task in self._lesson.tasks:
            verdict = self._state.tasks.get(task.id, TaskState()).verdict
            if verdict is None or not verdict.solved:
                self._do_check(task.id)
                return

    def _do_hint(self, task_id: Any) -> None:
        seen = self._state.tasks.get(self._find_task(task_id).id, TaskState()).hints
        self._task(task_id, hints=seen + 1)

    def _do_solution(self, task_id: Any) -> None:
        task = self._find_task(task_id)
        self._adopt(self._lesson.apply(self._desk().history.design, task.solution), None)
        self._task(task_id, solution=True)

    def _find_task(self, task_id: Any) -> Task:
        for task in self._lesson.tasks:
            if task.id == task_id:
                return task
        raise KnobError(Text(f"There is no task {str(task_id)[:40]}.", f"没有任务 {str(task_id)[:40]}。"))

    def _task(self, task_id: str, **changes: Any) -> None:
        tasks = dict(self._state.tasks)
        tasks[task_id] = replace(tasks.get(task_id, TaskState()), **changes)
        self._change(tasks=tasks)

    def _do_exam(self, answer: Any) -> None:
        item = self._lesson.exam(self._state.exam_seed)
        value = _number(answer, finite=False)
        right = abs(value - item.answer) <= item.tolerance  # false for NaN
        text = (Text("Right.", "正确。") if right else
                Text(f"{value:g} is not it; work it out again.", f"{value:g} 不对，请再推算一次。"))
        self._change(exam=Verdict(right, text))

    def _do_run_job(self, _: Any) -> None:
        if self._lesson.job is None or self._picture is None:
            return
        if self._job.running:
            self._cancel(silent=False)
            return
        if self._job.ended_within(JUST_ENDED):
            return
        self._job.start(self._lesson.job.run(self._picture.outcome))
        self._view.progress(0.0, self._lesson.job.label)

    def _do_pick(self, point: Any) -> None:
        if self._lesson.pick is None or self._picture is None:
            return
        x, y = (_number(v) for v in point)
        self._set([SetKnobs(self._lesson.pick(self._picture.outcome, x, y))])
        if self._state.predicted is not None:
            self._last_tick = self._clock()
            self._change(playing=True, t=0.0)
