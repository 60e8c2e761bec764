"""Follow the cards: a newcomer does what each card says, with the mouse, by the words on the screen alone.

    python tests/e2e/follow_cards.py [--size 1366x768] [--lang en] [--all] [LESSON …]

It starts at the page of lessons, walks the path of each lesson to its end and prints what it could not do, and what of the page moved
while it dragged something. It knows the words that
stand on the screen and where a cross of a board is drawn. Which values solve a task it takes from the lesson's own solution: that stands
for what a person thinks; the hand that sets them has what the card shows and nothing else. Without `--all` it goes by the scenes of
the core path. Exit status 1 where a scene could not be done.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from playwright.sync_api import Locator, Page, sync_playwright

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from geometry import LOCAL, WHERE
from still import moved, remember
from tab import ANSWERED, FLAGS, UNDRAWN, eventually

from observer_lab.course.guiding.predictions import prediction_of
from observer_lab.course.knobs import Choice, Knob, Number, Poles, Switch
from observer_lab.course.lesson import Board, Lesson
from observer_lab.course.scenes import Choose, Goal, Move, Press, Scene, Solve
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.stage.pole_boards import BOARD_HEIGHT, BOARD_WIDTH
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

PATIENCE = 60_000  # ms
TRIES = 6  # drags or settings of a task before it is given up
NEARER = {"right": 0.6, "left": 1.4}  # of a pole's distance from the axis: where a card asks to drag it
NEAR = 1e-3  # of a board's width: a cross that is so near is not dragged
AWAY = 0.11  # of a board's width: how far a cross is dragged where the card names no place
AT = """([pole, at]) => {  // the pixel of a place on the board on which a cross stands
  const page = window.__viserMutable, held = page.nodeRefFromName[pole], node = held && 'current' in held ? held.current : held;
  node.parent.updateWorldMatrix(true, false);
  const point = node.position.clone().set(...at).applyMatrix4(node.parent.matrixWorld).project(page.camera);
  const box = page.canvas.getBoundingClientRect();
  return [box.x + (point.x + 1) / 2 * box.width, box.y + (1 - point.y) / 2 * box.height];
}"""
ON_STAGE = "([x, y]) => document.elementFromPoint(x, y) === window.__viserMutable.canvas"


class Stuck(Exception):
    """What a card says cannot be done with what it shows."""


class Newcomer:
    """A person at one page who reads a card and does what it says."""

    def __init__(self, page: Page, language: str = "en") -> None:
        self.page, self.language, self.actions = page, language, list[str]()
        self.began, self.first_drag = time.monotonic(), "none"
        self.drags, self.moved = 0, list[str]()  # what moved on the page while a hand was at work

    # --- the words on the screen ------------------------------------------------------------------------------------------
    @property
    def scene(self) -> str:
        """Which card is open."""
        return self.page.locator(".ol-card").get_attribute("data-scene") or ""

    @property
    def asked(self) -> str:
        """What the card says is to be done."""
        return " ".join(self.page.locator(".ol-todo").all_inner_texts())

    @property
    def named(self) -> list[str]:
        """The words of it that are the names of things."""
        return self.page.locator(".ol-todo b").all_inner_texts()

    def is_done(self) -> bool:
        """Whether the way on is the large button."""
        return self.page.locator(".ol-way .ol-next").count() == 1

    def settled(self) -> None:
        """Wait until the page shows the answer to all that was done."""
        eventually(lambda: self.page.evaluate(ANSWERED, True), lambda said: said is True, "an answer to what was done")

    # --- the hand -----------------------------------------------------------------------------------------------------------
    def press(self, button: Locator, what: str) -> None:
        """Press a button that can be seen."""
        self.actions.append(f"press {what}")
        button.click(timeout=PATIENCE)

    def pull(self, start: Sequence[float], end: Sequence[float], what: str) -> None:
        """Drag from a pixel to another one."""
        self.actions.append(f"drag {what}")
        mouse = self.page.mouse
        mouse.move(*start)
        self.settled()
        assert remember(self.page), "nothing stands on the page"
        mouse.down()
        for k in range(1, 5):
            mouse.move(start[0] + (end[0] - start[0]) * k / 4, start[1] + (end[1] - start[1]) * k / 4)
            self.settled()
            self.moved += [f"{self.scene}, {what}: {each}" for each in moved(self.page)]
        mouse.up()
        self.drags += 1
        self.settled()
        if self.first_drag == "none":
            self.first_drag = f"action {len(self.actions)}, {time.monotonic() - self.began:.0f} s"

    def row(self, label: str) -> Locator:
        """The row of a knob by its words, seen in the column of the card."""
        row = self.page.locator("[data-ol-row]", has=self.page.get_by_text(label, exact=True)).last
        if not (row.count() and row.is_visible()):
            raise Stuck(f"no knob “{label}” is in sight")
        row.scroll_into_view_if_needed()
        return row

    def slide(self, label: str, side: str = "") -> None:
        """Drag a slider from where it stands to the side that is asked for, else to the emptier one."""
        thumb, track = self.row(label).get_by_role("slider"), self.row(label).locator("[data-ol-slider]")
        knob, way = thumb.bounding_box(), track.bounding_box()
        assert knob is not None and way is not None
        x, y = knob["x"] + knob["width"] / 2, knob["y"] + knob["height"] / 2
        right = side == "right" or (not side and x < way["x"] + way["width"] / 2)
        end = min(max(x + (0.3 if right else -0.3) * way["width"], way["x"]), way["x"] + way["width"])
        self.pull((x, y), (end, y), label)

    def write(self, label: str, words: str, part: int = -1) -> None:
        """Type into the field beside a slider, or into one of a pole's two."""
        self.actions.append(f"type {words} for {label}")
        field = self.row(label).locator("input").nth(part)
        field.fill(words)
        field.press("Enter")
        self.settled()

    def choose(self, label: str, option: str) -> None:
        """Choose from a list; without an option another one than the present."""
        self.actions.append(f"choose {option or 'another'} for {label}")
        field = self.row(label).locator("input").first
        now = field.input_value()
        field.click()
        options = self.page.get_by_role("option").locator("visible=true")
        words = options.all_inner_texts()
        options.nth(words.index(option or next(each for each in words if each != now))).click()
        self.settled()

    def tick(self, label: str) -> None:
        """Switch a box on or off."""
        self.actions.append(f"switch {label}")
        self.page.get_by_role("checkbox", name=label).locator("visible=true").first.click()
        self.settled()

    def drag_cross(self, board: Board, pole: int, to: tuple[float, float] | None = None) -> None:
        """Drag a cross to a place on its board; without one to the side where there is more room."""
        name = f"/board/{board.id}/pole{pole}"
        self.page.wait_for_function(f"name => ({WHERE})(name) !== null", arg=name, timeout=PATIENCE)
        x, y, z = self.page.evaluate(LOCAL, name)
        goal = to or (x + (AWAY if x < 0 else -AWAY) * BOARD_WIDTH, z)
        start, end = self.page.evaluate(AT, [name, [x, y, z]]), self.page.evaluate(AT, [name, [goal[0], y, goal[1]]])
        if not self.page.evaluate(ON_STAGE, start):
            raise Stuck(f"something lies over the cross {name}")
        self.pull(start, end, name)

    # --- what cards ask for ---------------------------------------------------------------------------------------------
    def answer(self, option: int) -> None:
        """Choose an option and wait for the verdict."""
        self.press(self.page.locator(".ol-option:enabled").nth(option), f"option {'ABCDEFGH'[option]}")
        self.page.wait_for_selector(".ol-answer :is(.ol-right, .ol-wrong)", timeout=PATIENCE)

    def go_on(self) -> None:
        """Press the large button that leads on."""
        self.press(self.page.locator(".ol-way .ol-next"), self.page.locator(".ol-way .ol-next").inner_text())

    def do(self, lesson: Lesson, scene: Scene) -> None:
        """Do what the card says. Raises Stuck."""
        self.settled()
        if isinstance(scene.do, Choose):
            if self.page.locator(".ol-option:enabled").count() < 2:
                raise Stuck("no options are in sight")
            right = prediction_of(lesson, scene, self.language).answer
            self.answer(0 if right else 1)  # a newcomer errs
        elif scene.do == Press("pull"):
            self._pull_by_keys()
        elif isinstance(scene.do, Press):
            if not self.named:
                raise Stuck("the card names no button")
            self.press(self.page.locator("[data-ol-button]:visible", has_text=self.named[0]).first, self.named[0])
        elif isinstance(scene.do, Move):
            self._move(lesson, scene, scene.do)
        elif isinstance(scene.do, Solve):
            self._solve(lesson, scene, scene.do)
        eventually(self.is_done, bool, f"{lesson.id} {scene.id} done by “{self.asked}”, after {self.actions[-3:]}", patience=20)

    def _pull_by_keys(self) -> None:
        """Hold an arrow key on the slider that pulls the plant, and let go."""
        slider = self.page.locator("input[data-springs]:visible").first
        if not slider.count():
            raise Stuck("no slider pulls the plant")
        self.actions.append("pull by keys")
        slider.focus(timeout=PATIENCE)
        self.page.keyboard.press("ArrowRight", delay=300)

    def _move(self, lesson: Lesson, scene: Scene, asked: Move) -> None:
        if not self.asked:
            raise Stuck("the card does not say what to move")
        for name in asked.knobs:
            board = next((b for b in boards_of(lesson, scene) if b.knob == name), None)
            if board is not None:
                slowest = max(range(len(board.poles)), key=lambda k: board.poles[k].real)
                pole = complex(board.poles[slowest])
                nearer = complex(pole.real * NEARER.get(asked.goal.way, 1.0), pole.imag) if asked.goal else None
                self.drag_cross(board, slowest, None if nearer is None else self._spot(board, nearer))
                return
            if name in scene.knobs:
                self._touch(lesson.knob(name), asked.goal)
                return
        raise Stuck(f"neither a cross nor a knob of {asked.knobs} is in sight")

    def _touch(self, knob: Knob, goal: Goal | None) -> None:
        """Move a knob as the card asks: to a value, within bounds, or in a direction."""
        label = label_of(knob, self.language)
        bounds = [bound for bound in (goal.least, goal.most) if bound is not None] if goal else []
        if isinstance(knob, Choice):
            self.choose(label, next((words(self.language) for option, words in knob.options if goal and option == goal.value), ""))
        elif isinstance(knob, Switch):
            self.tick(label)
        elif bounds:
            self.write(label, f"{sum(bounds) / len(bounds):.6g}")
        else:
            self.slide(label, goal.way if goal else "")

    def _solve(self, lesson: Lesson, scene: Scene, asked: Solve) -> None:
        """Set what a person would who knows the solution, on the knobs and crosses that the scene shows."""
        wanted = next(task for task in lesson.tasks if task.id == asked.task).solution
        for name in (name for name in scene.knobs if name in wanted):
            self._set(lesson, name, wanted[name])
        crosses = [board for board in boards_of(lesson, scene) if board.knob in wanted and board.knob not in scene.knobs]
        for _ in range(TRIES):
            if self.is_done():
                return
            for board in crosses:
                self._place(lesson, board, wanted[str(board.knob)])

    def _set(self, lesson: Lesson, name: str, value: Any) -> None:
        knob = lesson.knob(name)
        label = label_of(knob, self.language)
        if isinstance(knob, Choice):
            self.choose(label, next(words(self.language) for option, words in knob.options if option == value))
        elif isinstance(knob, Switch):
            self.tick(label)
        elif isinstance(knob, Number):
            self.write(label, f"{value:.6g}")
        elif isinstance(knob, Poles):
            for k, pole in enumerate(pole for pole in map(complex, value) if pole.imag >= 0):
                for part, number in enumerate((pole.real, pole.imag)):
                    self.write(f"{knob.symbol}{k + 1}", f"{number:.6g}", part)

    def _place(self, lesson: Lesson, board: Board, wanted: Sequence[complex]) -> None:
        """Drag each cross that has no wanted place under it to the nearest one that is free."""
        left = [self._spot(board, pole) for pole in wanted if complex(pole).imag >= 0]
        heads = [k for k in range(len(board.poles)) if self._local(board, k)[1] >= -NEAR]
        for k in heads:
            at = self._local(board, k)
            goal = min(left, key=lambda place: (place[0] - at[0]) ** 2 + (place[1] - at[1]) ** 2, default=None)
            if goal is None or self.is_done():
                return
            left.remove(goal)
            if abs(goal[0] - at[0]) + abs(goal[1] - at[1]) > NEAR * BOARD_WIDTH:
                self.drag_cross(board, k, goal)

    def _local(self, board: Board, pole: int) -> tuple[float, float]:
        x, _, z = self.page.evaluate(LOCAL, f"/board/{board.id}/pole{pole}")
        return x, z

    @staticmethod
    def _spot(board: Board, pole: complex) -> tuple[float, float]:
        s = complex(pole)
        return ((s.real - board.re_low) / (board.re_high - board.re_low) - 0.5) * BOARD_WIDTH, s.imag / board.im_high * BOARD_HEIGHT / 2


