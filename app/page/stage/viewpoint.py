"""Set the camera: named viewpoints fitted to the window, and the size of letters from there."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import viser

PHONE = 0.58  # width over height of a canvas below which it is a phone's, whose letters are smaller and whose discs are for fingers
NARROW = 1.03  # width over height of a canvas that just shows the stage without boards, or with a map in front
USUAL_ASPECT = 1.208  # the same of the narrowest canvas of a laptop
FAR = 12.2  # stage units: from where a canvas as NARROW is looked at
NARROW_PLANT = 1.15  # the same of a canvas that just shows the whole plant from near
SIGHT = 0.62  # radians of the field of view: the boards stay readable
ABOVE = 1.78  # times farther away that shows the whole stage in what a sheet leaves of it, however wide that is
ABOVE_BOARDS, BOARDS_AIM_SHARE = 2.25, 0.16  # the same two where boards stand, whose picture is full
SHEET_AIM_SHARE = 0.14  # of the way to what is looked at: aim this much lower where a sheet lies over the lower half
SHEET_TOP = 0.26  # of half the canvas' height, above its middle: the upper edge of a sheet with the row of the run
WORDS_LOW = (-1.8, -0.4)  # y and z of the lowest words before a plant
MOST_STEPS_BACK, STEP_BACK = 20, 1.04  # times that it is looked at from farther off, and how much each time
SKY_SHARE = 0.95  # of half the canvas' height: how high what stands above a sheet may reach
LOWER = 0.02  # of the way to what is looked at: aim this much lower above the run in large print
BOARDS_BEHIND = 0.9  # stage units from what the composed view looks at to the boards
BOARD_WIDTH, BOARD_HEIGHT, BOARD_MARGIN, BOARD_ASIDE = 2.56, 2.0, 0.12, 1.58  # of the s-plane; glass around it; its middle from the stage's
CORNER = 0.18  # stage units that a board's outer edge is nearer than its middle, because it is turned
SPREAD = BOARD_ASIDE + BOARD_WIDTH / 2 + BOARD_MARGIN  # stage units from the middle to the outer edge of a board
LEAST_FOOT, FOOT_GAP = 1.2, 0.3  # stage units: boards stand no lower; they stand so far above the body
TITLE_HIGH = MappingProxyType({False: 0.26, True: 0.42})  # stage units that the title takes above a board, and in large print
FLOOR_SHARE = MappingProxyType({False: 0.76, True: 0.72})  # of half the canvas: the floor in front, above the run, in large print
LAB_FLOOR_SHARE = 0.52  # the same where the panel of the run lies over the stage
TOP_SHARE, SIDE_SHARE = 0.945, 0.965  # of half the canvas: the titles, what is at a side
FRONT = 1.0  # stage units from the plant to the front of its base
LOOKS_DOWN = 0.115  # stage units that the composed view falls in each unit ahead
BOARD_PLACES = MappingProxyType({"left": ((-BOARD_ASIDE, 1.5), 0.13), "right": ((BOARD_ASIDE, 1.5), -0.13), "middle": ((0.0, 1.5), 0.0)})
LETTER_SHARES = 1 / 48, 1 / 80, 1 / 56  # of the window's height: a letter in large print, on a phone, elsewhere
LEAST_LETTER = 0.115  # stage units: where boards are large in the window, so are their letters
USUAL_HALF_WIDTH, USUAL_HEIGHT = 2.6, 3.3  # stage units of a body that "plant" shows
LOW_AIM = 0.15  # of its size: the eye aims so far below the middle of a low body, clear of the run
LEAST_BODY = 0.6  # of that: a smaller body is not looked at from nearer
CAMERAS = MappingProxyType({
    "map": ((0.0, -13.4, 3.6), (0.0, 0.6, 1.5)),  # all where a map lies in front
    "plant": ((0.0, -8.2, 2.9), (0.0, 0.0, 1.0)),
    "bare": ((0.0, -11.2, 2.8), (0.0, 0.3, 0.75)),  # all there is where no boards stand, in the middle of what the run leaves free
})
TURNS = MappingProxyType({  # how far round the plant (rad), how high (rad) and how many times as far off as "plant" is
    "plant": (0.0, 0.0, 1.0), "near": (0.0, -0.04, 0.8), "left": (-0.42, 0.02, 1.0), "right": (0.42, 0.02, 1.0),
    "above": (0.0, 0.42, 1.0), "low": (0.0, 0.16, 1.02), "low left": (-0.3, 0.16, 1.0), "low right": (0.3, 0.16, 1.0),
    "table": (0.0, 0.36, 0.98)})
LOW, TABLE_AIM = ("low", "low left", "low right"), (-0.5, 0.85)  # y and z that "table" looks at
Place = tuple[Sequence[float], Sequence[float]]  # position and target of the eye


@dataclass(frozen=True)
class Composition:
    """The picture of a plant with its boards: from where it is seen, how high the boards stand, and the narrowest canvas for it.

    `narrow` is width over height; the body reaches `half` to either side.
    """

    place: Place
    foot: float
    narrow: float
    half: float

    def retreat(self, aspect: float) -> float:
        """How many times farther away a canvas of this shape looks from, so that boards and body are in it."""
        shown, whole = SIDE_SHARE * math.tan(SIGHT / 2) * max(aspect, 0.2), away(self.place)
        return max(1.0, (SPREAD / shown - BOARDS_BEHIND + CORNER) / whole, (self.half / shown + FRONT + self.place[1][1]) / whole)

    @property
    def boards(self) -> Place:
        """From where the boards alone are seen."""
        high = self.foot + BOARD_HEIGHT / 2
        return (0.0, -7.8, high + 0.3), (0.0, 1.6, high)


def composition(half: float, high: float, lecture: bool = False, lab: bool = False) -> Composition:
    """The boards just above a body that reaches `half` to either side and so `high`, seen from as near as shows all of it."""
    foot, floor = max(LEAST_FOOT, high + FOOT_GAP), LAB_FLOOR_SHARE if lab else FLOOR_SHARE[lecture]
    top = foot + BOARD_HEIGHT + BOARD_MARGIN + TITLE_HIGH[lecture]
    slope, (target_y, boards_y) = math.tan(SIGHT / 2), (0.6, 0.6 + BOARDS_BEHIND)
    falls = LOOKS_DOWN * (FRONT + boards_y)
    tall = ((top + falls) / slope - TOP_SHARE * boards_y + floor * FRONT) / (TOP_SHARE + floor)
    shown = SIDE_SHARE * slope  # of a canvas as wide as high, in each unit ahead, to either side
    away_y = max(tall, SPREAD / (shown * USUAL_ASPECT) - boards_y, half / (shown * USUAL_ASPECT) + FRONT)
    aim = (floor * slope * (away_y - FRONT) - LOOKS_DOWN * (FRONT + target_y)
           + top + LOOKS_DOWN * BOARDS_BEHIND - TOP_SHARE * slope * (away_y + boards_y)) / 2  # what is left is shared above and below
    place = (0.0, -away_y, aim + LOOKS_DOWN * (away_y + target_y)), (0.0, target_y, aim)
    return Composition(place, foot, max(SPREAD / (away_y + boards_y), half / (away_y - FRONT)) / shown, half)


def aspect_of(camera: viser.CameraHandle) -> float:
    """Width over height of the canvas; 1 where the browser says nothing sensible of it."""
    if camera.image_height > 0 and camera.image_width > 0:
        return camera.image_width / camera.image_height
    return 1.0


USUAL = composition(USUAL_HALF_WIDTH, USUAL_HEIGHT)  # where nothing is known of the body


def board_place(side: str, shown: Collection[object] | None) -> tuple[tuple[float, float], float]:
    """Where a board of a side stands, x and y, and how it is turned (rad), if a scene shows these boards; None outside of scenes."""
    return BOARD_PLACES["middle" if shown is not None and len(shown) == 1 else side]


def letters(camera: viser.CameraHandle, lecture: bool, composed: Composition = USUAL) -> float:
    """The size of letters (stage units) at the boards that is a certain share of the window's height in the composed view.

    1/48 in lecture mode, whatever the window: legible from the last row; else fourteen pixels of a laptop and ten of a phone, or more
    where boards are large in the window.
    """
    aspect = aspect_of(camera)
    depth = away(composed.place) * composed.retreat(aspect) + BOARDS_BEHIND
    hall, phone, usual = (share * 2 * math.tan(SIGHT / 2) * depth for share in LETTER_SHARES)
    return hall if lecture else phone if aspect < PHONE else max(usual, LEAST_LETTER)


def body_scale(box: tuple[float, float]) -> float:
    """How many times as large as usual a body is that reaches so far to either side and so high."""
    return max(box[0] / USUAL_HALF_WIDTH, box[1] / USUAL_HEIGHT, LEAST_BODY)


def round_plant(scale: float, tall: float = USUAL_HEIGHT) -> dict[str, Place]:
    """From where a body so many times as large as usual, and so `tall`, is seen alone, by the names of TURNS.

    From a place of LOW the eye aims at the middle of a low body and stands higher: neither sky nor floor takes most of the picture.
    From "table" it looks down on what stands before the body too.
    """
    (_, ahead, up), (_, _, aim) = CAMERAS["plant"]
    off, high, found = scale * math.hypot(ahead, up - aim), math.atan2(up - aim, -ahead), dict[str, Place]()
    for name, (turn, rise, nearer) in TURNS.items():
        deep, at = 0.0, min(scale * aim, max(tall / 2 - LOW_AIM * scale, 0.0)) if name in LOW else scale * aim
        if name == "table":
            deep, at = scale * TABLE_AIM[0], scale * TABLE_AIM[1]
        across = nearer * off * math.cos(high + rise)
        found[name] = (across * math.sin(turn), deep - across * math.cos(turn), at + nearer * off * math.sin(high + rise)), (0.0, deep, at)
    return found


def retreat(aspect: float, narrow: float = NARROW) -> float:
    """How many times farther away a narrow window looks from."""
    return max(1.0, narrow / max(aspect, 0.2))


def away(place: tuple[Sequence[float], Sequence[float]]) -> float:
    """How far before what it looks at the eye stands."""
    return abs(place[0][1] - place[1][1]) or 1.0


def above_sheet(place: Place, back: float, drop: float, high: tuple[float, float]) -> tuple[float, float]:
    """How many times farther off, and how much lower, a stage is looked at, so that a sheet hides none of it.

    At least `back` and `drop`. `high` is the y and z of what reaches highest. The eye goes down by the drop; a point P is seen at
    u·(P − eye) / d·(P − eye), d the way it looks, u upwards in the picture.
    """
    eye, target, slope = np.array(place[0]), np.array(place[1]), math.tan(SIGHT / 2)
    d = (target - eye) / np.linalg.norm(target - eye)
    u = ((0.0, 0.0, 1.0) - d[2] * d) / math.hypot(d[0], d[1])
    for _ in range(MOST_STEPS_BACK):
        low, top = (np.array((0.0, *at)) - target - back * (eye - target) for at in (WORDS_LOW, high))
        drop = max(drop, float((SHEET_TOP * slope * (d @ low) - u @ low) / (u[2] - SHEET_TOP * slope * d[2])))
        if u @ top + u[2] * drop <= SKY_SHARE * slope * (d @ top + d[2] * drop):
            break
        back *= STEP_BACK
    return back, drop


class Viewpoint:
    """From where one tab looks at its stage. A browser is told only where a place, a window or a lesson asks for another one."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._arrived = False  # whether the browser has said that it looks from where it was told to
        self._body, self.composed = (USUAL_HALF_WIDTH, USUAL_HEIGHT), USUAL  # how far the plant reaches; it with its boards
        self._whole = self._seen_from = USUAL.place  # from where everything is seen, and from where the stage is
        self._plants = round_plant(1.0)  # from where the plant alone is
        self._aspect, self._lower, self._below = 1.0, 0.0, False

    def heard(self) -> None:
        """The browser has said from where it looks; called from the server's loop."""
        self._arrived = self._arrived or np.allclose(self._eye(), np.ravel(self._seen_from), atol=0.02)

    def camera(self, preset: str) -> None:
        """Look from one of the named places."""
        places = {**CAMERAS, "all": self._whole, **self._plants, "boards": self.composed.boards}
        self._seen_from = places.get(preset, self._whole)
        self._look()

    def begin(self, camera: tuple[float, ...] | None, preset: str | None) -> None:
        """Look from where a link asked for, else from a named place, else from where everything is seen."""
        if camera is None and preset is not None:
            self.camera(preset)
        else:
            self.look(camera)

    def look(self, camera: tuple[float, ...] | None) -> None:
        """Look from a position at a target, from where everything is seen for None."""
        self._seen_from = self._whole if camera is None else (camera[:3], camera[3:])
        for place in self._plants.values():
            if np.allclose(np.ravel(self._seen_from), np.ravel(place), atol=0.02):
                self._seen_from = place  # as in the tab that is followed: a narrow window adapts a named place in its own way
        self._look()

    def compose(self, boards: bool, charted: bool, lecture: bool, below: bool = False, body: tuple[float, float] | None = None,
                lab: bool = False) -> None:
        """Whether boards stand behind the plant: without them the whole view is nearer; whether a map lies in front; the print;
        whether a sheet lies over the lower half; how far the body reaches to either side and how high, None where it is as it was;
        whether the lab's panel of the run lies over the stage."""
        if body is not None:
            self._body = body
            self._look_at_body(body)
        self.composed = composition(*self._body, lecture, lab)
        whole, lower = self.composed.place if boards and not charted else CAMERAS["map" if charted else "bare"], LOWER * lecture
        before, self._whole = self._whole, whole
        if self._seen_from == before != whole or (lower, below) != (self._lower, self._below):
            self._lower, self._below = lower, below
            self._seen_from = whole if self._seen_from == before else self._seen_from
            self._look()

    def _look_at_body(self, body: tuple[float, float]) -> None:
        """See the plant from as many times farther off as its body is larger than usual."""
        before, self._plants = self._plants, round_plant(body_scale(body), body[1])
        for name, place in before.items():
            if self._seen_from == place != self._plants[name]:
                self._seen_from = self._plants[name]
                self._look()
                return

    def letters(self, lecture: bool) -> float:
        """How large letters at the boards are now, in stage units."""
        return letters(self._client.camera, lecture, self.composed)

    def eye(self) -> tuple[float, ...] | None:
        """Position and target as `look` takes them, None where everything is seen from the usual place."""
        now = self._eye() if self._arrived and not self._reshaped else np.ravel(self._seen_from)
        if not np.all(np.isfinite(now)) or np.allclose(now, np.ravel(self._whole), atol=0.02):
            return None
        return tuple(now.tolist())

    def _eye(self) -> np.ndarray:
        """Position and target, six numbers, of a window that needs no adapting."""
        camera, (back, drop) = self._client.camera, self._fit(self._seen_from)
        lift = np.array((0.0, 0.0, drop))
        target = np.array(camera.look_at) + lift
        return np.concatenate([target + (np.array(camera.position) + lift - target) / back, target])

    def nearness(self) -> float:
        """How far the plant is from where the stage is seen, over how far the boards are in the composed view."""
        (back, _), composed = self._fit(self._seen_from), self.composed
        whole = away(composed.place) * composed.retreat(self._aspect) + BOARDS_BEHIND
        eye, target = map(np.asarray, self._seen_from)
        return back * float(np.linalg.norm(eye - target)) / whole

    def _fit(self, place: tuple[Sequence[float], Sequence[float]]) -> tuple[float, float]:
        """How many times farther off a narrow window looks from, and how far below the target it aims: what lies over it is below."""
        composed = self.composed
        if place in (composed.place, composed.boards):
            back = composed.retreat(self._aspect)
        else:
            back = retreat(self._aspect, NARROW_PLANT if place in self._plants.values() else NARROW * FAR / away(place))
        whole = place == composed.place
        if self._below:
            back = max(back, ABOVE_BOARDS if whole else ABOVE)
            lower = (BOARDS_AIM_SHARE if whole else SHEET_AIM_SHARE) * back * away(place)
            title = composed.foot + BOARD_HEIGHT + BOARD_MARGIN + TITLE_HIGH[True]
            return above_sheet(place, back, lower, (BOARDS_BEHIND, title) if whole else (0.0, self._body[1])) if (
                whole or place in self._plants.values()) else (back, lower)
        return back, (0.0 if whole else self._lower) * back * away(place)

    def _look(self) -> None:
        self._arrived = False
        position, target = self._seen_from
        self._aspect = aspect_of(self._client.camera)
        back, drop = self._fit(self._seen_from)
        aim = np.array(target) - (0.0, 0.0, drop)
        with self._client.atomic():
            self._client.camera.up_direction = (0.0, 0.0, 1.0)
            self._client.camera.position = aim + back * (np.array(position) - np.array(target))
            self._client.camera.look_at = aim
            self._client.camera.fov = SIGHT

    @property
    def _reshaped(self) -> bool:
        """Whether the window, or a panel, has another shape than when the stage was last looked at from a named place."""
        return abs(aspect_of(self._client.camera) - self._aspect) > 0.03 * self._aspect

    def needs_resize(self, em: float) -> bool:
        """Whether `fit` has something to do; asked from the server's loop."""
        return self._reshaped

    def fit(self, em: float) -> None:
        """Look again from the last named place where the window has another shape."""
        if self._reshaped:
            self._look()
