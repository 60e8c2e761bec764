"""A newcomer without a mouse: every card of every path by Tab, Enter, Space and the arrows alone.

    python tests/e2e/key_hand.py [--size 1366x768] [--lang en] [LESSON …]

It does what `follow_cards.py` does with a hand that has no pointer. Each thing must be reached by Tab within REACH presses and be in the
window with the focus on it. Exit status 1 where a scene could not be done.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from playwright.sync_api import Locator

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from follow_cards import Newcomer, Stuck, main
from tab import eventually

from observer_lab.course.lesson import Board
from observer_lab.page.stage.pole_boards import BOARD_WIDTH

REACH = 90  # presses of Tab within which everything on a card must be reachable
STEPS = 25  # presses of an arrow on a slider before the card is looked at again
SHARE = 0.11  # of a board's width: how far a pole goes where the card names no place
HOLDS = "(each) => each === document.activeElement || each.contains(document.activeElement)"
SEEN = """() => {  // whether what has the focus lies in the window, uncovered in its middle
  const held = document.activeElement, box = held.getBoundingClientRect(), x = box.x + box.width / 2, y = box.y + box.height / 2;
  const top = document.elementFromPoint(x, y);
  return !!top && (held.contains(top) || top.contains(held) || [...(held.labels ?? [])].some(label => label.contains(top)));
}"""
PLACES = """board => [...document.querySelectorAll(`input[data-slider^="${board}."]`)].filter(each => each.checkVisibility())
  .map(each => [each.dataset.slider, Number(each.value), Number(each.step)])"""


class KeyHand(Newcomer):
    """A newcomer at a keyboard without a mouse."""

    def reach(self, thing: Locator, what: str) -> None:
        """Press Tab until the focus is on a thing or in it."""
        handle = thing.element_handle(timeout=60_000)
        for _ in range(REACH):
            self.page.keyboard.press("Tab")
            if self.page.evaluate(HOLDS, handle):
                if not self.page.evaluate(SEEN):
                    raise Stuck(f"{what} has the focus and is not in sight")
                return
        raise Stuck(f"{what} is not reached with {REACH} presses of Tab")

    def press(self, button: Locator, what: str) -> None:
        self.actions.append(f"press {what}")
        self.reach(button, what)
        self.page.keyboard.press("Enter")

    def slide(self, label: str, side: str = "") -> None:
        self.actions.append(f"arrows on {label}")
        slider = self.row(label).get_by_role("slider")
        self.reach(slider, label)
        now, low, high = (float(slider.get_attribute(f"aria-value{name}") or 0.0) for name in ("now", "min", "max"))
        key = "ArrowRight" if side == "right" or (not side and now < (low + high) / 2) else "ArrowLeft"
        for _ in range(STEPS):
            self.page.keyboard.press(key)
        self.settled()

    def write(self, label: str, words: str, part: int = -1) -> None:
        self.actions.append(f"type {words} for {label}")
        self.reach(self.row(label).locator("input").nth(part), label)
        self.page.keyboard.press("Control+a")
        self.page.keyboard.type(words)
        self.page.keyboard.press("Enter")
        self.settled()

    def choose(self, label: str, option: str) -> None:
        self.actions.append(f"choose {option or 'another'} for {label}")
        field = self.row(label).locator("input").first
        self.reach(field, label)
        now = field.input_value()
        self.page.keyboard.press("ArrowDown")
        options = self.page.get_by_role("option").locator("visible=true")
        options.first.wait_for()
        words = options.all_inner_texts()
        wanted = option or next(each for each in words if each != now)
        chosen = self.page.locator("[role=option][data-combobox-selected]")
        for _ in range(len(words) + 2):
            under = chosen.inner_text() if chosen.count() else ""
            if under == wanted:
                break
            self.page.keyboard.press("ArrowDown")
            if len(words) > 1:  # the page shows it a moment later; a second press before that would go beyond
                eventually(lambda last=under: chosen.inner_text() if chosen.count() else last, lambda now, last=under: now != last,
                           "the next option")
        else:
            raise Stuck(f"the arrows do not reach “{wanted}” of {label}")
        self.page.keyboard.press("Enter")
        self.settled()

    def tick(self, label: str) -> None:
        self.actions.append(f"switch {label}")
        self.reach(self.page.get_by_role("checkbox", name=label).locator("visible=true").first, label)
        self.page.keyboard.press("Space")
        self.settled()

    def drag_cross(self, board: Board, pole: int, to: tuple[float, float] | None = None) -> None:
        """Move a pole by the arrows, on the two sliders that stand for it."""
        cross = self.s_of(board, self._local(board, pole))
        wide = board.re_high - board.re_low
        middle = (board.re_low + board.re_high) / 2
        goal = self.s_of(board, to) if to else cross + (SHARE if cross.real < middle else -SHARE) * wide
        eventually(lambda: self.page.evaluate(PLACES, board.id), bool, "sliders for the poles", patience=20)
        places = {name: (value, step) for name, value, step in self.page.evaluate(PLACES, board.id)}
        rows = sorted({name.rsplit(".", 1)[0] for name in places})
        row = min(rows, key=lambda each: abs(complex(places[f"{each}.0"][0], places[f"{each}.1"][0]) - cross))
        for axis, asked in enumerate((goal.real, abs(goal.imag))):
            value, step = places[f"{row}.{axis}"]
            presses = round((asked - value) / step)
            if presses == 0:
                continue
            self.actions.append(f"{abs(presses)} arrows on {row}.{axis}")
            self.reach(self.page.locator(f'input[data-slider="{row}.{axis}"]'), f"the slider {row}.{axis}")
            for _ in range(abs(presses)):
                self.page.keyboard.press("ArrowRight" if presses > 0 else "ArrowLeft")
            self.settled()

    @staticmethod
    def s_of(board: Board, at: Sequence[float]) -> complex:
        """The place of the s-plane that is drawn at a place of the board."""
        return complex((at[0] / BOARD_WIDTH + 0.5) * (board.re_high - board.re_low) + board.re_low, at[1] * board.im_high)

    def _pull_by_keys(self) -> None:
        slider = self.page.locator("input[data-springs]:visible").first
        if not slider.count():
            raise Stuck("no slider pulls the plant")
        self.actions.append("pull by keys")
        self.reach(slider, "the slider that pulls")
        self.page.keyboard.press("ArrowRight", delay=300)


if __name__ == "__main__":
    raise SystemExit(main(KeyHand, every=True))
