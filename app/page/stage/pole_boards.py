"""Draw the pole boards: poles are crosses to drag, fixed modes are bolts."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection
from itertools import pairwise
from typing import Any

import numpy as np
import viser

from ...colours import COLOURS, rgb
from ...course.lesson import Board
from ...engine.systems import move_pole
from ...text import Text
from ..charts.axes import ticks
from ..charts.text_layout import text_width
from ..words import phrases
from .board_face import board_colours, draw_board_texture
from .board_labels import Frame, best_place, leader_line, pole_name
from .drag_handles import GRIPS, LOCKS, DragHandles, Vector
from .meshes import bolt, cross, landscape
from .pinned_poles import PinMarks
from .scene_labels import SceneLabels, Size
from .trails import PoleTrail
from .viewpoint import BOARD_HEIGHT, BOARD_MARGIN, BOARD_WIDTH, board_place

SNAP = 0.02  # of the window's height: nearer to the real axis than this is on it
NUMBERS_WIDE = 0.28  # stage units inside the right edge for the numbers of the imaginary axis
NAME_FRAME = Frame(
    -BOARD_WIDTH / 2 - BOARD_MARGIN, BOARD_WIDTH / 2 - NUMBERS_WIDE, -BOARD_HEIGHT / 2, BOARD_HEIGHT / 2 + BOARD_MARGIN
)  # what names may fill, clear of those of the axes
HIDDEN_SEGMENT = ((0.0, 0.0, -9.0), (0.0, 0.0, -9.0))  # of a line that is not seen: viser keeps a node that has at least one
UPRIGHT = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # pictures lie flat until they are turned
RING, RING_SIDES = 0.085, 28  # radius of a zero's mark in stage units
CORNER = 0.78  # of the height of a board's lower half: from there on is its corner, where the words on its rings are


class BoardView:
    """One board: drawn once, then only its poles move."""

    def __init__(self, client: viser.ClientHandle, board: Board, language: str, em: float, dark: bool, foot: float,
                 drag: Callable[[dict[str, Any], int], object], say: Callable[[Text], object] | None = None) -> None:
        self._client, self._scene, self._drag, self._say = client, client.scene, drag, say
        self._board, self._letters, self._language = board, SceneLabels(client.scene, em), language
        self._ink = board_colours(dark)
        self._root = f"/board/{board.id}"
        (x, y), turn = board_place(board.side, None)
        self._origin = np.array([x, y, foot + BOARD_HEIGHT / 2])
        self._turn = turn
        self._frame = self._scene.add_frame(self._root, show_axes=False, position=tuple(self._origin),
                                            wxyz=(math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)))
        self._poles: list[viser.MeshHandle] = []
        self._labels: list[viser.LabelHandle] = []
        self._bolts: list[viser.MeshHandle] = []
        self._bolted: list[viser.LabelHandle] = []
        self._nameless: set[str] = set()  # labels that are not shown: of the lower pole of a pair, or where there is no room
        self._rings: list[Any] = []
        self._zeros: tuple[complex, ...] = ()
        self._signature: tuple[Any, ...] = ()
        self._shown: tuple[complex, ...] | None = None
        self._held = True
        self._grip = time.monotonic_ns()  # told apart from the grips of every other board
        self._grabbed: tuple[int, tuple[complex, ...], complex] | None = None  # which pole, all poles, from hand to pole
        self._grips = DragHandles(client, self._root + GRIPS, COLOURS[board.role], self._origin, self._pulled)
        self._locks = DragHandles(client, self._root + LOCKS, None, self._origin, self._refused)
        self._surface: viser.MeshHandle | None = None
        self._trail = PoleTrail(self._scene, f"{self._root}/trail", rgb(COLOURS[board.role]), self._ink.glass, self.local)
        self._pins = PinMarks(self._letters, self._root, rgb(COLOURS[board.role]), lambda pole: self.local(pole, 0.02), self._ink)
        self._draw(language)

    # --- s-plane ↔ stage -------------------------------------------------------------------------------------------
    def local(self, s: complex, lift: float = 0.0) -> tuple[float, float, float]:
        """Where s lies on the board, in the board's own frame."""
        b = self._board
        s = b.hold(s)
        x = ((s.real - b.re_low) / (b.re_high - b.re_low) - 0.5) * BOARD_WIDTH
        return x, -0.05 - lift, s.imag / b.im_high * BOARD_HEIGHT / 2

    def s_at(self, point: tuple[float, float, float]) -> complex:
        """The s under a point of the drag plane, seen from the camera."""
        eye = np.asarray(self._client.camera.position, dtype=float)
        ray = np.asarray(point, dtype=float) - eye
        c, s = math.cos(self._turn), math.sin(self._turn)
        along, normal = np.array([c, s, 0.0]), np.array([-s, c, 0.0])
        depth = float(ray @ normal)
        if abs(depth) < 1e-9:
            hit = np.asarray(point, dtype=float)
        else:
            hit = eye + ray * float((self._origin - 0.05 * normal - eye) @ normal) / depth
        b, offset = self._board, hit - self._origin
        re = (float(offset @ along) / BOARD_WIDTH + 0.5) * (b.re_high - b.re_low) + b.re_low
        im = float(offset[2]) / (BOARD_HEIGHT / 2) * b.im_high
        return b.hold(complex(re, im))

    # --- drawing ---------------------------------------------------------------------------------------------------
    def _draw(self, language: str) -> None:
        scene, root, b = self._scene, self._root, self._board
        scene.add_box(f"{root}/glass", self._ink.glass, (BOARD_WIDTH + 2 * BOARD_MARGIN, 0.04, BOARD_HEIGHT + 2 * BOARD_MARGIN),
                      cast_shadow=False, receive_shadow=False)
        scene.add_image(
            f"{root}/face",
            draw_board_texture(b, BOARD_MARGIN / BOARD_HEIGHT, self._ink),
            BOARD_WIDTH + 2 * BOARD_MARGIN,
            BOARD_HEIGHT + 2 * BOARD_MARGIN,
            format="png",
            cast_shadow=False,
            receive_shadow=False,
            position=(0.0, -0.025, 0.0),
            wxyz=UPRIGHT,
        )
        self._letter_axes()
        title = b.title(language)
        self._label("title", title, (0.0, -0.06, BOARD_HEIGHT / 2 + BOARD_MARGIN + 0.06), "bottom-center",
                    lambda em: min(1.2, (BOARD_WIDTH + 3 * BOARD_MARGIN) / max(text_width(title, em), em)))  # not into the next one's
        self._asks = self._label("asks", phrases.VEILED_BOARD(language), (0.0, -0.06, 0.0), "center-center", 1.2)
        self._leaders = scene.add_line_segments(
            f"{root}/leaders", np.array([HIDDEN_SEGMENT], dtype=np.float32), self._ink.leader, thickness=0.012
        )

    def _letter_axes(self) -> None:
        b = self._board
        for re in ticks(b.re_low, b.re_high):
            x, y, _ = self.local(complex(re, 0))
            self._label(f"re{re:g}", f"{re:g}".replace("-", "−"), (x, y, -BOARD_HEIGHT / 2 - 0.02), "top-center", depth_test=True)
        for im in ticks(-b.im_high, b.im_high, 4):
            if im != 0 and im > -CORNER * b.im_high:  # lower it would lie on the last number below
                x, y, z = self.local(complex(b.re_high, im), 0.07)  # before the board also where it turns away
                self._label(f"im{im:g}", f"{im:g}j".replace("-", "−"), (x - 0.03, y, z), "center-right", depth_test=True)

    def show(self, board: Board, veiled: bool, waits: bool = False, calm: bool = True, rests: bool = True) -> None:
        """Move the poles to where the design has them. Veiled ones are not seen; while a prediction `waits`, no hand can take one.

        Unless the tab is `calm`, the way of one that is dragged is drawn until the knobs rest.
        """
        before, self._board, self._held = self._shown, board, veiled or waits or board.knob is None
        self._grips.show([] if self._held else [self.local(pole) for pole in board.poles])
        locked = () if veiled or waits or self._say is None else (*board.fixed, *(board.poles if board.knob is None else ()))
        self._locks.show([self.local(pole) for pole in locked])
        if board.zeros != self._zeros:
            self._make_rings(board)
        ringed = self._pins.show(board, self._language)
        signature = (len(board.poles), board.fixed, board.knob)
        if signature != self._signature:
            self._make_poles(board)
            self._signature = signature
            before = None
        self._shown = board.poles
        if ringed or before != board.poles:  # else nothing moved: no message, and no frame of the scene
            self._move(board)
        if calm or (rests and self._grabbed is None):
            self._trail.end()
        self._trail.draw()
        self._cover(veiled)

    def stand_among(self, shown: Collection[str] | None) -> None:
        """Be seen where a scene shows this board, and always for None; a board that is alone stands in the middle."""
        visible, ((x, _), turn) = shown is None or self._board.id in shown, board_place(self._board.side, shown)
        if turn != self._turn:
            self._origin[0], self._turn = x, turn  # the discs look from this array too
            self._frame.position, self._frame.wxyz = tuple(self._origin), (math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2))
        if self._frame.visible != visible:
            self._frame.visible = visible

    def _cover(self, veiled: bool) -> None:
        """Show what stands on the glass, or only a word that it is still to be predicted."""
        for handle in (*self._poles, *self._bolts, *self._rings, *self._pins.nodes, self._leaders, *self._labels, *self._bolted):
            seen = not veiled and handle.name not in self._nameless
            if handle.visible != seen:
                handle.visible = seen
        if self._asks.visible != veiled:
            self._asks.visible = veiled

    def _move(self, board: Board) -> None:
        """Crosses to where the poles are, and their names to where they cover nothing; a pair has one name."""
        spots = [(at[0], at[2]) for at in map(self.local, (*board.poles, *board.zeros, *board.fixed))]
        taken, ways, axes = *self._pins.taken(board, self._language), ((self.local(0j)[0], None), (None, 0.0))
        leaders: list[tuple[Vector, Vector]] = []
        named = [(pole, pole_name(pole, board), label) for pole, label in zip(board.poles, self._labels, strict=True) if pole.imag >= 0]
        named += [(pole, f"{phrases.FIXED(self._language)} {pole_name(pole, board)}", label)
                  for pole, label in zip(board.fixed, self._bolted, strict=True) if pole.imag >= 0]
        for handle, pole in zip(self._poles, board.poles, strict=True):
            handle.position = self.local(pole, 0.03)
        self._nameless = {label.name for label in (*self._labels, *self._bolted)} - {label.name for _, _, label in named}
        for pole, text, label in named:
            x, y, z = self.local(pole, 0.1)
            at = best_place(x, z, text, self._letters.em, NAME_FRAME, taken, spots, ways, axes)
            if at is None:
                self._nameless.add(label.name)
                continue
            taken.append(at)
            if label.text != text:
                label.text = text
            label.position = (at.x, y, at.z)
            if (line := leader_line(at, x, z, spots)) is not None:
                leaders.append(((line[0][0], y, line[0][1]), (line[1][0], y, line[1][1])))
        points = np.array(leaders or [HIDDEN_SEGMENT], dtype=np.float32)
        if not np.array_equal(points, self._leaders.points):
            self._leaders.points = points

    def _make_poles(self, board: Board) -> None:
        for mesh in (*self._poles, *self._bolts):
            mesh.remove()
        for label in (*self._labels, *self._bolted):
            self._letters.remove(label)
        self._poles, self._labels, self._bolts, self._bolted = [], [], [], []
        vertices, faces = cross()
        for i, pole in enumerate(board.poles):
            self._poles.append(self._scene.add_mesh_simple(
                f"{self._root}/pole{i}", vertices, faces, color=rgb(COLOURS[board.role]), cast_shadow=False, receive_shadow=False,
                position=self.local(pole, 0.03)))
            self._labels.append(self._label(f"name{i}", "", (0.0, 0.0, 0.0), "center-center"))
        head, head_faces = bolt()
        for i, pole in enumerate(board.fixed):
            self._bolts.append(self._scene.add_mesh_simple(
                f"{self._root}/bolt{i}", head, head_faces, color=self._ink.axis, flat_shading=True, cast_shadow=False,
                position=self.local(pole, 0.0)))
            self._bolted.append(self._label(f"bolted{i}", "", (0.0, 0.0, 0.0), "center-center"))

    def _label(self, name: str, words: str, at: Vector, anchor: Any, size: Size = 1.0, depth_test: bool = False) -> viser.LabelHandle:
        return self._letters.write(f"{self._root}/{name}", words, at, anchor, size, depth_test=depth_test)

    def _make_rings(self, board: Board) -> None:
        """Zeros as rings on the glass, those inside the window."""
        for old in self._rings:
            old.remove()
        self._rings, self._zeros = [], board.zeros
        angle = np.linspace(0.0, 2 * np.pi, RING_SIDES + 1)
        for i, zero in enumerate(z for z in board.zeros if board_contains(board, z)):
            x, y, z = self.local(zero, 0.02)
            points = [(x + RING * math.cos(a), y, z + RING * math.sin(a)) for a in angle]
            self._rings.append(self._scene.add_line_segments(
                f"{self._root}/zero{i}", np.array(list(pairwise(points)), dtype=np.float32), self._ink.axis, thickness=0.025))

    def needs_resize(self, em: float) -> bool:
        """Whether `fit` has something to do; asked from the server's loop."""
        return self._letters.misfit(em) or self._grips.misfit or self._locks.misfit

    def fit(self, em: float) -> None:
        """Make letters, and what the hand takes hold of, as large as camera and window ask for."""
        if self._letters.resize(em) and self._shown is not None:
            self._move(self._board)  # names find their places anew
        self._grips.fit()
        self._locks.fit()

    async def _refused(self, event: viser.SceneNodeDragEvent) -> None:
        """Say why a cross stays where it is; held by this disc, the pointer does not turn the camera."""
        if event.phase == "start" and self._say is not None:
            self._say(phrases.COMPUTED_POLES if self._board.knob is None else phrases.FIXED_POLE)

    async def _pulled(self, event: viser.SceneNodeDragEvent) -> None:
        board = self._board
        if board.knob is None or self._held:
            return
        if event.phase == "start" or self._grabbed is None:
            self._grabbed = self._taken(event.start_position)
            self._grip += 1
            self._trail.begin(self._grabbed[1][self._grabbed[0]])
        index, origin, offset = self._grabbed
        to = board.hold(self.s_at(event.end_position) + offset)
        if not (math.isfinite(to.real) and math.isfinite(to.imag)):
            return  # a camera or a pointer of nonsense
        self._trail.reach(to if abs(to.imag) > SNAP * board.im_high else complex(to.real))
        self._drag({board.knob: move_pole(origin, index, to, axis_snap=SNAP * board.im_high), **dict(board.also)}, self._grip)
        if event.phase == "end":
            self._grabbed = None

    def _taken(self, point: tuple[float, float, float]) -> tuple[int, tuple[complex, ...], complex]:
        """The pole nearest to where a hand takes hold, all poles then, and the way from the hand to that pole."""
        poles, hand = self._board.held, self.s_at(point)
        index = min(range(len(poles)), key=lambda i: math.dist(self.local(poles[i]), self.local(hand)))
        offset = poles[index] - hand
        return index, poles, offset if math.isfinite(abs(offset)) else 0j

    def show_landscape(self, visible: bool) -> None:
        """The surface of |det(sI − M)|⁻¹ in front of the stage, or nothing."""
        matrix = self._board.landscape
        if not visible or matrix is None:
            if self._surface is not None:
                self._surface.remove()
                self._surface = None
            return
        b = self._board
        vertices, faces = landscape(matrix, np.linspace(b.re_low, b.re_high, 56), np.linspace(-b.im_high, b.im_high, 40),
                                    3.6, 1.8, 1.0)
        if self._surface is None:
            self._surface = self._scene.add_mesh_simple(
                "/landscape", vertices, faces, color=rgb(COLOURS[b.role]), opacity=0.75, side="double",
                position=(0.0, -2.9, 0.01))
        else:
            self._surface.vertices = vertices


def board_contains(board: Board, s: complex) -> bool:
    """Whether s lies in the part of the plane that the board shows."""
    return board.re_low <= s.real <= board.re_high and abs(s.imag) <= board.im_high
