"""Draw the stage: floor, light, plant, ghost, force arrows and error lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import viser

from ...colours import COLOURS, palette, rgb
from ...course.error_window import sample_at
from ...course.lesson import Stage
from ...course.pinned_designs import Ghost
from ...plants.bodies.body import ASKED, BENCH, Arrow, Body, Vector
from ...text import label_in_language
from ..charts.text_layout import fold_lines, text_width
from ..viser_private import viser_internals
from ..viser_private.stage_frames import Frame, Value, changed_values, flatten_segments
from ..words import phrases
from .body_extent import front_corner
from .lighting import PLANT, light_up
from .part_names import ErrorMarkLines, PartNames
from .pinned_ghosts import PinGhosts
from .pulling_hand import Pulled, PullingHand
from .scene_labels import SceneLabels, colour_labels, stagger_names
from .solids import Solids
from .trails import ErrorLines

FACTORS = 10.0  # letters: a line with what is exaggerated is no longer
FACTORS_AT = (2.9, -0.6, 0.5)  # where the end of its last line stands, where a map lies in front
FACTORS_GAP = 0.1  # stage units elsewhere between it and the front of the plant's base
FORCES = "/forces"  # the node of the arrows of forces, and how those of other roles begin
THICK, THIN = (0.035, 0.09, 0.16), (0.014, 0.05, 0.13)  # stage units: of shaft, head and point; what is asked for is thin
MIN_ARROW_LENGTH = 0.05  # stage units: shorter arrows are not drawn
LARGEST_CLOUD, ONE_OF_SEVERAL = 0.9, 0.5  # stage units: of a cloud that stands alone, and of one of several about one body
UPRIGHT = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # pictures lie flat until they are turned, then the last row is above
BY_NIGHT = 0.66  # of the light of a picture, in the dark
INSIDE = 0.985  # the ghost is drawn this much smaller: where it agrees, it vanishes into the body
Place = tuple[int, tuple[int, ...]]  # the sample of the run that is shown, and of each pin's run
BELOW: Vector = (0.0, 0.0, -9.0)
WORDS_PAST_EM, LEAST_CALLED = 0.6, 0.15  # letters from the head of an arrow to its words; stage units: a shorter arrow has none


def factors(body: Body, language: str) -> str:
    """How many times motion and arrows of a body are exaggerated, nothing where they are not; in lines, to stand beside it."""
    times = ((phrases.EXAGGERATED, body.gain), (phrases.LONGER, body.forces))
    return fold_lines(
        phrases.AND(language).join(phrase.format(factor=factor)(language) for phrase, factor in times if factor != 1), FACTORS
    )


def factors_at(stage: Stage, charted: bool) -> Vector:
    """Where these words end: on the right, on the floor before the base, or above it where a map lies in front."""
    if charted:
        return FACTORS_AT
    x, y = front_corner(stage)
    return x, y - FACTORS_GAP, 0.0


class StageView:
    """One tab's stage. Sends only what changed since the last pose. With `trails` its ghost leaves some while the tab is not `calm`."""

    def __init__(self, client: viser.ClientHandle, trails: bool = False, pulled: Pulled | None = None,
                 nearness: Callable[[], float] = lambda: 1.0) -> None:
        """`pulled` is called when a hand pulls the plant; without it none can. `nearness` gives the distance from the eye to the plant
        over that to the boards in the usual view: the letters of both are as large on the screen.
        """
        self.nearness = nearness
        self._client, self._trails, self._pulled = client, trails, pulled
        self._hand: PullingHand | None = None
        self._calm, self._dark = False, False
        self._scene = client.scene
        self._body: Body | None = None
        self._solid, self._ghost = self._parts()
        self._clouds: list[viser.IcosphereHandle] = []
        self._names: list[viser.LabelHandle] = []
        self._note, self._called = list[viser.LabelHandle](), list[tuple[str, Vector]]()
        self._letters = SceneLabels(self._scene, 1.0)
        self._pins, self._part_names = PinGhosts(self._scene, self._letters), PartNames(self._scene, self._letters)
        self._errors: ErrorLines | None = None
        self._marks: ErrorMarkLines | None = None
        self._arrows: dict[str, str] = {}  # the node of the arrows of each role
        self._called_arrows: dict[int, viser.LabelHandle] = {}  # the words of those that have some
        self._drawn: list[viser.SceneNodeHandle] = []  # these nodes
        self._picture: viser.ImageHandle | None = None
        self._stage: Stage | None = None
        self._frame: Frame = {}  # where everything was sent to last
        self._posed: tuple[Place, Stage | None] | None = None
        self.built: object = None  # another one whenever a place may mean another frame
        self.charted = False  # whether a map lies in front

    def furnish(self, dark: bool) -> None:
        """Floor, light, background and the default camera of an empty stage."""
        scene, self._dark = self._scene, dark
        colour_labels(self._client, dark)
        scene.set_up_direction("+z")
        light_up(scene, dark)

    def build(self, stage: Stage | None, language: str, em: float) -> None:
        """Put a plant on the stage, instead of the last one."""
        self.forget()
        self.built = object()
        self._solid, self._ghost = self._parts()
        self._clouds, self._names, self._note, self._called, self._drawn = [], [], [], [], []
        self._hand = self._picture = self._marks = None
        self._stage, self._body = stage, stage.body if stage is not None else None
        em *= self.nearness()
        self._letters = SceneLabels(self._scene, em)
        self._pins, self._part_names = PinGhosts(self._scene, self._letters), PartNames(self._scene, self._letters)
        if stage is None:
            return
        body = stage.body
        ghostly = COLOURS[body.ghost]
        light = BY_NIGHT if self._dark else 1.0
        self._picture = None if stage.picture is None else self._scene.add_image(
            "/picture", (light * stage.picture.image[::-1]).astype(np.uint8), *stage.picture.size, format="jpeg",
            cast_shadow=False, receive_shadow=False, position=stage.picture.place, wxyz=UPRIGHT)
        for part in body.parts:
            if not part.unseen:
                self._solid.add(part, palette(self._dark)["bench"] if part.colour == BENCH else part.colour, part.opacity)
            if part.twin and stage.xhat is not None:
                self._ghost.add(part, ghostly, 0.55 if self._dark else 0.36, edged=part.edged)
        self._hand = PullingHand(self._scene, body.gain)
        if self._pulled is not None:
            self._hand.listen([grip for grip, _ in stage.held], self._solid.nodes, self._pulled)
        self._hand.take(stage.held)
        none = np.array(_segments([]), np.float32).reshape(-1, 2, 3)
        first = () if stage.u is None else body.arrows(stage.x[0].tolist(), stage.u[0].tolist(), body.gain)
        self._arrows = {role: FORCES if role == "force" else f"{FORCES}-{role}" for role in ("force", *sorted({a.role for a in first}))}
        for role, node in self._arrows.items():
            shaft, head, point = THIN if role == ASKED else THICK
            self._drawn.append(self._scene.add_arrows(node, none, rgb(COLOURS["force" if role == ASKED else role]), shaft_radius=shaft,
                                                      head_radius=head, head_length=point))
        self._called_arrows = {k: self._letters.write(f"/arrow-words/{k}", label_in_language(arrow.called[0], language), BELOW,
                                                      "center-center") for k, arrow in enumerate(first) if arrow.called is not None}
        self._drawn += self._called_arrows.values()
        self._errors = ErrorLines(self._scene, stage, self._trails, self._dark)
        self._clouds = [] if stage.spread is None or stage.xhat is None else [
            self._scene.add_icosphere(f"/spread/{i}", 1.0, rgb(ghostly), subdivisions=4, opacity=0.24, side="back", cast_shadow=False,
                                      receive_shadow=False)
            for i, _ in enumerate(body.anchors(stage.xhat[0].tolist(), body.gain))]
        said = factors(body, language)
        self._letters.write("/factor", said, factors_at(stage, self.charted), "bottom-right" if self.charted else "top-right",
                            visible=bool(said))
        self._say(stage, language)
        self._called = [(label_in_language(words, language), place) for words, place in body.labels]
        if body.marks is not None and stage.xhat is not None:
            self._marks = ErrorMarkLines(self._scene, self._letters, body.marks(stage.x[0].tolist(), stage.xhat[0].tolist(), body.gain),
                                         language)
        self._names = [self._letters.write(f"/name/{i}", *name, "top-center") for i, name in enumerate(stagger_names(self._called, em))]

    def needs_resize(self, em: float) -> bool:
        """Whether `fit` has something to do; asked from the server's loop."""
        return self._letters.misfit(em * self.nearness())

    def fit(self, em: float) -> None:
        """Write in letters as large as the window asks for."""
        em *= self.nearness()
        if self._letters.resize(em):
            for label, (_, place) in zip(self._names, stagger_names(self._called, em), strict=True):
                label.position = place

    def _say(self, stage: Stage, language: str) -> None:
        """What would surprise in this run, in lines in front of the plant."""
        said = "\n".join(line(language) for line in stage.note)
        if said != "".join(label.text for label in self._note):
            for label in self._note:
                self._letters.remove(label)
            self._note = [self._letters.write("/note", said, (0.0, -1.4, 0.03), "top-center")] if said else []

    def _parts(self) -> tuple[Solids, Solids]:
        """The plant's parts and its ghost's, none yet."""
        return Solids(self._scene, PLANT), Solids(self._scene, "/ghost", INSIDE, coloured=False)

    def show(self, stage: Stage | None, language: str, em: float) -> None:
        """Take a new run; another plant is put on the stage in place of the last one."""
        if (stage.body if stage is not None else None) is not self._body:
            lone = filter(None, (self._hand, self._picture, self._marks))
            for part in (self._solid, self._ghost, *self._clouds, *self._names, *self._note, *self._drawn, *lone):
                part.remove()
            self._pins.clear()
            self._part_names.clear()
            self.build(stage, language, em)
        elif stage is not None and self._errors is not None and stage is not self._stage:
            self._errors.take(stage)
            self._say(stage, language)
        if self._hand is not None and stage is not None and stage is not self._stage:
            self._hand.take(stage.held)
        self._stage, self.built = stage, object()

    def calm(self, calm: bool) -> None:
        """Whether nothing is to move by itself; then a ghost leaves no trail."""
        if calm != self._calm:
            self._calm, self.built = calm, object()
            self.forget()

    def show_pin_ghosts(self, ghosts: Sequence[Ghost]) -> None:
        """The ghosts of pinned designs that are wanted beside the present one."""
        changed_pins = self._pins.show(ghosts, self._body)
        if changed_pins:
            self.forget()
        if changed_pins or ghosts:  # the same pins may run otherwise
            self.built = object()

    def name_parts(self, named: bool, language: str) -> None:
        """Whether the plant's parts have their names beside them."""
        stage = self._stage
        if self._part_names.show(self._body if named else None, stage is not None and stage.xhat is not None, language, self._dark):
            self.built = object()
            self.forget()

    def forget(self) -> None:
        """Send the next pose whole: what the browser shows is not known."""
        self._frame, self._posed = {}, None

    def pose(self, t: float) -> None:
        """Move every part to time t of the run."""
        place = self.place_at(t)
        if place is None or self._posed == (place, self._stage):
            return
        before, self._frame, self._posed = self._frame, self.frame_at(place), (place, self._stage)
        viser_internals.move(self._scene, changed_values(before, self._frame))

    def follow(self, stage: Stage) -> None:
        """Move every part to the end of another run of the same body; words and hands stay as they are."""
        if stage.body is not self._body:
            return
        if self._errors is not None:
            self._errors.take(stage)
        self._stage, self.built = stage, object()
        self.pose(float(stage.t[-1]))

    def place_at(self, t: float) -> Place | None:
        """Which samples of the run and of the pins' runs are shown at time t, None on an empty stage."""
        return None if self._stage is None or self._body is None else (sample_at(self._stage.t, t), self._pins.place_at(t))

    def frame_at(self, place: Place | None) -> Frame:
        """Where everything stands at these samples."""
        stage, body, frame = self._stage, self._body, Frame()
        if stage is None or body is None or place is None:
            return frame
        index, samples = place
        x = stage.x[index].tolist()
        poses = ghost = body.pose(x, body.gain)
        self._solid.place(poses, frame)
        if self._hand is not None:
            self._hand.place(float(stage.t[index]), x, frame)
        if stage.xhat is not None and self._ghost:
            xhat = stage.xhat[index].tolist()
            ghost = body.pose(xhat, body.gain)
            self._ghost.place(ghost, frame)
            believed = body.anchors(xhat, body.gain)
            if self._errors is not None:
                self._errors.place(index, body.anchors(x, body.gain), believed, self._calm, frame)
            if self._marks is not None and body.marks is not None:
                self._marks.place(body.marks(x, xhat, body.gain), frame)
            if stage.spread is not None:
                self._cloud(believed, float(stage.spread[index]), frame)
        if stage.u is not None:
            arrows = body.arrows(x, stage.u[index].tolist(), body.gain)
            for role, node in self._arrows.items():
                drawn = [(a.tail, a.head) for a in arrows if a.role == role and math.dist(a.tail, a.head) > MIN_ARROW_LENGTH]
                frame[node, "points"] = _segments(drawn)
            for k, label in self._called_arrows.items():
                frame[label.name, "position"] = place_of_words(arrows[k], label.text, self._letters.em)
        self._pins.place(samples, frame)
        self._part_names.place(poses, ghost, frame)
        return frame

    def _cloud(self, believed: Sequence[Vector], radius: float, frame: Frame) -> None:
        """How unsure the estimate is: a translucent ball about each anchor, never larger than the stage can hold."""
        size = min(max(radius, 1e-3), LARGEST_CLOUD if len(believed) == 1 else ONE_OF_SEVERAL)
        for handle, place in zip(self._clouds, believed, strict=True):
            frame[handle.name, "position"] = place
            frame[handle.name, "scale"] = (size, size, size)


def place_of_words(arrow: Arrow, words: str, em: float) -> Vector:
    """Where the middle of an arrow's words is, past its head: below the floor where it is short."""
    long = math.dist(arrow.tail, arrow.head)
    if arrow.called is None or long <= LEAST_CALLED:
        return BELOW
    across, ahead, up = ((head - tail) / long for tail, head in zip(arrow.tail, arrow.head, strict=True))
    off = em * (0.5 * abs(up) + text_width(words, 0.5) * abs(across) + WORDS_PAST_EM)
    return arrow.head[0] + off * across, arrow.head[1] + off * ahead, arrow.head[2] + off * up + arrow.called[1]


def _segments(pairs: list[tuple[Vector, Vector]]) -> Value:
    """Start and end points; viser keeps a node alive only if it has at least one, so one lies below the floor."""
    return flatten_segments([*pairs, (BELOW, BELOW)])
