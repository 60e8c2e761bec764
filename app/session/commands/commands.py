"""Define the commands a person can send to a tab, one frozen record each.

A field of type `object` holds what a browser sent and is judged where the command is obeyed; nothing is trusted here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...text import Text
from .exams import Examining
from .files import Comparing, LessonsChanged, Shelving, Taking
from .guide import Guiding, ToggleGlossary
from .room import Lecturing, RunSeeds


@dataclass(frozen=True)
class SetKnobs:
    """New values for knobs, as they came in. Edits of one `grip` belong to one drag, and to one step of undo."""

    values: Mapping[str, object]
    grip: int | None = None


# --- the run -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Play:
    """Play or pause; at the end of the run, play it again."""


@dataclass(frozen=True)
class Rewind:
    """Back to the start of the run."""


@dataclass(frozen=True)
class Seek:
    """To a time of the run, in seconds."""

    t: object


@dataclass(frozen=True)
class ChangeSpeed:
    """So many steps faster, or slower where `steps` is negative."""

    steps: int


@dataclass(frozen=True)
class Kick:
    """Strike the plant now."""


@dataclass(frozen=True)
class PageSeen:
    """The page is seen by somebody who minds no motion (1), or is hidden (0)."""

    seen: object


# --- the design ----------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Undo:
    """The design before."""


@dataclass(frozen=True)
class Redo:
    """The design that was undone."""


@dataclass(frozen=True)
class Reset:
    """Every knob at its default."""


@dataclass(frozen=True)
class DrawByHand:
    """A value of a knob that records a hand, from the present time of the run on."""

    knob: str
    value: object


@dataclass(frozen=True)
class PickPoint:
    """A click on the lesson's map."""

    x: object
    y: object


@dataclass(frozen=True)
class UploadPlant:
    """The plant in a file that the person chose."""

    name: object
    data: object


@dataclass(frozen=True)
class ChoosePlant:
    """A plant to show: "" for the lesson's own, YOURS for the one that was brought, or an example's name."""

    which: str


@dataclass(frozen=True)
class Refuse:
    """Something that must not be taken came from the browser: say why, and change nothing."""

    why: Text


# --- studying ------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Predict:
    """The index of the predicted option, −1 to skip."""

    index: object


@dataclass(frozen=True)
class PredictAgain:
    """The index of the option chosen in the lesson's second prediction, −1 to skip."""

    index: object


@dataclass(frozen=True)
class ShowAgain:
    """Set the knobs so that the run shows the answer to the second prediction."""


@dataclass(frozen=True)
class Reveal:
    """Show the answer to the prediction."""


@dataclass(frozen=True)
class CheckTask:
    """Judge a task by the present design and by what was typed under it."""

    task: str
    said: object = ""


@dataclass(frozen=True)
class CheckNextTask:
    """Judge the first task that is not yet solved."""


@dataclass(frozen=True)
class ShowHint:
    """One more hint for a task."""

    task: str


@dataclass(frozen=True)
class ShowSolution:
    """Set the knobs to a task's solution and say why it solves it."""

    task: str


@dataclass(frozen=True)
class RunJob:
    """Start the lesson's long computation, or cancel it."""


# --- the page ------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class OpenLesson:
    """Open a lesson by its id."""

    lesson: object


@dataclass(frozen=True)
class TurnPage:
    """So many lessons on, or back where `steps` is negative."""

    steps: int


@dataclass(frozen=True)
class SetLanguage:
    """Speak a language; the other one if it is not known."""

    code: object = None


@dataclass(frozen=True)
class ToggleLecture:
    """Large print on or off."""


@dataclass(frozen=True)
class ToggleTheme:
    """Dark, or light again."""


@dataclass(frozen=True)
class WindowChanged:
    """What a browser says of its window: px across and up, and whether its owner likes the dark."""

    across: object
    up: object
    night: object


@dataclass(frozen=True)
class ToggleLandscape:
    """The surface over the s-plane on or off."""


@dataclass(frozen=True)
class LookFrom:
    """Look from a named place."""

    place: str


@dataclass(frozen=True)
class ToggleHelp:
    """Open or close the list of keys."""


@dataclass(frozen=True)
class ToggleCourse:
    """Open or close the page of all lessons."""


@dataclass(frozen=True)
class Answer:
    """Say that all that was asked before this question has been done."""

    question: object


@dataclass(frozen=True)
class RunOnTabThread:
    """What the view has to do since a browser has said something, on the thread of the tab: nobody has asked for it."""

    do: Callable[[], object]


@dataclass(frozen=True)
class MemoryRecalled:
    """What the browser's tab kept before it was loaded again, None if nothing.

    `token` stands in the address bar, "" where none does; `known` says that this tab itself has put it there. `earlier` is what
    the browser's last tab kept, for a new one; `shelf` the designs that it keeps under names; `window` is what `WindowChanged` says.
    """

    text: str | None
    token: str = ""
    known: bool = False
    earlier: str | None = None
    shelf: str | None = None
    window: tuple[object, object, object] | None = None


@dataclass(frozen=True)
class OpenState:
    """Open the state in a token, a link or the words of a file. `asked` counts what came from the address bar."""

    words: object
    asked: object = None


@dataclass(frozen=True)
class PlaceOpened:
    """Which of the figures' tabs is open, by its number, and which step of thought; None where none is."""

    tab: object
    step: object


@dataclass(frozen=True)
class ToggleDownloads:
    """Open or close the dialog in which a state can be taken away."""


@dataclass(frozen=True)
class SaveState:
    """Hand the present state over as a file."""


Playing = Play | Rewind | Seek | ChangeSpeed | Kick | PageSeen
Designing = Undo | Redo | Reset | DrawByHand | PickPoint | UploadPlant | ChoosePlant | Refuse
Studying = Predict | Reveal | PredictAgain | ShowAgain | CheckTask | CheckNextTask | ShowHint | ShowSolution | RunJob
Sharing = OpenState | PlaceOpened | ToggleDownloads | SaveState
Paging = (OpenLesson | TurnPage | SetLanguage | ToggleLecture | ToggleTheme | WindowChanged | ToggleLandscape | LookFrom | ToggleHelp
          | ToggleGlossary | ToggleCourse | Answer | RunOnTabThread | LessonsChanged | MemoryRecalled)
Command = Playing | Designing | Studying | Examining | Sharing | Taking | Comparing | Shelving | Paging | Guiding | Lecturing | RunSeeds
Edit = SetKnobs | Command
