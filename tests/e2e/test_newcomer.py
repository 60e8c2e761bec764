"""A newcomer gets on by the words on the screen, and the first drag moves the world.

One lesson or a few here; all of them by `python tests/e2e/newcomer.py` and, every card of every path, `follow_cards.py --all`, by
keys `key_hand.py`.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from follow_cards import Newcomer, open_lesson, start, walk
from key_hand import KeyHand
from newcomer import WANTED, play, stands_still
from playwright.sync_api import Page
from tab import Tab, eventually

from observer_lab.lessons import LESSONS

CLOCK = "() => Number(document.querySelector('.ol-clock')?.dataset.share ?? 0)"  # there is none while a lesson is laid out
CURSORS = """() => document.querySelector('.ol-clock') &&
  new Set([document.querySelector('.ol-clock').dataset.share,  // at one moment: the run goes on
  ...[...document.querySelectorAll('.u-over')].map(chart => getComputedStyle(chart).getPropertyValue('--ol-t'))]).size"""


MOST_ACTIONS = 4  # of a newcomer's hand, from the page of lessons to the end of the first drag
SAMPLED = ("separation", "hidden-modes", "kalman")  # lessons whose core path is walked here: crosses, a list, sliders
BY_KEYS = ("error-dynamics",)  # whose whole path is: poles, a pull, sliders


@pytest.fixture
def page(guide_page: Callable[..., Page]) -> Page:
    return guide_page()


def test_a_newcomer_drags_with_the_fourth_action_and_comes_to_the_end_of_the_first_lesson(page: Page, guide: str) -> None:
    person, drag = start(page, guide), 0
    lesson = next(each for each in LESSONS.values() if each.number == 1)
    assert lesson.words["en"].title in page.locator(".ol-lesson").inner_text()
    for scene, problem in walk(person, lesson, core=True):
        assert not problem, (scene, problem)
        drag = drag or len(person.actions) * person.actions[-1].startswith("drag")
    assert 0 < drag <= MOST_ACTIONS, person.actions
    assert person.scene == lesson.path[-1].id and person.is_done()
    assert person.drags > 2 and person.moved == [], "nothing of the page moves under a hand"


@pytest.mark.parametrize("name", SAMPLED)
def test_the_core_path_of_a_lesson_is_done_by_what_its_cards_say(page: Page, guide: str, name: str) -> None:
    lesson = LESSONS[name]
    person = Newcomer(page)
    open_lesson(person, guide, lesson)
    found = list(walk(person, lesson, core=True))
    assert [each for each in found if each[1]] == []
    assert person.moved == [], "nothing of the page moves under a hand"
    assert len(found) == sum(scene.core for scene in lesson.path)


@pytest.mark.parametrize("name", BY_KEYS)
def test_every_scene_of_a_lesson_is_done_by_keys(page: Page, guide: str, name: str) -> None:
    person = KeyHand(page)
    open_lesson(person, guide, LESSONS[name])
    found = list(walk(person, LESSONS[name], core=False))
    assert [each for each in found if each[1]] == []
    assert len(found) == len(LESSONS[name].path) and any("arrows on observer" in each for each in person.actions)


def test_a_lesson_opens_in_motion_where_motion_is_welcome_and_the_first_drag_moves_the_ghost(new_tab: Callable[..., Tab]) -> None:
    tab, lesson = new_tab(1366, 768, motion=True), LESSONS["error-dynamics"]
    tab.page.evaluate(f"window.furthest = 0; setInterval(() => {{ furthest = Math.max(furthest, ({CLOCK})()); }}, 30); 0")
    tab.choose_lesson(lesson.words["en"].title, lesson.words["en"].question)
    eventually(lambda: tab.page.evaluate("window.furthest"), lambda share: share > 0, "the run in motion")
    what, moved, _ = play(tab, lesson)
    times = eventually(lambda: tab.page.evaluate(CURSORS), lambda found: found is not None, "the clock, written while it runs")
    assert times == 1, "the cursors of all charts and the clock tell one time"
    assert moved > WANTED, f"{what} moved the ghost by {moved:.0f} px"
    assert stands_still(LESSONS["lqg"])  # by its nature: there the plant moves against it


def test_a_lesson_stands_still_where_calm_is_asked_for(tab: Tab) -> None:
    assert tab.page.evaluate(CLOCK) == 0.0
    assert tab.clock() == 0.0


def test_a_pointer_over_a_chart_reads_its_curves(new_tab: Callable[..., Tab]) -> None:
    """The value beside the pointer is the one of the data there; before the prediction nothing is told."""
    tab = new_tab(1280, 760)
    words = "() => { const note = document.querySelector('.ol-reading'); return note.hidden ? '' : note.textContent; }"

    def point() -> str:
        box = tab.page.locator(".u-over:visible").first.bounding_box()
        assert box is not None
        tab.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        return tab.page.evaluate(words)
    tab.page.get_by_role("tab", name="Error and input", exact=True).press("Enter")  # it answers the question
    eventually(lambda: tab.page.locator(".u-over:visible").first.bounding_box(), bool, "a chart of that tab")
    assert point() == ""
    tab.choose_lesson(LESSONS["error-dynamics"].words["en"].title, LESSONS["error-dynamics"].words["en"].question)
    tab.predict("skip")
    said = eventually(point, bool, "the reading")
    t, *curves = tab.curves()[0][1]
    at = min(range(len(t)), key=lambda i: abs(t[i] - t[-1] / 2))
    read = [float(word.replace("−", "-")) for word in said.replace("▬", " ").split() if word.replace("−", "-").lstrip("-")[0].isdigit()]
    assert read[0] == pytest.approx(t[at], abs=0.01 * t[-1])
    assert read[1] == pytest.approx(curves[0][at], rel=0.2, abs=1e-3)
