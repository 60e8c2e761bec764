"""Words on a pole board and on a map cover neither a mark nor other words, in whatever size they are written."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laws import holds_for_all

from observer_lab.course.figures.records import MapFigure
from observer_lab.course.lesson import Board, Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.text_layout import Box, text_width
from observer_lab.page.stage.board_labels import MARK_HALF_SIZE, MARK_NAME_GAP, Place, best_place, free_place, leader_line, pole_name
from observer_lab.page.stage.body_extent import reach
from observer_lab.page.stage.map_board import NEARER, place, written
from observer_lab.page.stage.pole_boards import BOARD_HEIGHT, BOARD_WIDTH, NAME_FRAME
from observer_lab.page.stage.scene_labels import ROW_HEIGHT_EM, stagger_names
from observer_lab.page.stage.stage import FACTORS_AT, factors, place_of_words
from observer_lab.page.stage.viewpoint import CAMERAS, FAR, NARROW, SIGHT, Composition, away, composition, letters, retreat
from observer_lab.plants import MODELS

WINDOWS = {"laptop": (626, 768, False), "hall": (846, 1080, True), "small hall": (590, 720, True), "phone": (390, 844, False),
           "wide": (1400, 1080, True)}  # px of the stage across and up, and whether in large print
SIZES = (0.15, 0.2, 0.25)  # of the letters in stage units: a laptop's, a hall's, a phone's
inside = st.tuples(st.floats(-BOARD_WIDTH / 2, BOARD_WIDTH / 2), st.floats(0.0, BOARD_HEIGHT / 2))


def lay_out(names: list[tuple[float, float, str]], marks: list[tuple[float, float]], em: float) -> list[Place | None]:
    """Every name in order, as a board writes them."""
    out: list[Place | None] = []
    for x, z, words in names:
        out.append(free_place(x, z, words, em, NAME_FRAME, [p for p in out if p is not None], marks))
    return out


def covers_nothing(places: list[Place | None], marks: list[tuple[float, float]]) -> None:
    seen = [p for p in places if p is not None]
    for i, at in enumerate(seen):
        assert not any(at.meets(other) for other in seen[:i]), "two names share some area"
        assert not any(at.covers(*mark) for mark in marks), "a name lies on a mark"
        assert NAME_FRAME.left <= at.x - at.half + 1e-9 and at.x + at.half <= NAME_FRAME.right + 1e-9
        assert NAME_FRAME.bottom <= at.z - at.tall + 1e-9 and at.z + at.tall <= NAME_FRAME.top + 1e-9


def crosses(board: Board) -> tuple[list[tuple[float, float, str]], list[tuple[float, float]]]:
    """What has a name on a board, and all that stands there."""
    def at(s: complex) -> tuple[float, float]:
        s = board.hold(s)
        return ((s.real - board.re_low) / (board.re_high - board.re_low) - 0.5) * BOARD_WIDTH, s.imag / board.im_high * BOARD_HEIGHT / 2
    names = [(*at(pole), pole_name(pole, board)) for pole in board.poles if pole.imag >= 0]
    names += [(*at(pole), f"bolted {pole_name(pole, board)}") for pole in board.fixed]
    return names, [at(s) for s in (*board.poles, *board.zeros, *board.fixed)]


@given(st.lists(inside, min_size=1, max_size=8), st.sampled_from(SIZES))
def test_names_of_any_poles_cover_nothing(poles: list[tuple[float, float]], em: float) -> None:
    marks = [(x, sign * z) for x, z in poles for sign in (1, -1)]
    covers_nothing(lay_out([(x, z, "−12.3 ± 4.56j") for x, z in poles], marks, em), marks)


@given(st.lists(inside, min_size=1, max_size=4))
def test_up_to_four_pairs_are_all_named_on_a_laptop(poles: list[tuple[float, float]]) -> None:
    marks = [(x, sign * z) for x, z in poles for sign in (1, -1)]
    assert None not in lay_out([(x, z, "−12.3 ± 4.56j") for x, z in poles], marks, SIZES[0])


def test_every_lesson_opens_with_all_its_poles_named_and_nothing_covered() -> None:
    def law(lesson: Lesson) -> None:
        for board in lesson.compute(lesson.start()).boards:
            names, marks = crosses(board)
            for em in SIZES:
                places = lay_out(names, marks, em)
                covers_nothing(places, marks)
                assert em > SIZES[0] or None not in places, f"a pole of {board.id} has no name"
    holds_for_all(LESSONS.values(), law, lambda lesson: lesson.id)


def test_a_lone_name_stands_to_the_right_and_one_at_the_edge_on_the_other_side() -> None:
    lone = free_place(0.0, 0.0, "−5", 0.15, NAME_FRAME, [], [(0.0, 0.0)])
    assert (
        lone is not None
        and lone.z == 0.0
        and lone.x - lone.half == pytest.approx(MARK_HALF_SIZE + MARK_NAME_GAP)
        and leader_line(lone, 0.0, 0.0) is None
    )
    edge = free_place(BOARD_WIDTH / 2, 0.0, "−5 ± 3j", 0.15, NAME_FRAME, [], [(BOARD_WIDTH / 2, 0.0)])
    assert edge is not None and edge.x < BOARD_WIDTH / 2


@given(inside, inside)
def test_a_line_leads_from_a_far_name_to_its_mark(mark: tuple[float, float], to: tuple[float, float]) -> None:
    at = Place(*to, 0.4, 0.1)
    line = leader_line(at, *mark)
    gap = math.dist(at.nearest(*mark), mark)
    if line is None:
        assert gap < 0.25
    else:
        start, end = line
        assert math.dist(start, mark) == pytest.approx(MARK_HALF_SIZE) and end == at.nearest(*mark)


def test_a_name_beside_an_axis_and_a_way_keeps_clear_of_both() -> None:
    way = [(0.5 - 0.1 * k, 0.5) for k in range(1, 6)]
    at = best_place(0.5, 0.5, "−4 ± 5j", 0.13, NAME_FRAME, [], [(0.5, 0.5), (0.5, -0.5)], way, ((0.75, None), (None, 0.0)))
    assert at is not None and at.x + at.half <= 0.75 and at.z - at.tall >= 0.0
    assert not any(at.covers(*spot) for spot in way)


@given(inside)
def test_axes_and_ways_cost_no_mark_its_name(mark: tuple[float, float]) -> None:
    plain = free_place(*mark, "fixed mode −0.25 ± 0.487j", 0.13, NAME_FRAME, [], [mark])
    found = best_place(*mark, "fixed mode −0.25 ± 0.487j", 0.13, NAME_FRAME, [], [mark], [(0.0, 0.3)], ((0.0, None), (None, 0.0)))
    assert (plain is None) == (found is None)


def test_a_name_nearer_to_another_mark_has_a_line_to_its_own() -> None:
    at = Place(-0.4, 0.2, 0.35, 0.08)
    assert leader_line(at, 0.05, 0.0, [(0.05, 0.0)]) is None and leader_line(at, 0.05, 0.0, [(0.05, 0.0), (-0.3, 0.0)]) is not None


def test_where_there_is_no_room_there_is_no_name() -> None:
    marks = [(x / 8, z / 8) for x in range(-14, 15) for z in range(-12, 13)]
    assert free_place(0.0, 0.0, "−5 ± 3j", 0.15, NAME_FRAME, [], marks) is None


class Eye:
    """What the composed view shows of the stage: a pinhole, in heights of the window, up and to the right."""

    def __init__(self, across: int, up: int, lecture: bool, composed: Composition) -> None:
        camera: Any = SimpleNamespace(image_width=across, image_height=up)
        position, target = (np.array(each) for each in CAMERAS["map"])
        far = retreat(across / up, NARROW * FAR / away(CAMERAS["map"]))
        self.em, self._eye = letters(camera, lecture, composed), target + far * (position - target)
        ahead = (target - self._eye) / np.linalg.norm(target - self._eye)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        self._axes = np.array([right, np.cross(right, ahead), ahead])

    def at(self, point: tuple[float, float, float]) -> tuple[float, float, float]:
        """Where a point is seen, and how large one stage unit is there."""
        x, y, depth = self._axes @ (np.array(point) - self._eye)
        unit = 1 / (2 * math.tan(SIGHT / 2) * depth)
        return x * unit, -y * unit, unit

    def box(self, words: str, point: tuple[float, float, float], anchor: str, em: float) -> Box:
        """What words in letters of a size cover."""
        x, y, unit = self.at(point)
        lines = words.split("\n")
        wide, tall = max(text_width(line, em) for line in lines) * unit, 1.1 * em * unit * len(lines)
        up, across = anchor.split("-")
        left = x - wide * {"left": 0.0, "center": 0.5, "right": 1.0}[across]
        top = y - tall * {"top": 0.0, "center": 0.5, "bottom": 1.0}[up]
        return Box(left, top, left + wide, top + tall)


def test_words_on_a_map_cover_no_other_words_empty_or_computed() -> None:
    """Nor does what is said of the plant's motion lie on them or on the map."""
    def law(lesson: str, window: str, language: str, empty: bool) -> None:
        figure, body, composed = maps[lesson]
        eye = Eye(*WINDOWS[window], composed)
        figure = replace(figure, values=np.full_like(figure.values, -1 if empty else 0))
        em = eye.em * NEARER
        said = {name: eye.box(what.words, what.at, what.anchor, em) for name, what in written(figure, language, em).items()}
        assert any(name.endswith("empty") for name in said) == empty
        said["factors"] = eye.box(factors(body, language), FACTORS_AT, "bottom-right", eye.em)
        names = list(said)
        assert not [(a, b) for i, a in enumerate(names) for b in names[:i] if said[a].meets(said[b])]
        (left, far, _), (right, _, _) = eye.at(place(0.0, 1.0)), eye.at(place(1.0, 1.0))
        assert said["factors"].bottom <= far or said["factors"].left >= right or said["factors"].right <= left
        half = 0.5 * WINDOWS[window][0] / WINDOWS[window][1]
        assert all(-half < box.left and box.right < half for box in said.values())
    maps = {}
    for lesson in (lesson for lesson in LESSONS.values() if lesson.pick is not None):
        outcome = lesson.compute(lesson.start())
        assert outcome.stage is not None
        figure = next(f for f in lesson.figures(outcome) if isinstance(f, MapFigure))
        maps[lesson.id] = figure, outcome.stage.body, composition(*reach(outcome.stage))
    holds_for_all(itertools.product(maps, WINDOWS, ("en", "zh"), (True, False)), law, lambda *case: str(case))


