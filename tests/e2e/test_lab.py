"""The lab in a browser: verdicts grow stale, nothing that has just come lies under the pinned knobs, a fixed cross says so."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from axe_rules import serious
from geometry import drag, on_screen
from tab import Tab, eventually

from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.words import phrases

LINE_PX = 34  # of a closed folder with what stands clear around it
COVERED = """name => {  // how many points of the last such element cannot be seen: under something else, or out of the window
  const shown = [...document.querySelectorAll(name)].filter(each => each.checkVisibility());
  if (!shown.length) return 'nothing there';
  const box = shown.at(-1).getBoundingClientRect(), low = Math.min(4, box.height / 2);
  return [box.top + low, (box.top + box.bottom) / 2, box.bottom - low]
    .filter(y => !shown.at(-1).contains(document.elementFromPoint(box.left + Math.min(40, box.width / 2), y))).length;
}"""
VEIL = """() => ['.uplot canvas', '.ol-figure svg'].flatMap(name => [...document.querySelectorAll(name)])
  .filter(each => each.checkVisibility()).map(each => getComputedStyle(each).filter)"""
FORMULAS = """() => [...document.querySelectorAll('.ol-formula')].filter(each => each.checkVisibility())
  .map(each => getComputedStyle(each).filter)"""
CLOSED = """() => [...document.querySelectorAll('[role=button][aria-expanded=false]')].filter(head => head.checkVisibility()).map(head => {
  const box = head.parentElement, room = getComputedStyle(box);
  return [head.textContent, box.offsetHeight + parseFloat(room.marginTop) + parseFloat(room.marginBottom)];
})"""
FIELDS = """() => [...document.querySelectorAll('input:not([type=range])')]
  .filter(field => field.checkVisibility() && field.getClientRects().length)
  .filter(field => /[.,]0+$/.test(field.value) || field.scrollWidth > field.clientWidth + 1).map(field => field.value)"""
BUBBLES = "() => [...document.querySelectorAll('.mantine-Slider-label')].filter(each => each.checkVisibility()).length"
SETTINGS = """() => [...document.querySelectorAll('input')].filter(field => field.value.startsWith('ws://')).map(field => {
  const folded = field.closest('[style*="display: none"]');  // none while a busy page has not come to the end of its folding
  if (folded) folded.style.display = 'block';
  const reached = field.checkVisibility();
  if (folded) folded.style.display = 'none';
  return reached;
})"""
SIGHT = "() => window.__viserMutable.camera.matrixWorldInverse.toArray()"


def told(tab: Tab, words: str) -> None:
    """Wait until a sentence is told; it goes away by itself some seconds later."""
    eventually(tab.notices, lambda said: words in said, words)


def opened(tab: Tab, name: str, size: tuple[int, int] = (1366, 768)) -> None:
    """A lesson whose prediction is skipped."""
    words = LESSONS[name].words["en"]
    tab.open_lesson(words.title, words.question, size)
    if tab.page.locator(".ol-veil").count():
        tab.predict("skip")
        tab.reveal()


def test_a_verdict_on_another_design_is_grey_and_says_so_until_that_design_is_back(walking: Tab) -> None:
    opened(walking, "separation")
    walking.unfold(phrases.TASKS("en"))
    walking.page.evaluate("document.activeElement.blur()")
    walking.key("t")
    verdict, since = walking.page.locator(".ol-wrong"), walking.page.get_by_text(phrases.DESIGN_CHANGED("en"))
    eventually(verdict.count, lambda n: n == 1, "a verdict")
    plain = verdict.evaluate("each => getComputedStyle(each).color")
    assert since.count() == 0
    walking.slide(label_of(LESSONS["separation"].knob("stiffness_error"), "en"))
    eventually(since.count, lambda n: n == 1, "the sentence that the design has changed")
    assert verdict.evaluate("each => getComputedStyle(each).color") != plain
    walking.page.evaluate("document.activeElement.blur()")
    while since.count():
        walking.key("z")
    assert verdict.evaluate("each => getComputedStyle(each).color") == plain


def test_the_settings_of_visers_own_are_out_of_reach(walking: Tab) -> None:
    assert walking.page.evaluate(SETTINGS) == [False]


@pytest.mark.parametrize("size", [(1366, 768), (1280, 720)], ids=str)
@pytest.mark.parametrize("name", ["separation", "virtual-sensor", "lqg"])
def test_the_pinned_knobs_cover_neither_options_nor_what_has_just_been_said(
        new_tab: Callable[..., Tab], name: str, size: tuple[int, int]) -> None:
    lesson, words, tab = LESSONS[name], LESSONS[name].words["en"], new_tab(*size)
    tab.open_lesson(words.title, words.question, size)
    if tab.page.locator(".ol-veil").count():
        tab.predict("ABCD"[(lesson.answer + 1) % len(words.options)])
        tab.reveal()
        eventually(lambda: tab.page.evaluate(COVERED, ".ol-wrong"), lambda points: points == 0, "the verdict of the prediction in sight")
    tab.unfold(phrases.TASKS("en"))
    tab.page.evaluate("document.activeElement.blur()")
    tab.key("t")
    eventually(lambda: tab.page.evaluate(COVERED, ".ol-wrong"), lambda points: points == 0, "the verdict of a task in sight")


def test_a_second_question_comes_clear_of_the_knobs(walking: Tab) -> None:
    lesson = LESSONS["error-dynamics"]
    opened(walking, lesson.id)
    walking.type_number(label_of(lesson.knob("guess_q"), "en"), "-1")
    eventually(lambda: walking.page.evaluate(COVERED, ".ol-again"), lambda points: points == 0, "the second question in sight")


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_a_veil_hides_in_either_theme(new_tab: Callable[..., Tab], theme: str) -> None:
    tab = new_tab(1366, 768)
    for name in ("duality", "separation"):  # figures drawn as SVG, and charts
        lesson = LESSONS[name]
        words, figures = lesson.words["en"], lesson.figures(lesson.compute(lesson.start()))
        tab.choose_lesson(words.title, words.question)
        if tab.button(theme).count():
            tab.press(theme)
        answer = next(figure for figure in figures if figure.id == lesson.answering)
        other = next(figure for figure in figures if figure.id not in lesson.veil)
        for figure, veiled in ((answer, True), (other, False)):
            tab.page.get_by_role("tab", name=figure.tab("en"), exact=True).press("Enter")
            found = eventually(lambda: tab.page.evaluate(VEIL), bool, "figures")
            assert all(("blur" in filters) == veiled for filters in found), (name, theme, found)
        assert all("blur" in filters for filters in eventually(lambda: tab.page.evaluate(FORMULAS), bool, "equations"))
    tab.predict("skip")
    assert not any("blur" in filters for script in (VEIL, FORMULAS) for filters in tab.page.evaluate(script))
    if tab.button("light").count():
        tab.press("light")


@pytest.mark.parametrize("name", ["showdown", "kalman", "arm"])
def test_closed_folders_take_a_line_and_fields_show_short_numbers_without_bubbles(walking: Tab, name: str) -> None:
    opened(walking, name)
    closed = walking.page.evaluate(CLOSED)
    assert len(closed) > 5 and max(high for _, high in closed) <= LINE_PX, closed
    walking.unfold()
    walking.answered(rests=True)
    assert walking.page.evaluate(FIELDS) == []
    walking.page.get_by_role("slider").first.hover()
    assert walking.page.evaluate(BUBBLES) == 0


def test_a_cross_that_no_hand_can_move_says_so_and_the_camera_stays(walking: Tab) -> None:
    opened(walking, "lqg")
    seen = walking.page.evaluate(SIGHT)
    board = next(board for board in LESSONS["lqg"].compute(LESSONS["lqg"].start()).boards if board.knob is None and board.poles)
    drag(walking, on_screen(walking, f"/board/{board.id}/pole0"), (-30.0, 20.0), look=lambda: told(walking, phrases.COMPUTED_POLES("en")))
    assert walking.page.evaluate(SIGHT) == pytest.approx(seen)
    walking.close_any_notices()
    opened(walking, "hidden-modes")
    board = next(board for board in LESSONS["hidden-modes"].compute(LESSONS["hidden-modes"].start()).boards if board.fixed)
    drag(walking, on_screen(walking, f"/board/{board.id}/bolt0"), (-30.0, 20.0), look=lambda: told(walking, phrases.FIXED_POLE("en")))
    walking.close_any_notices()


HINTS = "() => [...document.querySelectorAll('[data-ol-hint]')].filter(each => each.checkVisibility({visibilityProperty: true})).length"
IN_SIGHT = """() => [...document.querySelectorAll('.ol-option:enabled')].filter(each => each.checkVisibility()).map(each => {
  const box = each.getBoundingClientRect();
  return box.top > 0 && box.bottom <= innerHeight && each.contains(document.elementFromPoint(box.left + 20, box.top + box.height / 2));
})"""


def test_what_explains_a_control_goes_while_one_is_pressed(walking: Tab) -> None:
    opened(walking, "noise")
    knob = walking.thumb(label_of(LESSONS["noise"].knob("speed"), "en"))
    knob.scroll_into_view_if_needed()
    knob.hover()
    eventually(lambda: walking.page.evaluate(HINTS), lambda n: n > 0, "the hint of a knob under the pointer")
    walking.page.mouse.down()
    assert walking.page.evaluate(HINTS) == 0
    walking.page.mouse.up()


@pytest.mark.parametrize("name", ["noise", "separation"])
def test_on_a_phone_the_question_comes_first_and_an_option_is_on_the_first_screen(new_tab: Callable[..., Tab], name: str) -> None:
    tab, words = new_tab(390, 844), LESSONS[name].words["en"]
    tab.choose_lesson(words.title, words.question)
    seen = eventually(lambda: tab.page.evaluate(IN_SIGHT), bool, "options")
    assert seen[:2] == [True, True], seen
    question, lists = (tab.page.locator(part).first.bounding_box() for part in (".ol-question", "[data-ol-select]:visible"))
    assert question is not None and lists is not None and question["y"] < lists["y"]


def test_a_column_of_figures_alone_scrolls_by_keys_and_breaks_no_rule_of_accessibility(walking: Tab) -> None:
    opened(walking, "kalman")
    column = walking.page.locator("[data-dock-region=right] [data-scrollarea-viewport]:visible")
    walking.page.get_by_role("tab", name="Consistency").click()
    eventually(lambda: column.evaluate("each => each.scrollHeight - each.clientHeight"), lambda more: more > 40, "a column that scrolls")
    column.focus()
    walking.page.keyboard.press("PageDown")
    eventually(lambda: column.evaluate("each => each.scrollTop"), lambda top: top > 40, "the column scrolled by a key")
    assert serious(walking.page) == []
