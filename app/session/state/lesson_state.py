"""Keep the state of one lesson of a tab while another lesson is open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ...course.design import Design
from ...course.pinned_designs import Pin
from .history import History
from .view import ExamState, State, TaskState


@dataclass
class LessonState:
    """The designs of a lesson, and what the person predicted, saw and solved in it."""

    history: History
    predicted: int | None = None
    revealed: bool = False
    again: int | None = None
    tasks: Mapping[str, TaskState] = field(default_factory=dict)
    exams: Mapping[str, ExamState] = field(default_factory=dict)
    pins: tuple[Pin, ...] = ()
    follows: bool = False  # whether the lesson's long computation is wanted wherever the knobs rest
    scene: int = 0  # of its path
    done: Mapping[str, Design] = field(default_factory=dict)
    chosen: Mapping[str, int] = field(default_factory=dict)
    sketches: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    text: str = ""  # as it was last written down, for a reload
    began: Design | None = None  # with which the scene that is open began
    entered: bool = False  # whether the design came with its scene, by a link, and is to stand as it came

    def keep(self, state: State) -> None:
        """Take over what the tab's state says of this lesson."""
        self.predicted, self.revealed, self.tasks, self.exams = state.predicted, state.revealed, state.tasks, state.exams
        self.pins, self.again = state.pins, state.again
        self.scene, self.done, self.chosen, self.sketches = state.scene, state.done, state.chosen, state.sketches

    def state_on_opening(self, state: State) -> State:
        """The tab's state with this lesson open, at the start of its run."""
        return replace(state, playing=False, loop=None, stopped=False, t=0.0, predicted=self.predicted,
                       revealed=self.revealed, again=self.again, asked=False, tasks=self.tasks, exams=self.exams, pins=self.pins,
                       scene=self.scene, done=self.done, chosen=self.chosen, sketches=self.sketches, performance=None, many=None)

    def take_back(self, old: LessonState) -> bool:
        """Take in what was kept of this lesson: its design one step of undo away, and what is not yet known here.

        False if it is the design that lies here already.
        """
        if self.predicted is None:
            self.predicted, self.revealed = old.predicted, old.revealed
        self.again = old.again if self.again is None else self.again
        self.tasks = {**old.tasks, **self.tasks}
        self.exams = {**old.exams, **self.exams}
        self.pins = self.pins or old.pins
        if not self.done and not self.chosen:
            self.scene, self.done, self.chosen, self.sketches = old.scene, old.done, old.chosen, old.sketches
        return self.history.insert_before_present(old.history.design)
