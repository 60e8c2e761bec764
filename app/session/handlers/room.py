"""Ask the class a question, and show how it has voted."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ...classroom.room import RoomView, VoteDesk
from ...classroom.votes import MAX_OPTIONS, Asked, read_question
from ...course.knobs import KnobError
from ...course.scenes import Choose
from ...text import text
from ..commands.room import AskTyped, AskTypedAgain, CloseVote, Lecturing, LowerHands, OpenVote, RoomChanged
from . import guide
from .presenter import Presenter

NO_QUESTION = text("Type a question on the first line and two to {most} short options on the lines below. "
                   "Without options the class answers with a number.", most=MAX_OPTIONS)


def obey(show: Presenter, desk: VoteDesk | None, command: Lecturing) -> None:
    """Do what a presenter asks of the room. Raises KnobError in a tab that does not present."""
    if desk is None:
        raise KnobError(text("Only the presenter's tab can ask the class; open the presenter's link."))
    match command:
        case OpenVote():
            _open(show, desk)
        case AskTyped(words):
            _ask(show, desk, read_question(words) if isinstance(words, str) else None)
        case AskTypedAgain():
            _ask(show, desk, show.picture.typed[-1].asked if show.picture.typed else None)
        case CloseVote():
            performs = show.picture.voting
            _show_room(show, desk.close_vote())
            if performs:
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


def _ask(show: Presenter, desk: VoteDesk, asked: Asked | None) -> None:
    if asked is None:
        raise KnobError(NO_QUESTION)
    scene = show.picture.scene
    _show_room(show, desk.open_vote(show.lesson.id, scene.id if scene else "", 0, asked))


def _show_room(show: Presenter, view: RoomView) -> None:
    show.state = replace(show.state, room=view)
    show.redraw()
