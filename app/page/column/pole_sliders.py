"""Show the poles of the boards as sliders for keys and screen readers."""

from __future__ import annotations

import html
import math
import threading
import time
from collections.abc import Callable, Sequence

import viser

from ...course.knobs import Poles
from ...course.lesson import Board
from ...engine.systems import move_pole
from ...session.commands.commands import Edit, SetKnobs
from ...session.state.view import Picture
from ..stage.board_labels import pole_name
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input
from ..viser_private.write_once import write_content
from ..words import phrases
from .knob_widgets import pole_step

LONGEST_WORD = 120  # letters of what a page says of a slider
SNAP = 1e-6  # of the window's height: nearer to the real axis than this is on it


class PoleSliders:
    """For each pole that a hand can drag, one slider for its real part and one for its imaginary part; other poles in words."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, post: Callable[[Edit], int]) -> None:
        self._client, self._post, self._lang = client, post, picture.state.language
        self._knobs = {knob.name: knob for knob in picture.lesson.knobs if isinstance(knob, Poles)}
        self._boards: dict[str, Board] = {}
        self._order: dict[str, tuple[complex, ...]] = {}  # the poles of a board, each at the place of its sliders
        self._told: dict[str, float | None] = {}
        self._count = 0  # of the page's last message
        self._grip, self._holds = time.monotonic_ns(), False
        self._number = -1  # of the edit that carries the last move heard
        self._lock = threading.Lock()  # a move is heard on the server's loop, pictures are shown by the tab's own thread
        self._hand = ""
        if not picture.boards:
            return
        self._hand = viser_internals.node_id(hidden_input(client.gui, self._heard))
        self._sliders, self._words = client.gui.add_html(""), client.gui.add_html("")

    def show(self, picture: Picture) -> None:
        """The boards that are in sight, once the knobs rest and the last move is answered: the next one builds on it."""
        if self._hand and picture.resting:
            with self._lock:
                if picture.answered >= self._number:
                    self._write(picture)

    def _write(self, picture: Picture) -> None:
        scene = picture.scene
        boards = [] if picture.veiled else [each for each in picture.boards if scene is None or each.id in scene.boards]
        self._boards = {each.id: each for each in boards if each.knob in self._knobs and each.poles}
        self._order = {name: in_order(self._order.get(name, ()), board.held) for name, board in self._boards.items()}
        write_content(self._sliders, "".join(map(self._group, self._boards.values())))
        write_content(self._words, _spoken(boards, self._lang))
        places = {place: value for name in self._boards for place, value in self._places(name)}
        if places != self._told:
            self._told = places
            viser_internals.run_script(self._client, "slide", values=places, heard=self._count)

    def _group(self, board: Board) -> str:
        assert board.knob is not None
        knob = self._knobs[board.knob]
        title, step = html.escape(board.title(self._lang), quote=True), pole_step(knob)
        rows = []
        for k in range(len(board.poles)):
            name = html.escape(f"{knob.symbol}{k + 1}")
            parts = ("Re", phrases.REAL_PART, board.re_low, board.re_high), ("Im", phrases.IMAGINARY_PART, 0.0, board.im_high)
            ranges = "".join(
                f'<i aria-hidden="true">{sign}</i><input type="range" min="{low:g}" max="{high:g}" step="{step:g}" data-from="{low:g}" '
                f'data-slider="{board.id}.{k}.{axis}" data-to="{self._hand}" aria-label="{part.format(pole=name)(self._lang)}">'
                '<span class="ol-at" aria-hidden="true"></span>' for axis, (sign, part, low, high) in enumerate(parts))
            rows.append(f'<div class="ol-pole" hidden><b>{name}</b>{ranges}</div>')
        return f'<section class="ol-poles" role="group" aria-label="{title}"><b>{title}</b>{"".join(rows)}</section>'

    def _places(self, name: str) -> list[tuple[str, float | None]]:
        """Where the sliders of a board stand; None for those of the lower pole of a pair."""
        return [(f"{name}.{k}.{axis}", None if pole.imag < 0 else part)
                for k, pole in enumerate(self._order[name]) for axis, part in enumerate((pole.real, pole.imag))]

    def _heard(self, said: str) -> None:
        """A slider, the share of its way, whether the hand lets go, and a count; what is nonsense is passed over."""
        with self._lock:
            self._move(said)

    def _move(self, said: str) -> None:
        place, share, released, count = [*said[:LONGEST_WORD].split(":"), "", "", ""][:4]
        name, k, axis = [*place.split("."), "", ""][:3]
        board, order = self._boards.get(name), self._order.get(name, ())
        try:
            index, way, self._count = int(k), float(share), int(count)
        except ValueError:
            return
        if board is None or board.knob is None or not 0 <= index < len(order) or not math.isfinite(way):
            return
        step = pole_step(self._knobs[board.knob])
        pole = order[index]
        if axis == "0":
            to = complex(_on_grid(board.re_low + way * (board.re_high - board.re_low), step), pole.imag)
        else:
            to = complex(pole.real, _on_grid(way * board.im_high, step))
        if not self._holds:
            self._grip += 1
        self._holds = released != "1"
        self._told = {} if released == "1" else self._told  # said again, since the slider may stand where its pole cannot go
        self._order[name] = moved = move_pole(order, index, board.hold(to), axis_snap=SNAP * board.im_high)
        self._number = self._post(SetKnobs({board.knob: moved, **dict(board.also)}, self._grip))


def in_order(before: Sequence[complex], poles: Sequence[complex]) -> tuple[complex, ...]:
    """The poles in the order of before where they are the same ones, else each pair behind its upper pole.

    So a slider keeps its pole also where that overtakes another; a set of poles itself is sorted.
    """
    if sorted(before, key=_by_place) == sorted(poles, key=_by_place):
        return tuple(before)
    return tuple(each for pole in poles if pole.imag >= 0 for each in ((pole,) if pole.imag == 0 else (pole, pole.conjugate())))


def _by_place(pole: complex) -> tuple[float, float]:
    return pole.real, pole.imag


def _on_grid(value: float, step: float) -> float:
    """The value without the error of the share that brought it: a slider's steps are a thousand times as long."""
    return round(value / step * 1e3) * step / 1e3


def _spoken(boards: Sequence[Board], language: str) -> str:
    """What stands on the boards that no hand moves, for a screen reader."""
    said = []
    for board in boards:
        still = () if board.knob is not None else tuple(pole for pole in board.poles if pole.imag >= 0)
        words = [pole_name(pole, board) for pole in still]
        words += [f"{phrases.FIXED(language)} {pole_name(pole, board)}" for pole in board.fixed if pole.imag >= 0]
        if words:
            said.append(f'<p class="ol-spoken">{html.escape(board.title(language))}: {html.escape(", ".join(words))}</p>')
    return "".join(said)
