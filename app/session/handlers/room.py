"""Ask the class a question, and show how it has voted."""

from __future__ import annotations

from dataclasses import replace

from ...classroom.answer_grids import COLUMNS, PoleGrid, SketchGrid
from ...classroom.room import RoomView, VoteDesk
from ...classroom.votes import LONGEST_QUESTION, MAX_OPTIONS, Asked, Vote, read_pole_question, read_question
from ...course.figures.scene import Board
from ...course.guiding.predictions import prediction_of
from ...course.knobs import KnobError
from ...course.scenes import Choose, Move
from ...text import NO_WORDS, Text, text
from . import guide
from .presenter import Presenter

NO_POLE_QUESTION = text("A question for a pole has no options and at most {most} characters; it may be empty.", most=LONGEST_QUESTION)
PAUSED = text("The lecturer has paused all pages. Look to the front; your page goes on by itself.")
NO_QUESTION = text("Type a question on the first line and two to {most} short options on the lines below. "
                   "Without options the class answers with a number.", most=MAX_OPTIONS)


def ask_typed(show: Presenter, words: object) -> None:
    """Ask the class a typed question. Raises KnobError."""
    _ask(show, read_question(words) if isinstance(words, str) else None, NO_QUESTION)


def ask_pole(show: Presenter, words: object) -> None:
    """Ask the class to place a pole. Raises KnobError."""
    _ask(show, read_pole_question(words, _grid(show)) if isinstance(words, str) else None, NO_POLE_QUESTION)


def ask_sketch(show: Presenter) -> None:
    """Ask the class to draw its prediction into the figure of the scene's question. Raises KnobError."""
    question = show.picture.question
    fits = question is not None and len(question.columns) > 0 and (not question.bars or len(question.columns) <= COLUMNS)
    if question is None or not fits:
        raise KnobError(text("The question of this scene is not answered by a drawing; open the vote on its options."))
    _ask(show, Asked("", sketch=SketchGrid(min(len(question.columns), COLUMNS), question.bars)), NO_QUESTION)


def ask_typed_again(show: Presenter) -> None:
    """Ask the typed question once more. Raises KnobError."""
    _ask(show, show.picture.typed[-1].asked if show.picture.typed else None, NO_QUESTION)


def close_vote(show: Presenter) -> None:
    """Take no more votes; nothing tells the answer yet. Raises KnobError."""
    show_room(show, _desk(show).close_vote())


def show_counts(show: Presenter, number: object) -> None:
    """Show the counts of a closed vote to everybody. Raises KnobError."""
    show_room(show, _desk(show).show_counts(_closed(show, number), True))


def hide_counts(show: Presenter, number: object) -> None:
    """Hide the counts of a closed vote. Raises KnobError."""
    show_room(show, _desk(show).show_counts(_closed(show, number), False))


def discuss(show: Presenter, number: object) -> None:
    """Let the class discuss a closed vote for a while. Raises KnobError."""
    show_room(show, _desk(show).discuss(_closed(show, number)))


def reveal(show: Presenter, number: object) -> None:
    """Tell the answer to a closed vote; the page then does what the question asks about. Raises KnobError."""
    vote = _closed(show, number)
    performs = vote in show.picture.votes or (vote.kind == "sketch" and vote in show.picture.typed)
    show_room(show, _desk(show).reveal(vote))
    if performs:
        guide.perform_answer(show)


def _closed(show: Presenter, number: object) -> Vote:
    """The closed vote of that number. Raises KnobError."""
    room = show.state.room
    found = [vote for vote in (room.votes if room is not None else ()) if str(vote.number) == str(number) and not vote.open]
    if not found:
        raise KnobError(text("There is no closed vote {number}.", number=str(number)[:20]))
    return found[0]


def lower_hands(show: Presenter) -> None:
    """Forget who asked for a slower lecture. Raises KnobError."""
    show_room(show, _desk(show).lower_hands())


def pause_all(show: Presenter) -> None:
    """Pause the pages of the class. Raises KnobError."""
    show_room(show, _desk(show).pause(True))


def end_pause(show: Presenter) -> None:
    """Let the pages of the class go on. Raises KnobError."""
    show_room(show, _desk(show).pause(False))


def freeze(show: Presenter, on: bool) -> None:
    """Let this page of the class stand still, or go on with the run that it was playing."""
    state = show.state
    if on and not state.frozen:
        guide.stop(show)
        show.change(replace(show.state, frozen=True, goes_on=state.playing, playing=False, loop=None))
        show.view.pose(show.state.t)
    elif state.frozen and not on:
        show.change(replace(state, frozen=False, goes_on=False, playing=state.goes_on))


def _desk(show: Presenter) -> VoteDesk:
    """The desk at which the class votes. Raises KnobError in a tab that does not present."""
    if show.vote_desk is None:
        raise KnobError(text("Only the presenter's tab can ask the class; open the presenter's link."))
    return show.vote_desk


def open_vote(show: Presenter) -> None:
    """Ask the class the question of the open scene, or ask it again. Raises KnobError."""
    desk, scene = _desk(show), show.picture.scene
    if scene is None or not isinstance(scene.do, Choose):
        raise KnobError(text("This scene asks no question; turn to one that does."))
    options = prediction_of(show.lesson, scene, show.state.language).options
    show_room(show, desk.open_vote(show.lesson.id, scene.id, len(options)))


def _ask(show: Presenter, asked: Asked | None, otherwise: Text) -> None:
    desk = _desk(show)
    if asked is None:
        raise KnobError(otherwise)
    scene = show.picture.scene
    if show.picture.typed and show.picture.typed[-1].open and show.picture.typed[-1].asked == asked:
        return  # it was asked already: the page has sent it again after an outage
    show_room(show, desk.open_vote(show.lesson.id, scene.id if scene else "", 0, asked))


def _grid(show: Presenter) -> PoleGrid:
    """The window of a board: best of one whose poles the scene asks to move, else of one in sight that a hand moves; else a usual one."""
    scene, boards = show.picture.scene, show.picture.boards
    asked = scene.do.knobs if scene is not None and isinstance(scene.do, Move) else ()
    in_sight = {board.id for board in boards} if scene is None else set(scene.boards)
    board = max(boards, key=lambda each: (each.knob in asked, each.id in in_sight, each.knob is not None), default=Board("", NO_WORDS, ()))
    return PoleGrid(board.id, board.re_low, board.re_high, board.im_high, board.disc)


def show_room(show: Presenter, view: RoomView) -> None:
    """Show who is here and how the votes stand."""
    show.state = replace(show.state, room=view)
    show.redraw()
