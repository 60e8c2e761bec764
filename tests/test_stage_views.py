"""From where a scene looks at its stage, the plant hides nothing of the boards, all is in sight, and little of the picture is empty."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import nullcontext
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple
from unittest.mock import MagicMock

import numpy as np
from laws import holds_for_all

from observer_lab.course.figures.records import MapFigure
from observer_lab.course.lesson import Board, Lesson, Stage
from observer_lab.course.scenes import Scene, entry_values
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.text_layout import text_width
from observer_lab.page.stage.body_extent import body_corners, reach
from observer_lab.page.stage.map_board import NEARER, place, written
from observer_lab.page.stage.part_names import WORDS_SIZE, PartNames, _anchor, _end_of_line
from observer_lab.page.stage.pole_boards import BOARD_HEIGHT, BOARD_WIDTH, board_contains
from observer_lab.page.stage.scene_labels import stagger_names
from observer_lab.page.stage.stage import StageView, factors, factors_at
from observer_lab.page.stage.viewpoint import BOARD_MARGIN, SIGHT, Viewpoint, board_place
from observer_lab.plants import MODELS
from observer_lab.text import Text, label_in_language, languages

CANVASES = {"laptop": (929, 768), "small laptop": (870, 720), "wall": (1306, 1080), "hall": (1306, 1080)}  # px of the guide's stage
LAB_CANVASES = ((618, 768), (579, 720), (775, 900))  # px of the stage between the lab's columns
RUN_PANEL = 0.222  # of the stage's height that the lab's panel of the run takes
IN_LARGE_PRINT = "hall"
RUN_BAR = 0.1  # of the canvas' height, at its foot: the row of the run
MOMENTS = 12
LINE, RIM = 1.2, 0.015  # height of a line over its letters; of half the canvas' height: so much of two labels may lie on one another
LEAST_FILLED = 0.57  # of the canvas' height or width: what stands on the stage, and the map in front of it
ABOVE_SHEET = 0.17  # of half the canvas' height, above its middle: the upper edge of a sheet with the row of the run
LEAST_PLANT = 0.48  # of the canvas' width, beside or below boards
LEAST_LETTER = 0.0168  # of the canvas' height: a letter on a board, 12.9 px of 768


class Camera(SimpleNamespace):
    """A browser's camera that goes where it is told."""

    def __init__(self, size: tuple[int, int]) -> None:
        super().__init__(image_width=size[0], image_height=size[1], position=(0.0, 0.0, 0.0), look_at=(0.0, 0.0, 0.0))


def seen(camera: Any, points: np.ndarray) -> np.ndarray:
    """Where points are seen (k, 2): right and up, the canvas from −1 to 1 on its height, and on its width times its shape."""
    eye, ahead = np.array(camera.position), np.array(camera.look_at) - np.array(camera.position)
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    away = points - eye
    return np.stack([away @ right, away @ np.cross(right, ahead)], axis=1) / (away @ ahead)[:, None] / math.tan(SIGHT / 2)


@cache
def opened(id: str) -> tuple[bool, tuple[float, float]]:
    """Whether a lesson opens with boards, and how far its body reaches then."""
    outcome = LESSONS[id].compute(LESSONS[id].start())
    assert outcome.stage is not None
    return bool(outcome.boards), reach(outcome.stage)


class Word(NamedTuple):
    """Words on the stage in each language, where, which side of them is there, and how much larger than usual they are."""

    said: tuple[str, ...]
    at: tuple[float, float, float]
    anchor: str
    size: float = 1.0


class OnStage(NamedTuple):
    """A scene with its boards and its map, the corners of the body in its run, where the words about its size end, all other words, and
    the names of its parts."""

    lesson: Lesson
    scene: Scene
    boards: tuple[Board, ...]
    map: MapFigure | None
    body: np.ndarray
    words: np.ndarray
    named: tuple[Word, ...]
    parts: tuple[str, ...]


def looked_at(case: OnStage, canvas: str) -> Any:
    """The camera of a scene in a canvas."""
    return seen_from(case, canvas)[0]


def seen_from(case: OnStage, canvas: str) -> tuple[Any, Viewpoint]:
    """The same, with the viewpoint that has put it there."""
    camera, (boards, body) = Camera(CANVASES[canvas]), opened(case.lesson.id)
    client: Any = SimpleNamespace(camera=camera, atomic=nullcontext)
    view, charted = Viewpoint(client), case.map is not None
    view.compose(boards or charted, charted, canvas == IN_LARGE_PRINT, body=body)
    view.camera(case.scene.view)
    return camera, view