@pytest.mark.parametrize("em", SIZES)
@given(names=st.lists(st.text("侧滑角速度 aω", min_size=1, max_size=14), min_size=1, max_size=10))
def test_names_below_a_row_of_tubes_hang_in_rows_where_they_would_meet(em: float, names: list[str]) -> None:
    placed = stagger_names([(words, (0.42 * k, 0.0, 0.13)) for k, words in enumerate(names)], em)
    boxes = [
        Box(x - em * text_width(words, 1.0) / 2, -z, x + em * text_width(words, 1.0) / 2, ROW_HEIGHT_EM * em - z)
        for words, (x, _, z) in placed
    ]
    assert not any(a.meets(b) for a, b in itertools.combinations(boxes, 2))
    assert [words for words, _ in placed] == names and placed[0][1] == (0.0, 0.0, 0.13)


@pytest.mark.parametrize("em", SIZES)
def test_names_of_rows_nearer_than_a_letter_is_high_follow_each_other_without_a_gap(em: float) -> None:
    """On a phone, where letters are large beside the plant: the fifth name is still next to its own row."""
    tall = ROW_HEIGHT_EM * em
    placed = stagger_names([("δ", (0.0, 0.0, -0.9 * tall * k)) for k in range(5)], em)
    assert [z for _, (_, _, z) in placed] == pytest.approx([-tall * k for k in range(5)])


@pytest.mark.parametrize("em", SIZES)
@pytest.mark.parametrize("force", [-3.0, 0.0, 2.0])
def test_the_words_of_an_arrow_stand_past_its_head_and_nowhere_without_one(em: float, force: float) -> None:
    """The motor of a cart is asked for twice the force that acts. Both arrows have their words, which do not meet."""
    body = MODELS["cart-pendulum"].body
    arrows = body.arrows([0.0, 0.1, 0.0, 0.0], [force, 2 * force], body.gain)
    assert [arrow.called[0]("en") for arrow in arrows if arrow.called is not None] == ["applied", "commanded"]
    boxes = []
    for arrow in arrows:
        assert arrow.called is not None
        words = arrow.called[0]("en")
        x, _, z = place_of_words(arrow, words, em)
        half = em * text_width(words, 1.0) / 2
        if force == 0.0:
            assert z < -1
            continue
        assert (x - arrow.head[0]) * force > 0 and abs(x - arrow.head[0]) > half
        boxes.append(Box(x - half, -z, x + half, em - z))
    assert not any(a.meets(b) for a, b in itertools.combinations(boxes, 2))
    assert all(arrow.called is None for arrow in body.arrows([0.0, 0.1, 0.0, 0.0], [force], body.gain))
