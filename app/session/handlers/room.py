"""Ask the class a question, and show how it has voted."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ...classroom.pole_grid import PoleGrid
from ...classroom.room import RoomView, VoteDesk
from ...classroom.votes import LONGEST_QUESTION, MAX_OPTIONS, Asked, read_pole_question, read_question
from ...course.figures.scene import Board
from ...course.knobs import KnobError
from ...course.scenes import Choose, Move
from ...text import NO_WORDS, Text, text
from ..commands.room import AskPole, AskTyped, AskTypedAgain, CloseVote, Lecturing, LowerHands, OpenVote, RoomChanged
from . import guide
from .presenter import Presenter

NO_POLE_QUESTION = text("A question for a pole has no options and at most {most} characters; it may be empty.", most=LONGEST_QUESTION)
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
            _ask(show, desk, read_question(words) if isinstance(words, str) else None, NO_QUESTION)
        case AskPole(words):
            _ask(show, desk, read_pole_question(words, _grid(show)) if isinstance(words, str) else None, NO_POLE_QUESTION)
        case AskTypedAgain():
            _ask(show, desk, show.picture.typed[-1].asked if show.picture.typed else None, NO_QUESTION)
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


def _ask(show: Presenter, desk: VoteDesk, asked: Asked | None, otherwise: Text) -> None:
    if asked is None:
        raise KnobError(otherwise)
    scene = show.picture.scene
    _show_room(show, desk.open_vote(show.lesson.id, scene.id if scene else "", 0, asked))


def _grid(show: Presenter) -> PoleGrid:
    """The window of a board: best of one whose poles the scene asks to move, else of one in sight that a hand moves; else a usual one."""
    scene, boards = show.picture.scene, show.picture.boards
    asked = scene.do.knobs if scene is not None and isinstance(scene.do, Move) else ()
    in_sight = {board.id for board in boards} if scene is None else set(scene.boards)
    board = max(boards, key=lambda each: (each.knob in asked, each.id in in_sight, each.knob is not None), default=Board("", NO_WORDS, ()))
    return PoleGrid(board.id, board.re_low, board.re_high, board.im_high, board.disc)


def _show_room(show: Presenter, view: RoomView) -> None:
    show.state = replace(show.state, room=view)
    show.redraw()