def board_corners(side: str, foot: float, em: float, shown: Collection[Board] | None = None) -> np.ndarray:
    """The corners of a board with its title and the numbers below it, seen from the front (4, 3)."""
    (x, y), turn = board_place(side, shown)
    half, top = BOARD_WIDTH / 2 + BOARD_MARGIN, foot + BOARD_HEIGHT + BOARD_MARGIN + 0.06 + 1.2 * em
    return np.array([[x + a * half * math.cos(turn), y + a * half * math.sin(turn), z]
                     for a in (-1, 1) for z in (foot - 0.02 - 0.9 * em, top)])


def map_corners(figure: MapFigure, em: float) -> np.ndarray:
    """The corners of a map in front of the stage, and where its words hang (k, 3)."""
    words = written(figure, "en", em * NEARER).values()
    return np.array([*(place(x, y) for x in (0, 1) for y in (0, 1)), *(each.at for each in words)])


def _words(stage: Stage, charted: bool) -> np.ndarray:
    return np.array([factors_at(stage, charted)] if factors(stage.body, "en") else []).reshape(-1, 3)


def _named(stage: Stage, scene: Scene, first: bool) -> tuple[Word, ...]:
    """The names on the stage, those of the parts in the first scene alone, at the scene's moment."""
    k = int(np.searchsorted(stage.t, (scene.moment or 0.0) * stage.t[-1]).clip(0, len(stage.t) - 1))
    x, body = stage.x[k].tolist(), stage.body
    xhat = x if stage.xhat is None else stage.xhat[k].tolist()
    poses, ghost = body.pose(x, body.gain), body.pose(xhat, body.gain)

    def said(words: Text | str) -> tuple[str, ...]:
        return tuple(label_in_language(words, code) for code in languages())

    found = [Word(said(words), at, "top-center") for words, at in body.labels]
    if stage.xhat is not None and body.marks is not None:
        found += [Word(said(words), at, anchor, WORDS_SIZE) for words, at, anchor in body.marks(x, xhat, body.gain).words if at[2] > 0]
    for name in body.names if first else ():
        there, away_by = _end_of_line(name, ghost if name.ghost else poses), name.away
        found.append(Word(said(name.words), (there[0] + away_by[0], there[1] + away_by[1], there[2] + away_by[2]), _anchor(away_by)))
    return tuple(found)


@cache
def scenes_on_stage() -> tuple[OnStage, ...]:
    """Every scene of every path that has a stage, as it is entered."""
    found = []
    for lesson in LESSONS.values():
        for k, scene in enumerate(lesson.path):
            outcome = lesson.compute(lesson.apply(lesson.start(), entry_values(lesson.path, k, lesson.start())))
            if outcome.stage is not None:
                boards = tuple(board for board in outcome.boards if board.id in scene.boards)
                named = [f for f in lesson.figures(outcome) if f.id in scene.figures] if lesson.pick is not None else []
                maps = [f for f in named if isinstance(f, MapFigure)]
                found.append(OnStage(lesson, scene, boards, next(iter(maps), None), body_corners(outcome.stage, MOMENTS),
                                     _words(outcome.stage, bool(maps)), _named(outcome.stage, scene, k == 0),
                                     tuple(part.name for part in outcome.stage.body.parts)))
    return tuple(found)


def name(case: OnStage, canvas: str) -> str:
    return f"{case.lesson.id} {case.scene.id}, {canvas}"


def test_a_plant_hides_neither_the_boards_of_a_scene_nor_the_numbers_below_them() -> None:
    def law(case: OnStage, canvas: str) -> None:
        camera, view = seen_from(case, canvas)
        body = seen(camera, case.body)
        for board in case.boards:
            em = view.letters(canvas == IN_LARGE_PRINT)
            corners = seen(camera, board_corners(board.side, view.composed.foot, em, case.boards))
            before = body[(body[:, 0] > corners[:, 0].min()) & (body[:, 0] < corners[:, 0].max())]
            assert before[:, 1].max(initial=-1.0) <= corners[:, 1].min() + 0.01, f"{board.id} is hidden"
    holds_for_all([case for case in itertools.product(scenes_on_stage(), CANVASES) if case[0].boards], law, name)


