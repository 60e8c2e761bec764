"""Define the picture that a tab shows and the View protocol of a screen."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

from ...classroom.votes import Vote, votes_on, votes_on_typed
from ...course.course_map import Progress
from ...course.error_window import run_end
from ...course.figures.records import Figure, TableFigure
from ...course.figures.veil import boards_with_beginning, boards_with_question
from ...course.guiding.questions import DrawnQuestion
from ...course.lazy import FigureSet
from ...course.lectures import words_in
from ...course.lesson import Board, Design, Lesson, Outcome, Stage
from ...course.pinned_designs import Ghost, Pinned, boards_with_pins, comparison_table, figures_with_pins, ghosts_of_pins
from ...course.scenes import Scene, SceneWords
from ...text import Text
from .saved_state import SavedState
from .tab_records import MOST_ANSWERS as MOST_ANSWERS
from .tab_records import MOST_VARIANTS as MOST_VARIANTS
from .tab_records import USUAL as USUAL
from .tab_records import ExamAnswer as ExamAnswer
from .tab_records import ExamState as ExamState
from .tab_records import ManySeeds as ManySeeds
from .tab_records import Performance as Performance
from .tab_records import ReplayLoop as ReplayLoop
from .tab_records import TaskState as TaskState
from .tab_records import progress_of as progress_of
from .tab_state import State as State


@dataclass(frozen=True, eq=False)
class Picture:
    """All that a view shows: `resting` is False while a knob moves, `answered` the number of the last edit that went in,
    `steps` the designs that undo and redo walk along, `at` where they stand.

    `figures` and the outcome's boards are the lesson's own; `seen` and `boards` have the pinned designs laid in. One that is not
    `whole` shows what is looked at, the open tab's figures, boards and stage, while a knob moves; the rest follows. `kept` is the
    outcome of the run with which the open scene was done, None where it is not done; `began` the design with which the scene began;
    `question` is the figure of its question, `asked` the outcome of the design with which that is asked, None where it is this one.
    """

    lesson: Lesson
    design: Design
    outcome: Outcome
    figures: Sequence[Figure]
    state: State
    resting: bool
    catalogue: tuple[Lesson, ...] = ()
    answered: int = 0
    pinned: tuple[Pinned, ...] = ()
    steps: tuple[Design, ...] = ()
    at: int = 0
    whole: bool = True
    kept: Outcome | None = None
    began: Design | None = None
    question: DrawnQuestion | None = None
    asked: Outcome | None = None

    @cached_property
    def seen(self) -> Sequence[Figure]:
        """The figures as they are shown, with the curves of the pins."""
        figures = self.figures
        if not self.whole and isinstance(figures, FigureSet):
            figures = figures.front(self.state.tab)
        return figures_with_pins(figures, self.pinned) if self.pinned else figures

    @cached_property
    def boards(self) -> tuple[Board, ...]:
        """The boards as they are shown, with the poles of the pins and those that the class has placed."""
        boards = boards_with_pins(self.outcome.boards, self.pinned) if self.pinned else self.outcome.boards
        boards = boards_with_beginning(boards, self.scene, self.began, self.design)
        asked, cloud = (self.typed[-1].asked, self.typed[-1].cloud) if self.typed else (None, ())
        grid = None if asked is None else asked.grid
        return boards if grid is None or not cloud else tuple(
            replace(board, placed=cloud) if board.id == grid.board else board for board in boards)

    @cached_property
    def asks_second_prediction(self) -> bool:
        """Whether the second prediction waits: its knob has been moved, and no option has been chosen yet nor the question skipped."""
        again, state = self.lesson.again, self.state
        return (not self.guided and again is not None and state.predicted is not None and state.again is None and state.asked
                and again.touched(self.lesson.start(), self.design))

    @property
    def guided(self) -> bool:
        """Whether the page leads along the lesson's path."""
        return self.state.guided

    @property
    def scene(self) -> Scene | None:
        """The scene that is open, None in the lab."""
        return self.state.scene_of(self.lesson.path)

    @property
    def named(self) -> bool:
        """Whether the plant's parts have their names: in the first scene of a path until its action is done, or as the person chose."""
        state, path = self.state, self.lesson.path
        return state.named if state.named is not None else self.scene is not None and self.scene is path[0] and path[0].id not in state.done

    @property
    def scene_words(self) -> SceneWords:
        """The words of that scene."""
        assert self.scene is not None
        return self.lesson.words[self.state.language].scenes[self.scene.id]

    @property
    def place(self) -> tuple[int, int]:
        """Which stop is open, from 0, and how many there are: those of the lecture, else the scenes of the path."""
        talk = self.state.talk
        return (self.state.stop, len(talk.stops)) if talk is not None else (self.state.scene, len(self.lesson.path))

    @property
    def note(self) -> str:
        """The speaker's note: of the lecture's stop where it has one, else of the scene."""
        talk, language = self.state.talk, self.state.language
        own = words_in(talk.stops[self.state.stop].note, language) if talk is not None else ""
        return own or self.scene_words.note

    @property
    def next_title(self) -> str:
        """The title of what comes next, "" at the end."""
        (at, count), talk = self.place, self.state.talk
        if at + 1 >= count:
            return ""
        lesson, scene = self.lesson, self.lesson.path[at + 1].id if talk is None else ""
        if talk is not None:
            stop = talk.stops[at + 1]
            lesson, scene = next(each for each in self.catalogue if each.id == stop.lesson), stop.scene
        return lesson.words[self.state.language].scenes[scene].title

    @property
    def votes(self) -> tuple[Vote, ...]:
        """How the class has voted on the question of that scene, now and the time before."""
        room = self.state.room
        return () if room is None or self.scene is None else votes_on(room.votes, self.lesson.id, self.scene.id)

    @property
    def typed(self) -> tuple[Vote, ...]:
        """How the class has answered what the presenter typed in that scene, now and the time before."""
        room, scene = self.state.room, self.scene.id if self.scene else ""
        return () if room is None else votes_on_typed(room.votes, self.lesson.id, scene)

    @property
    def many(self) -> ManySeeds | None:
        """The errors of many seeds of this design, None where none were run."""
        many = self.state.many
        return many if many is not None and many.design == self.design else None

    @property
    def undecided(self) -> bool:
        """Whether the class is asked the question of that scene and its answer is not told yet."""
        asked = [vote for vote in (*self.votes, *self.typed) if vote.asked is None or vote.kind == "sketch"]
        return bool(asked) and not max(asked, key=lambda vote: vote.number).revealed

    @property
    def voting(self) -> bool:
        """Whether a vote on that question is open, so that nothing shows its answer."""
        return bool(self.votes) and self.votes[-1].open

    @property
    def veiled(self) -> bool:
        """Whether the figures wait for a prediction; the path shows nothing that would answer a question that it has not asked."""
        return self.state.predicted is None and not self.guided and bool(self.lesson.words[self.state.language].options)

    def covers(self, board: Board) -> bool:
        """Whether a board's poles are veiled with the figures: not where the path shows them with its question."""
        return self.veiled and board.id not in boards_with_question(self.lesson.path)

    def saved(self, design: Design, eye: tuple[float, ...] | None) -> SavedState:
        """The state as a link carries it, with a design and a camera."""
        state, scene = self.state, self.scene
        shown = SavedState(design, state.language, state.lecture, state.tab, state.step, eye, state.withheld)
        if scene is None:
            return shown
        answered = state.chosen.get(scene.id, -1) if scene.answers and state.done.get(scene.id) == design else None
        return replace(shown, mode=state.mode, scene=scene.id, answered=answered)

    @cached_property
    def ghosts(self) -> tuple[Ghost, ...]:
        """The ghosts of those pins that are wanted on the stage."""
        return ghosts_of_pins(self.outcome.stage, self.pinned)

    @cached_property
    def compared(self) -> TableFigure | None:
        """The present design beside the pins; None without any."""
        return comparison_table(self.lesson, self.design, self.outcome, self.pinned)

    @property
    def horizon(self) -> float:
        """Length of the run in seconds, 0 without one."""
        return float(self.outcome.stage.t[-1]) if self.outcome.stage is not None else 0.0

    @property
    def end(self) -> float:
        """When the run is over, in its seconds: its length, or earlier where everything has come to stand."""
        return run_end(self.outcome.stage) if self.outcome.stage is not None else 0.0

    @property
    def rate(self) -> float:
        """Seconds of the run in a second of playing: the speed chosen, and for a run far from human times a power of
        ten; a loop has its own."""
        loop = self.state.loop
        return self.state.speed * (time_scale(self.horizon) if loop is None else loop.part.rate)


