"""Say which figures and boards would answer a question, and what boards keep of how a scene began."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..design import Design
from ..scenes import Choose, Move, Question, Scene
from .records import Figure
from .scene import Board


def veiled_figures(path: Sequence[Scene], answering: str, figures: Sequence[Figure]) -> tuple[str, ...]:
    """The figures that answer a lesson's first question, by id: `answering`, those that the path brings after it, and their tabs' others.

    All of them where neither is among the figures.
    """
    at = _asked_at(path)
    seen = {name for scene in path[:at] for name in scene.figures}
    told = {answering} | {name for scene in path[at:] for name in scene.figures} - seen
    tabs = {figure.tab.id for figure in figures if figure.id in told}
    return tuple(figure.id for figure in figures if figure.tab.id in tabs or not tabs)


def boards_with_question(path: Sequence[Scene]) -> frozenset[str]:
    """The boards that the path shows up to its first question and with it: they do not answer it."""
    return frozenset(name for scene in path[: _asked_at(path) + 1] for name in scene.boards)


def _asked_at(path: Sequence[Scene]) -> int:
    return next((k for k, scene in enumerate(path) if scene.do == Choose(Question.FIRST)), 0)


def boards_with_beginning(boards: Sequence[Board], scene: Scene | None, began: Design | None, now: Design) -> tuple[Board, ...]:
    """The boards with where their poles stood when the scene began, once a question's answer or a hand has moved one of them."""
    if began is None or scene is None or not isinstance(scene.do, Choose | Move):
        return tuple(boards)
    before = {board.id: began[board.knob] for board in boards if board.knob is not None and now[board.knob] == board.poles}
    moved = any(before.get(board.id, board.poles) != board.poles for board in boards)
    same_count = all(len(before[board.id]) == len(board.poles) for board in boards if board.id in before)
    return tuple(replace(board, began=before.get(board.id, ())) for board in boards) if moved and same_count else tuple(boards)