def test_all_that_stands_on_the_stage_is_in_sight_above_the_row_of_the_run_and_fills_the_picture() -> None:
    def law(case: OnStage, canvas: str) -> None:
        (camera, view), (across, up) = seen_from(case, canvas), CANVASES[canvas]
        em, foot = view.letters(canvas == IN_LARGE_PRINT), view.composed.foot
        stood = [board_corners(board.side, foot, em, case.boards) for board in case.boards]
        points = np.concatenate([seen(camera, case.body), *(seen(camera, each) for each in stood),
                                 *([] if case.map is None else [seen(camera, map_corners(case.map, em))])])
        low, high = points.min(axis=0), points.max(axis=0)
        assert (seen(camera, case.words)[:, 0] <= across / up).all(), "the words about its size are cut"
        assert -across / up <= low[0] and high[0] <= across / up, f"cut at a side: {low[0]:.2f} to {high[0]:.2f}"
        assert low[1] >= 2 * RUN_BAR - 1 and high[1] <= 1, f"cut above or below: {low[1]:.2f} to {high[1]:.2f}"
        wide, tall = (high - low) / 2 / (across / up, 1.0)
        assert max(wide, tall) >= LEAST_FILLED, f"a small picture: {wide:.2f} of the width, {tall:.2f} of the height"
    holds_for_all(itertools.product(scenes_on_stage(), CANVASES), law, name)


def test_in_the_lab_plant_and_boards_are_in_sight_above_the_panel_of_the_run() -> None:
    def law(id: str, canvas: tuple[int, int]) -> None:
        camera, (boards, body) = Camera(canvas), opened(id)
        outcome = LESSONS[id].compute(LESSONS[id].start())
        assert outcome.stage is not None
        client: Any = SimpleNamespace(camera=camera, atomic=nullcontext)
        view = Viewpoint(client)
        view.compose(boards, False, False, body=body, lab=True)
        view.camera("all")
        corners = [board_corners(board.side, view.composed.foot, view.letters(False)) for board in outcome.boards]
        points = np.concatenate([seen(camera, body_corners(outcome.stage, MOMENTS)), *(seen(camera, each) for each in corners)])
        low, high = points.min(axis=0), points.max(axis=0)
        assert low[1] >= 2 * RUN_PANEL - 1 and high[1] <= 1, f"cut above or below: {low[1]:.2f} to {high[1]:.2f}"
        assert max(-low[0], high[0]) <= canvas[0] / canvas[1], f"cut at a side: {low[0]:.2f} to {high[0]:.2f}"
    with_maps = {case.lesson.id for case in scenes_on_stage() if case.map is not None}
    holds_for_all([(id, canvas) for id in LESSONS if id not in with_maps and LESSONS[id].compute(LESSONS[id].start()).stage is not None
                   for canvas in LAB_CANVASES], law, lambda id, canvas: f"{id}, {canvas}")


def test_a_scene_begins_with_its_poles_on_its_boards() -> None:
    def law(case: OnStage) -> None:
        outside = [(board.id, pole) for board in case.boards for pole in (*board.poles, *board.fixed) if not board_contains(board, pole)]
        assert outside == []
    holds_for_all([(case,) for case in scenes_on_stage() if case.boards], law, lambda case: f"{case.lesson.id} {case.scene.id}")


def test_a_board_stands_in_the_middle_where_a_scene_shows_it_alone() -> None:
    for side in ("left", "right"):
        (x, _), turn = board_place(side, ["observer"])
        assert (x, turn) == (0.0, 0.0)
        assert board_place(side, None) == board_place(side, ["controller", "observer"]) and abs(board_place(side, None)[0][0]) > 1.0


def test_letters_on_a_board_are_more_than_eleven_pixels_of_a_laptop_in_guide_and_lab() -> None:
    for size in (*CANVASES.values(), (626, 768)):
        for body in {opened(id)[1] for id in LESSONS}:
            camera: Any = Camera(size)
            client: Any = SimpleNamespace(camera=camera, atomic=nullcontext)
            view = Viewpoint(client)
            view.compose(True, False, False, body=body)
            view.camera("all")
            foot = view.composed.foot
            unit = seen(camera, np.array([[0.0, 1.5, foot], [1.0, 1.5, foot]]))
            assert view.letters(False) * (unit[1, 0] - unit[0, 0]) / 2 >= LEAST_LETTER, (size, body)