def time_scale(horizon: float) -> float:
    """1 for a run of 2 to 60 s, else the power of ten that makes it one."""
    if 2.0 <= horizon <= 60.0 or horizon <= 0:
        return 1.0
    return 10.0 ** (math.floor(math.log10(horizon)) - (0 if horizon < 2.0 else 1))


class View(Protocol):
    """What a session needs of a screen."""

    def build(self, picture: Picture) -> None:
        """Lay the screen out for a lesson or a language."""

    def show(self, picture: Picture) -> None:
        """Show a picture; only what changed since the last one is sent."""

    def pose(self, t: float) -> None:
        """Move the stage and the cursors to time t of the last picture."""

    def follow(self, stage: Stage) -> None:
        """Move the body of the last picture to the end of another run, and nothing else; a browser that is behind is left alone."""

    def play(self, t: float, end: float, rate: float, every: float) -> float:
        """Show the last picture in motion from t to `end`, `rate` seconds of the run in one; a pose `every` so many seconds.

        The seconds for which the view goes on by itself: `every` where it has shown one pose.
        """
        ...

    def progress(self, fraction: float | None, label: Text | None) -> None:
        """Show how far a long job is; None when there is none."""

    def say(self, words: Text, bad: bool) -> None:
        """Tell the person one sentence."""

    def camera(self, preset: str) -> None:
        """Look from a named place."""

    def open_figure(self, figure: str) -> None:
        """Bring the figure of that id to the front, if the lesson has it."""

    def open_glossary(self) -> None:
        """Open the page of all terms, or close it."""
        ...

    def open_help(self) -> None:
        """Show or close the list of keyboard commands."""

    def open_course(self, progress: Mapping[str, Progress]) -> None:
        """Show or close the page of all lessons, with how far the person is in each."""

    def answer(self, question: float) -> None:
        """Say that all that was done before a question is shown."""

    def look(self, camera: tuple[float, ...] | None) -> None:
        """Look from a position at a target, from where everything is seen for None."""

    def eye(self) -> tuple[float, ...] | None:
        """Position and target of the camera, None where it stands as it was put."""

    def address(self, token: str, lesson: str, asked: int) -> None:
        """Put a state into the address bar; `asked` is the number of the last one that was opened from there."""

    def offer(self, token: str) -> None:
        """Open the dialog in which the state of that token can be taken away, or close it."""

    def download(self, name: str, content: bytes) -> None:
        """Give the person a file."""

    def replay(self, picture: Picture, token: str, camera: tuple[float, ...] | None) -> bytes:
        """The run of a picture as a page that plays by itself, seen from there; on any thread, it touches no screen. Raises FileError."""
        ...

    def recall(self, answer: Callable[..., object]) -> None:
        """Ask for what a `MemoryRecalled` holds; the answer may come late, or never."""

    def remember(self, text: str) -> None:
        """Keep a text in the browser's tab, and for the tabs after it."""

    def save_design(self, name: str, words: str) -> None:
        """Keep words in the browser under a name, or nothing any more for ""."""

    def keep_lessons(self, words: str) -> None:
        """Keep the person's .zip of lessons in the browser's tab alone, or none any more for ""."""

    def clear_storage(self) -> None:
        """Let the browser forget all that it keeps."""
