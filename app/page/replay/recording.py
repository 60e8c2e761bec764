"""Write a run as a viser recording of its scene, with every change over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast

import numpy as np
import viser

from ...session.state.view import Picture, time_scale
from ..charts.style_sheet import clock_decimals
from ..stage.body_extent import reach
from ..stage.map_board import MapBoard, map_of
from ..stage.pole_boards import BoardView
from ..stage.stage import StageView
from ..stage.viewpoint import BOARDS_BEHIND, CAMERAS, FAR, NARROW, SIGHT, USUAL, Composition, away, composition, letters
from ..viser_private import viser_internals
from ..viser_private.scene_tape import Tape

MAX_RECORDED_MOMENTS = 1200  # moments of a run that are kept: the page shows no more than thirty a second
LARGER = tuple(1.12 ** k for k in range(8))  # how many times larger than on a laptop letters may be wanted on a small stage
RECORDING_SCRIPTS = ("frames", "keys", "floor")  # of what a page learns, all that matters where nothing can be dragged
DECIMALS = 4  # of stage units: a tenth of what a pixel shows


@dataclass(frozen=True)
class LaptopWindow:
    """A laptop's, and a camera in it that sees everything: what letters and boards ask for."""

    image_width: int = 1366
    image_height: int = 768
    position: tuple[float, ...] = tuple(USUAL.place[0])
    look_at: tuple[float, ...] = tuple(USUAL.place[1])
    fov: float = SIGHT


def record_run(picture: Picture, camera: tuple[float, ...] | None, words: dict[str, str]) -> bytes:
    """viser's recording of a picture's scene at its start, and in it the script that plays the run on the page.

    `camera` is position and target to look from, None for the whole view. The picture has a stage.
    """
    state, stage = picture.state, picture.outcome.stage
    assert stage is not None
    tape = Tape(LaptopWindow())
    client = cast(viser.ClientHandle, tape)
    composed = composition(*reach(stage))
    em = letters(client.camera, False, composed)
    view = StageView(client)
    view.furnish(state.is_dark)
    view.build(stage, state.language, em)
    boards, maps = _boards(client, picture, em, composed.foot), _maps(client, picture, em)
    lettered = [view, *boards, *maps]
    moments = stage.t[:: -(-len(stage.t) // MAX_RECORDED_MOMENTS)].tolist()
    view.pose(moments[0])
    sizes = [em * times for times in LARGER]
    run = {
        "owner": str(tape.client_id), "digits": clock_decimals(picture.horizon),
        "t": moments, "end": picture.end, "rate": time_scale(picture.horizon),
        "moves": channels(tape, [partial(view.pose, t) for t in moments]),
        "sizes": sizes, "letters": channels(tape, [partial(_fit, lettered, size) for size in sizes]),
        "behind": BOARDS_BEHIND, "sight": SIGHT, **_seen_from(camera, composed, bool(boards), bool(maps) or state.landscape),
    }
    for name in RECORDING_SCRIPTS:
        viser_internals.run_script(client, name)
    viser_internals.run_script(client, "replay", run=run, words=words)
    return tape.recording()


def _seen_from(camera: tuple[float, ...] | None, composed: Composition, boards: bool, charted: bool) -> dict[str, Any]:
    """Where the page looks from: position and target, how far the boards' letters are off, and the shape that shows all of it."""
    place = CAMERAS["map"] if charted else composed.place if boards else CAMERAS["bare"]
    far = away(place)
    narrow = composed.narrow if place == composed.place else NARROW * FAR / far
    return {"eye": [float(number) for number in np.ravel(place)] if camera is None else camera, "near": far, "narrow": narrow}


def _boards(client: viser.ClientHandle, picture: Picture, em: float, foot: float) -> list[BoardView]:
    """The boards, which nobody can drag."""
    out = []
    for board in picture.boards:
        still = replace(board, knob=None)
        out.append(BoardView(client, still, picture.state.language, em, picture.state.is_dark, foot, lambda values, grip: None))
        out[-1].show(still, veiled=False)
        out[-1].show_landscape(picture.state.landscape and board.landscape is not None)
    return out


def _maps(client: viser.ClientHandle, picture: Picture, em: float) -> list[MapBoard]:
    """The map in front of the stage, if the lesson has one and it has been computed."""
    figure = map_of(picture)
    if figure is None or np.all(figure.values < 0):
        return []
    board = MapBoard(client, picture.state.language, em, picture.state.is_dark, lambda x, y: None)
    board.show(figure)
    return [board]


def _fit(lettered: Sequence[StageView | BoardView | MapBoard], em: float) -> None:
    for part in lettered:
        part.fit(em)


def channels(tape: Tape, steps: Sequence[Callable[[], object]]) -> list[dict[str, Any]]:
    """Each property that the steps change, with the numbers of the steps from which on it has another value, and these values.

    The scene stands as after the first step, and stands so again afterwards.
    """
    found: dict[tuple[str, str], list[tuple[int, Any]]] = {}
    for k, step in enumerate([*steps[1:], steps[0]], 1):
        for name, prop, value in tape.changes(step):
            found.setdefault((name, prop), []).append((k, value))
    out = []
    for (name, prop), values in found.items():
        at, to = [0], [_plain(values[-1][1])]  # on the way back, or with its last change, it came to where it had been
        for k, value in values:
            plain = _plain(value)
            if k < len(steps) and plain != to[-1]:
                at.append(k)
                to.append(plain)
        out.append({"name": name, "prop": prop, "floats": isinstance(values[-1][1], np.ndarray), "at": at, "to": to})
    return out


def _plain(value: Any) -> Any:
    """A value as JSON holds it, in as many decimals as can be seen."""
    if isinstance(value, (bool, str, int)) or value is None:
        return value
    if isinstance(value, float):
        return round(value, DECIMALS) + 0.0
    return [round(number, DECIMALS) + 0.0 for number in np.ravel(value).tolist()]
