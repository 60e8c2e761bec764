"""What is true of every path: few words, few things in sight, every action can be done, and forth and back shows the same."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import product

import pytest
from fakes import FakeView
from laws import each, holds_for_all

from observer_lab.course.figures.records import LineFigure, PlaneFigure
from observer_lab.course.guiding.predictions import prediction_of
from observer_lab.course.knobs import ByHand, Choice, Poles
from observer_lab.course.lesson import Board, Lesson
from observer_lab.course.scenes import (
    MAX_FIGURES,
    MAX_KNOBS,
    MAX_TEXT_WORDS,
    MAX_TITLE_WORDS,
    Choose,
    Goal,
    Move,
    Press,
    Question,
    Read,
    Scene,
    Solve,
    entry_values,
    fill_numbers,
    minutes_of,
    places_of,
)
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import typed_decimals
from observer_lab.page.guide.guide_panel import BUTTONS
from observer_lab.page.guide.scene_card import MARKS, card_html, moving_lines, verdict_html
from observer_lab.page.stage.pole_boards import BOARD_HEIGHT, BOARD_WIDTH
from observer_lab.session.commands.commands import Kick, Play, SetKnobs
from observer_lab.session.commands.guide import ChooseOption, GoToScene, TurnScene
from observer_lab.session.session import Session
from observer_lab.text import languages

PATHS = {id: lesson for id, lesson in LESSONS.items() if lesson.path}
SCENES = (7, 12)  # of a path
CORE_MINUTES, WHOLE_MINUTES = (10.0, 16.5), 45.0
MAX_CHINESE = 90  # characters of a scene's text


class Walker:
    """A tab without a browser on a lesson's path, with a clock of its own."""

    def __init__(self, lesson: str, language: str = "en") -> None:
        self.now = 0.0
        self.session = Session(LESSONS, FakeView(), lesson, language, clock=lambda: self.now, mode="guide")
        self.session.open()

    @property
    def scene(self) -> Scene:
        picture = self.session.picture
        assert picture is not None and picture.scene is not None
        return picture.scene

    @property
    def done(self) -> frozenset[str]:
        assert self.session.picture is not None
        return self.session.picture.state.done

    def send(self, edit: object, seconds: float = 0.0) -> None:
        self.session.post(edit)  # type: ignore[arg-type]
        self.session.step()
        self.wait(seconds)

    def wait(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end:
            self.now += 0.11
            self.session.step()

    def do(self) -> None:
        """Do what the scene asks for, as a person would."""
        picture, scene = self.session.picture, self.scene
        assert picture is not None
        match scene.do:
            case Choose():
                self.send(ChooseOption(prediction_of(picture.lesson, scene, "en").answer), 3.0)
            case Press(button):
                if button == "pull":
                    self.send(SetKnobs({"pull": ByHand(0.1, released=True)}, 1))
                else:
                    self.send(Kick() if button == "kick" else Play())
            case Move(knobs, goal):
                self.send(SetKnobs({knobs[0]: another(picture.lesson, knobs[0], picture.design[knobs[0]], goal)}))
                self.wait(0.5)
            case Solve(task):
                found = next(t for t in picture.lesson.tasks if t.id == task)
                self.send(SetKnobs(dict(found.solution)))
                self.wait(0.5)
            case Read():
                self.wait(3.0 if scene.play else 0.0)


def nameless(lesson: Lesson, language: str) -> Iterator[str]:
    """Names in the cards' actions that no knob of the scene has, no option of one and no button."""
    for scene in lesson.path:
        knobs = [lesson.knob(name) for name in scene.knobs]
        there = [knob.label(language) for knob in knobs]
        there += [label(language) for knob in knobs if isinstance(knob, Choice) for _, label in knob.options]
        there += [words(language) for words in BUTTONS.values()]
        for name in re.findall(r"\*([^*]+)\*|“([^”]+)”", lesson.words[language].scenes[scene.id].do):
            if not any("".join(name).lower() in words.lower() for words in there):
                yield f"{scene.id}: {''.join(name)} is none of {there}"


@pytest.mark.parametrize("language", languages())
@each("lesson", LESSONS.values())
def test_what_a_card_asks_a_hand_to_move_has_that_name_on_the_screen(lesson: Lesson, language: str) -> None:
    assert list(nameless(lesson, language)) == []


@each("lesson", LESSONS.values())
def test_a_figure_of_a_scene_shows_something_before_anything_long_is_computed(lesson: Lesson) -> None:
    for k, scene in enumerate(lesson.path):
        reached = lesson.compute(lesson.apply(lesson.start(), entry_values(lesson.path, k, lesson.start())))
        for figure in lesson.figures(reached):
            if figure.id in scene.figures and isinstance(figure, (LineFigure, PlaneFigure)):
                y = [curve.y for curve in figure.curves if len(curve.y) > 2]
                assert y or getattr(figure, "points", ()), f"{scene.id}: {figure.id} is empty"


@each("lesson", LESSONS.values())
def test_a_place_that_is_typed_solves_what_the_exact_place_solves(lesson: Lesson) -> None:
    """A field keeps so many decimals: the sharpest criterion must be reached with them."""
    for k, scene in enumerate(lesson.path):
        typed = [knob for name in scene.knobs if isinstance(knob := lesson.knob(name), Poles)]
        if typed and isinstance(scene.do, Solve):
            asked = scene.do.task
            task = next(each for each in lesson.tasks if each.id == asked)
            near = {knob.name: tuple(complex(round(p.real, typed_decimals(knob)), round(p.imag, typed_decimals(knob)))
                                     for p in task.solution[knob.name]) for knob in typed}
            design = lesson.apply(lesson.start(), {**entry_values(lesson.path, k, lesson.start()), **task.solution, **near})
            assert task.check(lesson.compute(design)).solved, f"{scene.id}: {near}"


def another(lesson: Lesson, name: str, value: object, goal: Goal | None = None) -> object:
    """Some other value of a knob, one that reaches the goal."""
    if goal is not None and goal.value is not None:
        return goal.value
    knob = lesson.knob(name)
    if isinstance(value, bool):
        return not value
    if isinstance(value, tuple):
        return tuple(p * (1.1 if goal is not None and goal.way == "left" else 0.9) for p in value)
    if isinstance(value, str):
        return next(key for key, _ in knob.options if key != value)  # type: ignore[attr-defined]
    low, high = knob.low, knob.high  # type: ignore[attr-defined]
    if goal is not None:
        return min(goal.most or high, high) if goal.way == "right" else max(goal.least or low, low)
    return low if value != low else high


def words_of(text: str) -> list[str]:
    """The words of a text; a formula counts as one."""
    return [word for word in re.sub(r"\$[^$]+\$", "formula", text).split() if re.search(r"\w", word)]


def faults(lesson: Lesson) -> Iterator[str]:
    """What a path lacks, or has too much of."""
    path, start = lesson.path, lesson.start()
    outcome = lesson.compute(start)
    figures, boards = {f.id for f in lesson.figures(outcome)}, {b.id for b in outcome.boards}
    formulas = {f.id for f in outcome.formulas}
    ids = [scene.id for scene in path]
    if not SCENES[0] <= len(path) <= SCENES[1] or len(set(ids)) < len(ids):
        yield f"{len(path)} scenes"
    if not CORE_MINUTES[0] <= minutes_of(path, True) <= CORE_MINUTES[1]:
        yield f"core of {minutes_of(path, True)} minutes"
    if minutes_of(path, False) > WHOLE_MINUTES:
        yield f"{minutes_of(path, False)} minutes"
    if not any(isinstance(scene.do, Choose) and scene.do.question is Question.FIRST for scene in path):
        yield "no scene asks the lesson's prediction"
    if lesson.again is not None and not any(isinstance(s.do, Choose) and s.do.question is Question.SECOND for s in path):
        yield "no scene asks the lesson's second prediction"
    if not any(isinstance(scene.do, (Move, Press, Solve)) for scene in path):
        yield "nothing is done with a hand"
    for k, scene in enumerate(path):
        here = f"{scene.id}: "
        reached = lesson.compute(lesson.apply(start, entry_values(path, k, start)))
        shown = {f.id for f in lesson.figures(reached)}
        if len(scene.knobs) > MAX_KNOBS or len(scene.figures) > MAX_FIGURES:
            yield here + "too much in sight"
        all_boards = boards | {b.id for b in reached.boards}
        for what, names, known in (("figure", scene.figures, figures | shown), ("board", scene.boards, all_boards),
                                   ("formula", scene.formulas, formulas | {f.id for f in reached.formulas})):
            for name in names:
                if name not in known:
                    yield f"{here}no {what} {name}; there are {sorted(known)}"
        if isinstance(scene.do, Move):
            reach = {b.knob for b in reached.boards if b.id in scene.boards} | set(scene.knobs)
            if not set(scene.do.knobs) & reach:
                yield f"{here}no widget or board in sight moves {scene.do.knobs}"
        if isinstance(scene.do, Press) and scene.do.button == "kick" and not lesson.kick:
            yield here + "this lesson has no kick"
        if isinstance(scene.do, Press) and scene.do.button == "pull" and not (reached.stage is not None and reached.stage.held):
            yield here + "nothing on this stage can be pulled"
        for language in languages():
            yield from (f"{here}{language}: {fault}" for fault in wording(lesson, scene, language, reached.metrics))


def wording(lesson: Lesson, scene: Scene, language: str, metrics: object) -> Iterator[str]:
    """What is wrong with the words of a scene in a language."""
    found = lesson.words[language].scenes.get(scene.id)
    if found is None:
        yield "no words"
        return
    if language == "en":
        if len(words_of(found.text)) > MAX_TEXT_WORDS:
            yield f"text of {len(words_of(found.text))} words"
        if len(words_of(found.say)) > MAX_TEXT_WORDS:
            yield f"verdict of {len(words_of(found.say))} words"
        if len(words_of(found.title)) > MAX_TITLE_WORDS:
            yield f"title of {len(words_of(found.title))} words"
    elif len(re.sub(r"\[\[[^]]+\]\]", "1.23", re.sub(r"\$[^$]+\$", "式", found.text))) > MAX_CHINESE:
        yield f"text of {len(found.text)} characters"
    if not found.text or not found.title or not found.note:
        yield "lacks its text, title or speaker's note"
    if isinstance(scene.do, (Move, Press, Solve)) and not (found.do and found.say):
        yield "does not say what to do, or what has come of it"
    if isinstance(scene.do, Choose):
        asked = prediction_of(lesson, scene, language)
        options, refutations, answer = asked.options, asked.refutations, asked.answer
        if len(options) < 2 or not 0 <= answer < len(options) or not found.say:
            yield "has no options, no answer or no verdict"
        elif any(bool(words) == (k == answer) for k, words in enumerate(refutations)):
            yield "a wrong option is not refuted, or the right one is"
    for words in (found.text, found.say, found.do):
        for name in places_of(words):
            if name not in metrics and name not in {k.name for k in lesson.knobs}:  # type: ignore[operator]
                yield f"no number {name}"


def test_every_lesson_has_a_path_in_every_language() -> None:
    assert set(PATHS) == set(LESSONS)


@each("id", list(PATHS))
def test_a_path_is_short_and_complete(id: str) -> None:
    found = list(faults(LESSONS[id]))
    assert not found, "\n".join(found)


@pytest.mark.slow
@pytest.mark.parametrize("id", list(PATHS))
def test_every_action_can_be_done_and_forth_and_back_shows_the_same(id: str) -> None:
    walker, states, verdicts = Walker(id), [], []
    path = LESSONS[id].path
    for k, scene in enumerate(path):
        assert walker.scene.id == scene.id
        assert walker.session.picture is not None
        assert isinstance(scene.do, Read) or scene.id not in walker.done, f"{scene.id} is done before anything was done"
        assert "[[" not in card_html(walker.session.picture, "hand"), f"{scene.id} shows a place without its number"
        walker.do()
        assert scene.id in walker.done, f"{scene.id} is not done"
        walker.wait(0.5)
        states.append(dict(walker.session.picture.design.values))
        verdicts.append(verdict_html(walker.session.picture, "hand"))
        if k < len(path) - 1:
            walker.send(TurnScene(1))
    names = {name for scene in path for name in (*scene.set, *scene.play, *scene.knobs)}
    for k in reversed(range(len(path))):
        walker.send(GoToScene(k))
        assert walker.session.picture is not None
        now = dict(walker.session.picture.design.values)
        assert {n: now[n] for n in names} == {n: states[k][n] for n in names}, path[k].id
        assert verdict_html(walker.session.picture, "hand") == verdicts[k], path[k].id


BOARD_PX = 250.0  # px that a board is wide in the guide at 1280x720
NEIGHBOURS = (0, -1, 1, -2, 2)  # px beside the solution's


def on_grid(poles: tuple[complex, ...], board: Board, shift: float, aside: tuple[int, int]) -> tuple[complex, ...]:
    """Poles at pixels of a board: each at the one next to it and so many aside, on a grid shifted by a part of a pixel."""
    pixel = (board.re_high - board.re_low) / BOARD_PX, 2 * board.im_high / (BOARD_PX * BOARD_HEIGHT / BOARD_WIDTH)

    def nearest(value: float, size: float, by: int) -> float:
        return (round(value / size - shift) + shift + by) * size
    return tuple(board.hold(complex(nearest(p.real, pixel[0], aside[0]), 0.0 if p.imag == 0 else math.copysign(
        abs(nearest(abs(p.imag), pixel[1], aside[1])), p.imag))) for p in map(complex, poles))


def test_a_task_that_only_crosses_solve_is_solved_at_some_pixel() -> None:
    """What the card asks for a hand can do with a mouse: no board has poles between two pixels."""
    def law(lesson: Lesson, k: int) -> None:
        scene = lesson.path[k]
        assert isinstance(scene.do, Solve)
        wanted = scene.do.task
        task = next(each for each in lesson.tasks if each.id == wanted)
        design = lesson.apply(lesson.start(), {**entry_values(lesson.path, k, lesson.start()), **task.solution})
        dragged = task.solution.keys() - set(scene.knobs)
        boards = [board for board in lesson.compute(design).boards if board.id in scene.boards and board.knob in dragged]
        for shift in (0.0, 0.37, 0.71) if boards else ():
            tries = (lesson.apply(design, {str(b.knob): on_grid(task.solution[str(b.knob)], b, shift, aside) for b in boards})
                     for aside in product(NEIGHBOURS, NEIGHBOURS))
            assert any(task.judge(lesson.compute(each)).solved for each in tries), f"{scene.id}: between two pixels"
    holds_for_all([(lesson, k) for lesson in PATHS.values() for k, scene in enumerate(lesson.path) if isinstance(scene.do, Solve)], law,
                  lambda lesson, k: f"{lesson.id} {lesson.path[k].id}")


def test_a_scene_with_a_moment_opens_there_and_plays_from_the_start() -> None:
    def law(lesson: Lesson, k: int) -> None:
        walker = Walker(lesson.id)
        walker.send(GoToScene(k))
        picture, moment = walker.session.picture, lesson.path[k].moment
        assert picture is not None and moment is not None and picture.state.t == moment * picture.end < picture.horizon
        if not picture.veiled:
            walker.send(Play())
            assert walker.session.picture is not None and walker.session.picture.state.t <= 0.02 * picture.end
    holds_for_all([(lesson, k) for lesson in PATHS.values() for k, scene in enumerate(lesson.path) if scene.moment is not None], law,
                  lambda lesson, k: f"{lesson.id} {lesson.path[k].id}")


WITH_LINES = [lesson for lesson in LESSONS.values() if lesson.number <= 8]


@each("lesson", WITH_LINES)
def test_the_scene_that_says_why_shows_its_algebra_in_lines_that_move(lesson: Lesson) -> None:
    scene = next(scene for scene in lesson.path if scene.id == "why")
    numbers = {**lesson.compute(lesson.start()).metrics}
    lines = [fill_numbers(line, lambda name, spec: format(numbers[name], spec)) for line in scene.lines]
    drawn = moving_lines(lines)
    assert len(lines) >= 3 and drawn.count('style="--at:') == len(lines) and "<code" not in drawn
    marks = re.findall(r"\\color\{(\w+)\}", "".join(lines))
    assert marks and set(marks) <= set(MARKS) and not re.search("mathcolor=\"(?!#)", drawn)
    gone = re.findall(r"\\color\{gone\}\{(.*?)\}\}", "".join(lines))
    assert len(gone) != 1 and len(set(gone)) <= 1, "what cancels stands in two lines alike"
    assert "gone" not in lines[-1]
    *terms, sum_of_them = re.findall(r"\\color\{gather\}\{(.*?)\}\}", "".join(lines)) or [""]
    assert sum_of_them == (f"({' - '.join(terms)})" if terms else ""), "terms are gathered into what they become"
    assert bool(terms) == bool(gone), "where the subtraction cancels one term, it gathers the others"
