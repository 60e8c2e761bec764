"""What a person can ask of the tab besides the design itself: files to take away, designs kept beside it, steps back in time."""

from __future__ import annotations

from dataclasses import dataclass

from ..text import Text


@dataclass(frozen=True)
class TakeFile:
    """A file of what is shown: a figure by its id, or all for "", as "png", "svg", "pdf", "csv" or "json"; everything as "zip"; a
    "python", "notebook" or "matlab" script; the "sheet" for print."""

    kind: str
    figure: str = ""


@dataclass(frozen=True)
class Made:
    """A file that was asked for is there, or it is known why it cannot be made."""

    name: str
    content: bytes
    why: Text | None = None


Taking = TakeFile | Made
