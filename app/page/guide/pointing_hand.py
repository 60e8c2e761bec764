"""Say where a scene wants a hand: on a cross of the stage, a knob, or a button of the run."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ...course.scenes import Move, Press, Scene, Solve
from ...session.state.view import Picture
from ..column.knob_widgets import Widget
from ..words import phrases

NOWHERE = MappingProxyType({"scene": "", "node": "", "widget": "", "button": ""})
BUTTONS = MappingProxyType({"kick": phrases.KICK, "play": phrases.PLAY})


def hand_target(picture: Picture, widgets: Mapping[str, Widget]) -> Mapping[str, str]:
    """The scene by its lesson and id, and what of the page its action needs; all is "" where nothing is to be shown."""
    scene = picture.scene
    if scene is None or scene.id in picture.state.done or picture.state.performance is not None or not picture.resting:
        return NOWHERE
    said = {**NOWHERE, "scene": f"{picture.lesson.id}/{scene.id}"}
    if isinstance(scene.do, Press) and scene.do.button == "pull":
        return {**said, "node": _grip(picture)} if _grip(picture) else NOWHERE
    if isinstance(scene.do, Press):
        return {**said, "button": BUTTONS[scene.do.button](picture.state.language)}
    knobs = scene.do.knobs if isinstance(scene.do, Move) else scene.knobs if isinstance(scene.do, Solve) else ()
    for knob in knobs:
        if node := _cross(picture, scene, knob):
            return {**said, "node": node}
        if knob in widgets and knob in scene.knobs:
            return {**said, "widget": widgets[knob].node}
    return NOWHERE


def _grip(picture: Picture) -> str:
    """The part of the plant that can be taken hold of first, by the name of its node; "" where there is none."""
    stage = picture.outcome.stage
    return f"/plant/{stage.held[0][0].parts[0]}" if stage is not None and stage.held else ""


def _cross(picture: Picture, scene: Scene, knob: str) -> str:
    """The slowest pole that a hand moves on a board of the scene, by the name of its node; "" where there is none."""
    board = next((each for each in picture.boards if each.knob == knob and each.id in scene.boards and each.poles), None)
    if board is None:
        return ""
    slowest = max(range(len(board.poles)), key=lambda k: board.poles[k].real)
    return f"/board/{board.id}/pole{slowest}"
