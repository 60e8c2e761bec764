"""The guide shows once where a hand is wanted, and has the run in one thin row; on a phone nothing of the frame's own stands above it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect
from tab import ANSWERED, eventually

from observer_lab.course.figures.records import LineFigure
from observer_lab.course.scenes import Move, Press
from observer_lab.lessons import LESSONS
from observer_lab.page.words import phrases
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

PATIENCE = 60_000  # ms: a busy machine is slow
THIN = 52  # px of the row of the run
RUN = """() => {
  const box = document.querySelector('.ol-clock').parentElement.parentElement.getBoundingClientRect();
  return {high: box.height, left: box.left, right: box.right, bottom: box.bottom - innerHeight};
}"""
HEADS = "() => [...document.querySelectorAll('[data-ol-sheet-head]')].filter(each => each.checkVisibility()).length"
UNDER = """() => {  // what the hand points at
  const mark = document.querySelector('.ol-hand').getBoundingClientRect();
  return document.elementFromPoint(mark.left, mark.top)?.closest('button, canvas')?.textContent.trim() ?? 'nothing';
}"""


@pytest.fixture
def page(guide_page: Callable[..., Page]) -> Page:
    return guide_page()


def opened(page: Page, server: str, lesson_id: str, scene: str) -> None:
    """A scene of a lesson's guide."""
    lesson = LESSONS[lesson_id]
    page.goto(f"{server}#{write_token(lesson, SavedState(lesson.start(), 'en', False, mode='guide', scene=scene))}")
    expect(page.locator(f".ol-card[data-scene={scene}]")).to_be_visible(timeout=PATIENCE)
    expect(page.locator(".ol-cover")).to_be_hidden(timeout=PATIENCE)
    eventually(lambda: page.evaluate(ANSWERED, True), lambda said: said is True, "a page at rest")  # a card is laid out anew for its window


def scene_with(lesson_id: str, kind: type) -> str:
    """The first scene that asks for a press, or for a pole that is dragged."""
    return next(scene.id for scene in LESSONS[lesson_id].path if isinstance(scene.do, kind) and not scene.knobs)


@pytest.mark.parametrize(("lesson_id", "kind", "under"), [("error-dynamics", Press, phrases.KICK("en")), ("separation", Move, "")],
                         ids=["button", "cross"])
def test_a_still_ring_shows_once_where_to_press_or_drag(page: Page, server: str, lesson_id: str, kind: type, under: str) -> None:
    scene, hand = scene_with(lesson_id, kind), page.locator(".ol-hand")
    opened(page, server, lesson_id, scene)
    expect(hand).not_to_have_attribute("hidden", "", timeout=PATIENCE)
    assert page.evaluate(UNDER) == under
    assert hand.evaluate("mark => getComputedStyle(mark, '::before').animationName") == "none", "motion is reduced"
    box = hand.evaluate("mark => [mark.getBoundingClientRect().left, mark.getBoundingClientRect().top]")
    page.mouse.click(*box)
    expect(hand).to_have_count(0, timeout=PATIENCE)
    for step in (0, -1):  # away, and back to the scene
        eventually(lambda: page.evaluate(ANSWERED, True), lambda said: said is True, "an answer to what was done")
        page.locator(".ol-way button").nth(step).click()
        page.wait_for_function("([id, there]) => (document.querySelector('.ol-card')?.dataset.scene === id) === there",
                               arg=[scene, step < 0], timeout=PATIENCE)
    expect(page.locator(f".ol-card[data-scene={scene}]")).to_be_visible(timeout=PATIENCE)
    assert hand.count() == 0


@pytest.mark.parametrize("size", [(1366, 768), (1280, 720), (1920, 1080)], ids=str)
def test_the_run_in_the_guide_is_one_thin_row_that_plays_scrubs_and_changes_speed(page: Page, server: str, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    opened(page, server, "error-dynamics", scene_with("error-dynamics", Press))
    column = page.locator(".ol-card").bounding_box()
    found = page.evaluate(RUN)
    assert column is not None
    assert found["high"] <= THIN and found["bottom"] <= 0 and found["left"] >= 0 and found["right"] <= column["x"], found
    clock, slider = page.locator(".ol-clock"), page.get_by_role("slider").first
    page.locator("button", has_text=phrases.FASTER("en")).click()
    expect(clock).to_contain_text("2×", timeout=PATIENCE)
    slider.focus()
    page.keyboard.press("ArrowRight")
    expect(clock).not_to_contain_text("t = 0.00 s", timeout=PATIENCE)
    for words in (phrases.PLAY("en"), phrases.KICK("en"), phrases.REWIND("en")):
        assert page.locator("button", has_text=words).is_visible()


def test_no_bar_of_the_frame_stands_above_the_sheet_and_the_search_opens_all_the_same(page: Page, server: str) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    opened(page, server, "separation", "recall")
    assert page.evaluate(HEADS) == 0
    page.locator(".ol-more summary").click()
    page.locator(".ol-search").click()
    page.get_by_placeholder("Search commands...").fill("satur")
    page.keyboard.press("Enter")
    title = LESSONS["saturation"].words["en"].title
    expect(page.locator(".ol-lesson")).to_contain_text(title, timeout=PATIENCE)
    page.locator(".ol-mode[data-value='mode:lab']").click()
    expect(page.locator(".ol-question")).to_be_attached(timeout=PATIENCE)
    assert page.evaluate(HEADS) == 0


def test_the_search_finds_a_knob_in_either_language_and_puts_the_focus_on_it(page: Page, server: str) -> None:
    knob = LESSONS["separation"].knob("noise")
    opened(page, server, "separation", "recall")
    for words in (knob.label("en"), knob.label("zh")):
        page.keyboard.press("Control+k")
        page.get_by_placeholder("Search commands...").fill(words)
        page.locator(".mantine-Spotlight-action").first.wait_for()
        page.keyboard.press("Enter")
        page.wait_for_function("words => document.activeElement?.getAttribute('aria-label')?.startsWith(words)", arg=knob.label("en"))
        page.evaluate("document.activeElement.blur()")


AXES = """() => [...document.querySelectorAll('.uplot')].filter(each => each.checkVisibility()).map(each =>
  each.querySelector('[class*="-stacked"]') !== null || parseFloat(getComputedStyle(each.querySelector('.u-wrap')).marginBottom) < 0)"""


@pytest.mark.parametrize("lesson_id", ["separation", "kalman"])
def test_each_chart_of_a_scene_has_its_own_axis(page: Page, server: str, lesson_id: str) -> None:
    lesson = LESSONS[lesson_id]
    lines = {each.id for each in lesson.figures(lesson.compute(lesson.start())) if isinstance(each, LineFigure)}
    scene = next(each.id for each in lesson.path if lines & {*each.figures})
    opened(page, server, lesson_id, scene)
    page.wait_for_function("() => [...document.querySelectorAll('.uplot')].some(each => each.checkVisibility())")
    assert not any(page.evaluate(AXES))