def boards_of(lesson: Lesson, scene: Scene) -> list[Board]:
    """The boards that a scene shows, as the lesson opens them."""
    return [board for board in lesson.compute(lesson.start()).boards if board.id in scene.boards]


def walk(person: Newcomer, lesson: Lesson, core: bool) -> Iterator[tuple[str, str]]:
    """Go through a lesson's path from its first card; each scene with what could not be done in it, "" where it was done."""
    for k, scene in enumerate(lesson.path):
        person.page.wait_for_selector(f".ol-card[data-scene={scene.id}]", timeout=PATIENCE)
        problem = ""
        if scene.core or not core:
            try:
                person.do(lesson, scene)
            except (Stuck, AssertionError) as found:
                problem = str(found) or "not done"
            yield scene.id, problem
        if k + 1 < len(lesson.path):
            if problem or not person.is_done():
                person.press(person.page.locator(".ol-way button").last, "skip")
            else:
                person.go_on()


def start(page: Page, address: str, language: str = "en") -> Newcomer:
    """Open the page as somebody who was never here, and press Start."""
    person = Newcomer(page, language)
    page.goto(address)
    person.press(page.locator(".ol-begin .ol-next"), "Start")
    page.wait_for_selector(".ol-card", timeout=PATIENCE)
    return person