def test_the_plant_of_a_scene_with_boards_is_as_large_as_the_boards_leave_room_for() -> None:
    """It takes about half of the picture's width, or all that a wide or high body and its boards leave of it."""
    def law(case: OnStage, canvas: str) -> None:
        camera, (across, up) = looked_at(case, canvas), CANVASES[canvas]
        body = seen(camera, case.body)
        assert np.ptp(body[:, 0]) / 2 / (across / up) >= LEAST_PLANT
    holds_for_all([case for case in itertools.product(scenes_on_stage(), CANVASES) if case[0].boards and case[0].map is None], law, name)


def test_letters_beside_the_plant_are_as_large_as_those_of_the_boards_wherever_a_scene_looks_from() -> None:
    def law(case: OnStage, canvas: str) -> None:
        camera, view = seen_from(case, canvas)
        letter = view.letters(False) * view.nearness() * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]) + (0.0, 0.0, 0.3)
        across = seen(camera, letter)[:, 0]
        assert 0.9 * LEAST_LETTER <= (across[1] - across[0]) / 2 <= 1.35 * LEAST_LETTER
    holds_for_all(itertools.product(scenes_on_stage(), CANVASES), law, name)


def test_what_is_unseen_is_sent_as_the_estimate_alone() -> None:
    """A pole in fog: no browser gets to know where it is."""
    lesson, sent = LESSONS["saturation"], {}
    for fog in (False, True):
        client = MagicMock()
        view = StageView(client)
        view.build(lesson.compute(lesson.apply(lesson.start(), {"fog": fog})).stage, "en", 0.1)
        calls = [call for call in client.scene.method_calls if call.args and str(call.args[0]).startswith(("/plant/", "/ghost/"))]
        sent[fog] = {call.args[0] for call in calls}
    assert {"/plant/pole", "/plant/ball"} <= sent[False] and not any(name.startswith("/plant/fog") for name in sent[False])
    assert not {"/plant/pole", "/plant/ball"} & sent[True] and {"/ghost/pole", "/ghost/ball", "/plant/cart", "/plant/fog 0"} <= sent[True]


def test_a_ghost_has_its_name_only_where_it_stands_apart_from_the_plant() -> None:
    body = next(model.body for model in MODELS.values() if any(each.ghost for each in model.body.names))
    name = next(each for each in body.names if each.ghost)
    names, frame = PartNames(MagicMock(), MagicMock()), dict[tuple[str, str], Any]()
    names.show(body, True, "en", False)
    here = body.pose([0.0] * 12, body.gain)
    place = here[name.part].position
    apart = {**here, name.part: replace(here[name.part], position=(place[0] + 1.0, place[1], place[2]))}
    for ghost, seen in ((here, False), (apart, True)):
        names.place(here, ghost, frame)
        heights = np.asarray(frame["/named/lines", "points"], dtype=float).reshape(-1, 2, 3)[: len(body.names), 0, 2]
        assert (heights > -1.0).sum() == len(body.names) - (not seen)


def _boxes(case: OnStage, canvas: str) -> Iterator[tuple[str, np.ndarray]]:
    """Each word on a stage in each language with where it is seen: left, low, right, high, the canvas from −1 to 1 on its height."""
    camera, view = seen_from(case, canvas)
    em, eye = view.letters(canvas == IN_LARGE_PRINT) * view.nearness(), np.array(camera.position)
    ahead = np.array(camera.look_at) - eye
    for word in case.named:
        letter = em * word.size / math.tan(SIGHT / 2) / ((np.array(word.at) - eye) @ ahead / np.linalg.norm(ahead))
        (x, y), = seen(camera, np.array([word.at]))
        high = y + LINE * letter * {"top": 0.0, "center": 0.5, "bottom": 1.0}[word.anchor.partition("-")[0]]
        for said in word.said:
            wide = letter * text_width(said, 1.0)
            left = x - wide * {"left": 0.0, "center": 0.5, "right": 1.0}[word.anchor.partition("-")[2]]
            yield said, np.array([left, high - LINE * letter, left + wide, high])


