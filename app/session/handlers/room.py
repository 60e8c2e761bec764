"""Ask the class a question, and show how it has voted."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ...classroom.room import RoomView, VoteDesk
from ...course.knobs import KnobError
from ...course.scenes import Choose
from ...text import text
from ..commands.room import CloseVote, Lecturing, LowerHands, OpenVote, RoomChanged
from . import guide
from .presenter import Presenter


def obey(show: Presenter, desk: VoteDesk | None, command: Lecturing) -> None:
    """Do what a presenter asks of the room. Raises KnobError in a tab that does not present."""
    if desk is None:
        raise KnobError(text("Only the presenter's tab can ask the class; open the presenter's link."))
    match command:
        case OpenVote():
            _open(show, desk)
        case CloseVote():
            _show_room(show, desk.close_vote())
            guide.perform_answer(show)
        case LowerHands():
            _show_room(show, desk.lower_hands())
        case RoomChanged(view):
            _show_room(show, view)
        case _:
            assert_never(command)


def _open(show: Presenter, desk: VoteDesk) -> None:
    scene = show.picture.scene
    if scene is None or not isinstance(scene.do, Choose):
        raise KnobError(text("This scene asks no question; turn to one that does."))
    options, _, _ = guide.options_of(show.lesson, scene, show.state.language)
    _show_room(show, desk.open_vote(show.lesson.id, scene.id, len(options)))


def _show_room(show: Presenter, view: RoomView) -> None:
    show.state = replace(show.state, room=view)
    show.redraw()