def open_lesson(person: Newcomer, address: str, lesson: Lesson) -> None:
    """Open the first card of a lesson by its link."""
    opened = SavedState(lesson.start(), person.language, mode="guide", scene=lesson.path[0].id)
    person.page.goto(f"{address}#{write_token(lesson, opened)}")
    person.page.wait_for_selector(".ol-card", timeout=PATIENCE)


def main(hand: type[Newcomer] = Newcomer, every: bool = False) -> int:
    """Walk the lessons and print what could not be done."""
    from conftest import chromium, serving  # here: a test that imports this has another one at that name

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("lessons", nargs="*", default=list(LESSONS))
    parser.add_argument("--size", default="1366x768")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--all", action="store_true")
    asked = parser.parse_args()
    wide, high = map(int, asked.size.split("x"))
    done, undone = 0, list[str]()
    with serving(0, "--view", "guide") as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
        for id in asked.lessons:
            context = browser.new_context(viewport={"width": wide, "height": high}, reduced_motion="reduce")
            page = context.new_page()
            page.add_init_script(f"({UNDRAWN})()")
            person = hand(page, asked.lang)
            open_lesson(person, address, LESSONS[id])
            steps = list(walk(person, LESSONS[id], not (every or asked.all)))
            context.close()
            bad = [f"  {id} {scene}: {problem}" for scene, problem in steps if problem] + [f"  moved: {each}" for each in person.moved]
            done, undone = done + sum(not problem for _, problem in steps), undone + bad
            print(f"{id}: {sum(not problem for _, problem in steps)} of {len(steps)} scenes done, {len(person.actions)} actions, "
                  f"{person.drags} drags, {time.monotonic() - person.began:.0f} s, first drag: {person.first_drag}",
                  *bad, sep="\n", flush=True)
        browser.close()
    print(f"{done} scenes done, {len(undone)} not")
    return 1 if undone else 0


if __name__ == "__main__":
    raise SystemExit(main())