def test_no_two_parts_on_a_stage_have_one_name() -> None:
    """The second would take the place of the first, and a published page, which keeps its scene on a tape, cannot be made."""
    def law(case: OnStage) -> None:
        assert [part for part, count in Counter(case.parts).items() if count > 1] == []
    holds_for_all([(case,) for case in scenes_on_stage()], law, lambda case: f"{case.lesson.id} {case.scene.id}")


def test_what_is_written_on_a_stage_is_wholly_in_sight() -> None:
    """In the letters of the window, in each language, from where the scene looks; the row of the run hides none of it."""
    def law(case: OnStage, canvas: str) -> None:
        across, up = CANVASES[canvas]
        for said, (left, low, right, high) in _boxes(case, canvas):
            assert -across / up <= left and right <= across / up, f"{said}: {left * up / 2:.0f} to {right * up / 2:.0f} px"
            assert -1 + 2 * RUN_BAR - (high - low) <= low and high - (high - low) / 2 <= 1, f"{said}: {high:.2f} up"
    holds_for_all(itertools.product(scenes_on_stage(), CANVASES), law, name)


def test_no_words_on_a_stage_lie_on_others() -> None:
    """Names that hang at one place are moved apart by the stage itself; of all others at most a rim touches."""
    def law(case: OnStage, canvas: str) -> None:
        boxes, count = list(_boxes(case, canvas)), len(languages())
        for k in range(count):
            for (one, a), (other, b) in itertools.combinations(boxes[k::count], 2):
                common = np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])
                assert (common <= RIM).any(), f"{one} and {other}: {common[0]:.3f}, {common[1]:.3f}"
    holds_for_all(itertools.product(scenes_on_stage(), CANVASES), law, name)


def test_a_sheet_hides_no_word_of_the_stage_on_a_phone_and_half_a_row_on_a_tablet() -> None:
    """Names that meet hang below each other there, as the stage hangs them. On a tablet boards fill what the sheet leaves."""
    def law(case: OnStage, size: tuple[int, int], most: float) -> None:
        camera, (boards, body) = Camera(size), opened(case.lesson.id)
        client: Any = SimpleNamespace(camera=camera, atomic=nullcontext)
        view, charted = Viewpoint(client), case.map is not None
        view.compose(boards or charted, charted, False, below=True, body=body)
        view.camera(case.scene.view)
        em = view.letters(False) * view.nearness()
        hung = [word for word in case.named if word.anchor == "top-center" and word.size == 1.0]
        for k, _ in enumerate(languages()):
            names = stagger_names([(word.said[k], word.at) for word in hung], em)
            for said, at in (*((said, (x, y, z - LINE * em)) for said, (x, y, z) in names),
                             *((word.said[k], word.at) for word in case.named if word not in hung)):
                (_, low), = seen(camera, np.array([at]))
                assert low >= ABOVE_SHEET - most, f"{said}: {low:.2f}"
    cases = [case for case in scenes_on_stage() if case.map is None]
    holds_for_all(((case, size, most) for case in cases for size, most in (((390, 844), -0.03), ((820, 1180), 0.02))
                   if size[0] < 400 or case.scene.view != "all"), law,
                  lambda case, size, _: f"{case.lesson.id} {case.scene.id} {size}")


def test_boards_and_their_plant_are_in_sight_above_a_sheet() -> None:
    """On a phone and on a tablet that is held upright the sheet leaves the upper two fifths."""
    def law(case: OnStage, size: tuple[int, int]) -> None:
        camera = Camera(size)
        client: Any = SimpleNamespace(camera=camera, atomic=nullcontext)
        view = Viewpoint(client)
        view.compose(True, False, False, below=True, body=opened(case.lesson.id)[1])
        view.camera("all")
        em, foot = view.letters(False), view.composed.foot
        stood = [board_corners(board.side, foot, em, case.boards) for board in case.boards]
        points = np.concatenate([seen(camera, case.body), *(seen(camera, each) for each in stood)])
        (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
        assert high <= 1.0 and low >= ABOVE_SHEET and max(-left, right) <= size[0] / size[1], f"{left:.2f} {right:.2f} {low:.2f} {high:.2f}"
    cases = [case for case in scenes_on_stage() if case.boards and case.map is None]
    holds_for_all(itertools.product(cases, ((390, 844), (820, 1180))), law, lambda case, size: f"{case.lesson.id} {case.scene.id} {size}")
