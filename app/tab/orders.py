"""What a person can ask of the tab besides the design itself: files to take away, designs kept beside it, steps back in time."""

from __future__ import annotations

from dataclasses import dataclass

from ..text import Text


@dataclass(frozen=True)
class TakeFile:
    """A file of what is shown: a figure by its id, or all for "", as "png", "svg", "pdf", "csv" or "json"; everything as "zip"; a
    "python", "notebook", "engine-notebook" or "matlab" script; the "replay" as a page; the "sheet" for print."""

    kind: str
    figure: str = ""


@dataclass(frozen=True)
class Made:
    """A file that was asked for is there, or it is known why it cannot be made."""

    name: str
    content: bytes
    why: Text | None = None


@dataclass(frozen=True)
class PinDesign:
    """Pin the present design, under a name of one's own or the next letter."""

    name: object = ""


@dataclass(frozen=True)
class Unpin:
    """Take the pin of that place away."""

    place: object


@dataclass(frozen=True)
class OpenPin:
    """Make the pinned design of that place the present one."""

    place: object


@dataclass(frozen=True)
class TurnGhost:
    """Let the ghost of the pin of that place walk on the stage, or no longer."""

    place: object


@dataclass(frozen=True)
class GoToStep:
    """The design of that place in the history."""

    place: object


@dataclass(frozen=True)
class KeepDesign:
    """Keep the present design in the browser's own storage, under a name of one's own."""

    name: object


@dataclass(frozen=True)
class OpenKept:
    """Open the design that is kept under a name."""

    name: object


@dataclass(frozen=True)
class ForgetDesign:
    """Keep the design of that name no longer."""

    name: object


@dataclass(frozen=True)
class ClearBrowser:
    """Let the browser forget all that it keeps."""


Taking = TakeFile | Made
Shelving = KeepDesign | OpenKept | ForgetDesign | ClearBrowser
Comparing = PinDesign | Unpin | OpenPin | TurnGhost | GoToStep
