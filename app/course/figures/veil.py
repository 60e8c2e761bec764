"""Say which figures and boards would answer a lesson's first question."""

from __future__ import annotations

from collections.abc import Sequence

from ..scenes import Choose, Question, Scene
from .records import Figure


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
