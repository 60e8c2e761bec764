"""Define the state of a tab: what belongs to it and not to the design that it shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...classroom.room import RoomView
from ...course.design import Design
from ...course.handin.learner import Learner
from ...course.handin.served_course import ServedCourse
from ...course.lectures import Lecture, Stop
from ...course.pinned_designs import Pin
from ...course.scenes import Mode, Scene
from .own_lessons import OwnLessons
from .record_file import RecordFile
from .saved_state import SavedDesign
from .tab_records import USUAL, ExamState, ManySeeds, Performance, ReplayLoop, TaskState


@dataclass(frozen=True)
class State:
    """What belongs to the tab and not to the design.

    `playing` is the whole run, `loop` a part of it under the hand; `stopped` says that the person has chosen the moment
    that stands, which then stays while the design changes; `calm`, that nobody sees the page or that nothing is to move by itself.
    """

    language: str = "en"
    lecture: bool = False
    dark: bool | None = None  # the theme; None follows the browser
    night: bool = False  # whether the browser likes the dark
    window: tuple[float, float] = USUAL  # px across and up
    playing: bool = False
    loop: ReplayLoop | None = None
    stopped: bool = False
    calm: bool = False
    t: float = 0.0
    speed: float = 1.0
    predicted: int | None = None  # index of the option; −1 when skipped
    revealed: bool = False
    left: str | None = None  # the `tab` that was open when it was chosen
    again: int | None = None  # of the second prediction, likewise
    asked: bool = False  # whether its knob has been moved since the first one
    tasks: Mapping[str, TaskState] = field(default_factory=dict)
    exams: Mapping[str, ExamState] = field(default_factory=dict)
    key: str = ""  # the student's; the same numbers are drawn for it everywhere
    word: str = field(default="", repr=False)  # that belongs to the key, as it was typed
    fresh: str = ""  # a random one for as long as there is none
    withheld: bool = False  # whether answers to exams are noted and nothing is told of them
    sealed: bool = False  # whether the server has settled that, so that no tab can practise
    course: ServedCourse | None = field(default=None, repr=False)  # the course that the server offers; it never leaves the server
    learner: Learner | None = field(default=None, repr=False)  # whom a learning platform has sent
    hand_ins: Mapping[str, str] = field(default_factory=dict)  # the last token of each item, by the item's name
    landscape: bool = False
    named: bool | None = None  # whether the plant's parts have their names beside them; None as the scene asks
    plant: str = ""  # the plant that the person brought last, shown now or not
    record_file: RecordFile | None = field(default=None, repr=False)  # a record that is looked at and not used yet
    tab: str | None = None  # the English name of the figures' tab that is open, None for the first
    step: int | None = None  # which step of thought is open
    shelf: tuple[SavedDesign, ...] = ()  # designs that the browser keeps under names
    pins: tuple[Pin, ...] = ()  # designs of this lesson that are compared
    camera: tuple[float, ...] | None = None  # position and target that a link asked for, None for the whole view
    can_undo: bool = False
    can_redo: bool = False
    mode: Mode = "lab"
    guided: bool = False  # whether the page leads along a path: not in the lab, nor on a plant of one's own, which has no path
    newcomer: bool = False  # whether nothing is known of the person: the page of lessons opens first
    scene: int = 0  # which scene of the lesson's path is open
    done: Mapping[str, Design] = field(default_factory=dict)  # scenes whose action the person has done, by id, with the design of its run
    chosen: Mapping[str, int] = field(default_factory=dict)  # the option chosen in a scene, by its id; −1 where it was skipped
    sketches: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # predictions that were drawn by hand, by scene
    performance: Performance | None = None  # what the page still does by itself
    talk: Lecture | None = None  # the lecture that is being given
    stop: int = 0  # which of its stops is open
    room: RoomView | None = None  # the class that follows, None in a tab that presents to nobody
    many: ManySeeds | None = None  # the errors of many seeds of one design
    recorded: tuple[Stop, ...] = ()  # stops that were noted for a lecture of one's own
    frozen: bool = False  # whether the presenter has paused the pages of the class
    goes_on: bool = False  # whether a run was playing then
    own: OwnLessons | None = field(default=None, repr=False)  # the lessons that the person brought, None where the server takes none

    @property
    def is_dark(self) -> bool:
        """Whether the page is dark now."""
        return self.night if self.dark is None else self.dark

    @property
    def student(self) -> str:
        """The key that numbers are drawn for."""
        return self.key or self.fresh

    def offers_solution(self, lesson: str, task: str) -> bool:
        """Whether the page may show a task's solution."""
        return not self.sealed if self.course is None else self.course.practised("task", lesson, task)

    def scene_of(self, path: Sequence[Scene]) -> Scene | None:
        """The scene of a path that is open, None in the lab."""
        return None if self.mode == "lab" or not path else path[min(self.scene, len(path) - 1)]

    @property
    def moving(self) -> bool:
        """Whether the clock goes."""
        return self.playing or self.loop is not None
