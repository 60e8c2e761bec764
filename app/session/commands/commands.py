"""Define the commands a person can send to a tab, one frozen record each.

A field of type `object` holds what a browser sent and is judged where the command is obeyed; nothing is trusted here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec

from ...text import Text


class Command(msgspec.Struct, frozen=True):
    """What a person asks of a tab."""


class Notice(Command, frozen=True):
    """What a browser, the room or a background job says by itself: nobody has asked for anything."""


class SetKnobs(msgspec.Struct, frozen=True):
    """New values for knobs, as they came in. Edits of one `grip` belong to one drag, and to one step of undo."""

    values: Mapping[str, object]
    grip: int | None = None


# --- the run -------------------------------------------------------------------------------------------------------
class Play(Command, frozen=True):
    """Play or pause; at the end of the run, play it again."""


class Rewind(Command, frozen=True):
    """Back to the start of the run."""


class Seek(Command, frozen=True):
    """To a time of the run, in seconds."""

    t: object


class ChangeSpeed(Command, frozen=True):
    """So many steps faster, or slower where `steps` is negative."""

    steps: int


class Kick(Command, frozen=True):
    """Strike the plant now."""


class PageSeen(Notice, frozen=True):
    """The page is seen by somebody who minds no motion (1), or is hidden (0)."""

    seen: object


# --- the design ----------------------------------------------------------------------------------------------------
class Undo(Command, frozen=True):
    """The design before."""


class Redo(Command, frozen=True):
    """The design that was undone."""


class Reset(Command, frozen=True):
    """Every knob at its default."""


class DrawByHand(Command, frozen=True):
    """A value of a knob that records a hand, from the present time of the run on."""

    knob: str
    value: object


class PickPoint(Command, frozen=True):
    """A click on the lesson's map."""

    x: object
    y: object


class UploadPlant(Command, frozen=True):
    """The plant in a file that the person chose."""

    name: object
    data: object


class ChoosePlant(Command, frozen=True):
    """A plant to show: "" for the lesson's own, `YOURS` for the one that was brought, or an example's name."""

    which: str


class Refuse(Command, frozen=True):
    """Something that must not be taken came from the browser: say why, and change nothing."""

    why: Text


# --- studying ------------------------------------------------------------------------------------------------------
class Predict(Command, frozen=True):
    """The index of the predicted option, −1 to skip."""

    index: object


class PredictAgain(Command, frozen=True):
    """The index of the option chosen in the lesson's second prediction, −1 to skip."""

    index: object


class ShowAgain(Command, frozen=True):
    """Set the knobs so that the run shows the answer to the second prediction."""


class Reveal(Command, frozen=True):
    """Show the answer to the prediction."""


class CheckTask(Command, frozen=True):
    """Judge a task by the present design and by what was typed under it."""

    task: str
    said: object = ""


class CheckNextTask(Command, frozen=True):
    """Judge the first task that is not yet solved."""


class ShowHint(Command, frozen=True):
    """One more hint for a task."""

    task: str


class ShowSolution(Command, frozen=True):
    """Set the knobs to a task's solution and say why it solves it."""

    task: str


class RunJob(Command, frozen=True):
    """Start the lesson's long computation, or cancel it."""


# --- the page ------------------------------------------------------------------------------------------------------
class OpenLesson(Command, frozen=True):
    """Open a lesson by its id."""

    lesson: object


class TurnPage(Command, frozen=True):
    """So many lessons on, or back where `steps` is negative."""

    steps: int


class SetLanguage(Command, frozen=True):
    """Speak a language; the other one if it is not known."""

    code: object = None


class ToggleLecture(Command, frozen=True):
    """Large print on or off."""


class ToggleTheme(Command, frozen=True):
    """Dark, or light again."""


class WindowChanged(Notice, frozen=True):
    """What a browser says of its window: px across and up, and whether its owner likes the dark."""

    across: object
    up: object
    night: object


class ToggleLandscape(Command, frozen=True):
    """The surface over the s-plane on or off."""


class ToggleNames(Command, frozen=True):
    """The names of the plant's parts on or off."""


class LookFrom(Command, frozen=True):
    """Look from a named place."""

    place: str


class ToggleHelp(Command, frozen=True):
    """Open or close the list of keys."""


class ToggleCourse(Command, frozen=True):
    """Open or close the page of all lessons."""


class Answer(Notice, frozen=True):
    """Say that all that was asked before this question has been done."""

    question: object


class RunOnTabThread(Notice, frozen=True):
    """What the view has to do since a browser has said something, on the thread of the tab: nobody has asked for it."""

    do: Callable[[], object]


class MemoryRecalled(Notice, frozen=True):
    """What the browser's tab kept before it was loaded again, None if nothing.

    `token` stands in the address bar, "" where none does; `known` says that this tab itself has put it there. `earlier` is what
    the browser's last tab kept, for a new one; `shelf` the designs that it keeps under names; `window` is what `WindowChanged` says;
    `lessons` is the tab's own .zip of lessons, as `write_zip` has written it.
    """

    text: str | None
    token: str = ""
    known: bool = False
    earlier: str | None = None
    shelf: str | None = None
    window: tuple[object, object, object] | None = None
    lessons: str | None = None


class OpenState(Command, frozen=True):
    """Open the state in a token, a link or the words of a file. `asked` counts what came from the address bar."""

    words: object
    asked: object = None


class PlaceOpened(Notice, frozen=True):
    """Which of the figures' tabs is open, by its number, and which step of thought; None where none is."""

    tab: object
    step: object


class ToggleDownloads(Command, frozen=True):
    """Open or close the dialog in which a state can be taken away."""


class SaveState(Command, frozen=True):
    """Hand the present state over as a file."""


Edit = SetKnobs | Command
