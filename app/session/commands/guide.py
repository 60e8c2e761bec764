"""List what a person can ask of the guide, which leads along the scenes of a lesson's path."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SetMode:
    """Show the lesson as a guide, as a lab, or for a hall."""

    mode: object


@dataclass(frozen=True)
class GoToScene:
    """Open a scene of the path by its number from 0."""

    index: object


@dataclass(frozen=True)
class TurnScene:
    """So many scenes on, or back where `steps` is negative."""

    steps: int


@dataclass(frozen=True)
class ChooseOption:
    """Choose an option of the scene's question; −1 skips it."""

    index: object


Guiding = SetMode | GoToScene | TurnScene | ChooseOption
