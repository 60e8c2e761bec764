"""The guide in a browser: what a scene shows is in sight, what it asks for can be done, and its dialogs have an exit."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

import pytest
from axe_rules import serious
from playwright.sync_api import Page, expect
from sight import question_faults
from tab import ANSWERED, eventually

from observer_lab.course.lectures import PREPARED_FOLDER, read_lecture
from observer_lab.lessons import LESSONS
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

PATIENCE = 60_000  # ms: a busy machine is slow
SIZES = ((1366, 768), (1280, 720), (1920, 1080), (390, 844))
STAGE, STAGE_ON_A_PHONE = 0.6, 0.4  # least share of the window
MEASURE = """() => {
  const box = name => document.querySelector(name).getBoundingClientRect(), stage = box('canvas[data-engine]');
  const card = ['.ol-card', '.ol-answer', '.ol-way'].map(box), sheet = innerWidth < 897 ? box('.ol-head').top : stage.height;
  return {stage: stage.width * Math.min(stage.height, sheet) / (innerWidth * innerHeight), high: innerHeight, wide: innerWidth,
          top: Math.min(...card.map(r => r.top)), bottom: Math.max(...card.map(r => r.bottom)),
          left: Math.min(...card.map(r => r.left)), right: Math.max(...card.map(r => r.right))};
}"""
NAMELESS = """() => [...document.querySelectorAll('button')]
  .filter(b => b.checkVisibility({visibilityProperty: true, opacityProperty: true}) && b.getBoundingClientRect().width > 0)
  .filter(b => !(b.innerText.trim() || b.getAttribute('aria-label') || b.title)).map(b => b.outerHTML.slice(0, 120))"""
LECTURE = PREPARED_FOLDER / "demo-10.toml"
ANEW = """() => { const question = document.querySelector('.ol-sketch').parentElement; question.innerHTML = question.innerHTML; }"""
THEMES = (("light", "en"), ("dark", "zh"))


@pytest.fixture
def opened(guide_page: Callable[..., Page], guide: str) -> Callable[..., Page]:
    """Opens the guide of a lesson in a window of some size and theme, at its first scene or at one that is named."""
    def make(name: str = "separation", language: str = "en", size: tuple[int, int] = SIZES[0], dark: bool = False, scene: str = "") -> Page:
        lesson, page = LESSONS[name], guide_page(*size, dark=dark)
        saved = SavedState(lesson.start(), language, mode="guide", scene=scene or lesson.path[0].id)
        return shown(page, f"{guide}#{write_token(lesson, saved)}")
    return make


def shown(page: Page, address: str) -> Page:
    """The page of an address, once its scene stands."""
    page.goto(address)
    page.wait_for_selector(".ol-scene", timeout=PATIENCE)
    expect(page.locator(".ol-cover")).to_be_hidden(timeout=PATIENCE)
    return page


def answer(page: Page, right: int) -> None:
    """Choose an option, and wait for the verdict in the card."""
    page.locator(".ol-option").nth(right).click(timeout=PATIENCE)
    expect(page.locator(".ol-answer .ol-right, .ol-answer .ol-wrong")).to_be_visible(timeout=PATIENCE)


def turn(page: Page, scene: str) -> None:
    """Go on, and wait for the scene."""
    page.locator(".ol-way button").last.click(timeout=PATIENCE)
    stands(page, scene)


def stands(page: Page, scene: str) -> None:
    """Wait for the card of a scene and for its last figure: a column that is still being filled cannot slide."""
    expect(page.locator(f".ol-card[data-scene={scene}]")).to_be_visible(timeout=PATIENCE)
    eventually(lambda: page.evaluate(ANSWERED, True), lambda said: said is True, f"the whole of the scene {scene!r}")


@pytest.mark.parametrize("sizes", [SIZES[:-1], SIZES[-1:]], ids=["wide", "phone"])
@pytest.mark.parametrize(("theme", "language"), THEMES)
def test_stage_and_card_are_in_sight(opened: Callable[..., Page], sizes: tuple[tuple[int, int], ...], theme: str, language: str) -> None:
    page = opened("separation", language, sizes[0], dark=theme == "dark", scene="recall")
    answer(page, 1)
    for width, height in sizes:
        page.set_viewport_size({"width": width, "height": height})
        eventually(lambda: page.evaluate(MEASURE), lambda found, wide=width, high=height: (found["wide"], found["high"]) == (wide, high)
                   and found["stage"] >= (STAGE_ON_A_PHONE if wide < 897 else STAGE)
                   and found["top"] >= 0 and found["left"] >= 0 and found["bottom"] <= high and found["right"] <= wide,
                   f"stage and card in sight at {width}×{height}")


def test_on_a_phone_a_long_verdict_is_in_sight(opened: Callable[..., Page]) -> None:
    """The options that were neither chosen nor right make room for it."""
    page = opened(size=SIZES[-1])
    for scene in LESSONS["separation"].path[1:7]:
        turn(page, scene.id)
    answer(page, 1)
    found = page.evaluate(MEASURE)
    assert found["bottom"] <= found["high"] and found["stage"] >= STAGE_ON_A_PHONE, found
    expect(page.locator(".ol-option:visible")).to_have_count(2)


def test_the_card_of_another_scene_begins_at_its_top_in_a_hall_too(opened: Callable[..., Page]) -> None:
    """However far a hand has slid the column, and though figures there snap to its edge in the lab."""
    page, path = opened("observability", size=SIZES[1]), LESSONS["observability"].path
    page.get_by_role("button", name="Present", exact=True).click(timeout=PATIENCE)
    page.wait_for_selector(".ol-present", state="attached", timeout=PATIENCE)
    expect(page.locator(".ol-cover")).to_be_hidden(timeout=PATIENCE)
    eventually(lambda: page.evaluate(ANSWERED, True), lambda said: said is True, "the page for a hall")
    at = next(k for k, scene in enumerate(path) if len(scene.figures) == 2)
    turn(page, path[1].id)
    page.locator(".ol-dot").nth(at).click(timeout=PATIENCE)
    stands(page, path[at].id)
    page.locator(".ol-card").hover()
    page.mouse.wheel(0, 2000)
    slid = "() => document.querySelector('.ol-card').closest('[data-ol-view]').scrollTop"
    page.wait_for_function(f"({slid})() > 50", timeout=PATIENCE)
    page.locator(".ol-way button").first.click(timeout=PATIENCE)
    expect(page.locator(f".ol-card[data-scene={path[at - 1].id}]")).to_be_visible(timeout=PATIENCE)
    page.wait_for_function(f"({slid})() === 0", timeout=PATIENCE)


def test_a_newcomer_starts_and_the_page_performs_what_was_predicted(guide_page: Callable[..., Page], guide: str) -> None:
    page = shown(guide_page(), guide)
    page.locator(".ol-begin .ol-next").click(timeout=PATIENCE)
    expect(page.locator(".mantine-Modal-content")).to_have_count(0, timeout=PATIENCE)
    assert page.locator(".ol-card").is_visible()


def test_a_prediction_is_performed_before_its_verdict(opened: Callable[..., Page]) -> None:
    page, path = opened(), LESSONS["separation"].path
    for scene in path[1:4]:
        turn(page, scene.id)
    assert page.locator(".ol-answer").inner_text().strip() == ""
    answer(page, 0)
    assert "B" in page.locator(".ol-answer .ol-wrong").inner_text()
    expect(page.locator(".ol-option.ol-chosen")).to_have_count(1)


def test_a_dialog_closes_by_escape_by_its_cross_and_by_a_press_beside_it(opened: Callable[..., Page]) -> None:
    page = opened()
    dialog = page.locator(".mantine-Modal-content")
    for close in (lambda: page.keyboard.press("Escape"), page.locator(".ol-close").click, lambda: page.mouse.click(5, 5)):
        page.locator(".ol-menu").click(timeout=PATIENCE)
        expect(dialog).to_have_count(1, timeout=PATIENCE)
        expect(page.locator(".ol-close")).to_be_visible(timeout=PATIENCE)
        close()
        expect(dialog).to_have_count(0, timeout=PATIENCE)


def test_a_term_is_explained_where_it_stands_by_pointer_key_and_tap_and_in_a_list(opened: Callable[..., Page]) -> None:
    page = opened()
    term, tip = page.locator(".ol-card .ol-term").first, page.locator("#ol-tip")
    ways = (term.hover, lambda: page.mouse.move(300, 300)), (term.focus, term.blur), (term.click, lambda: page.keyboard.press("Escape"))
    for show, hide in ways:
        show()
        expect(tip).to_be_visible(timeout=PATIENCE)
        assert len(tip.inner_text().split()) >= 15 and tip.locator("math").count() == 1
        hide()
        expect(tip).to_be_hidden(timeout=PATIENCE)
    page.locator(".ol-more summary").click()
    page.locator(".ol-item[data-value=terms]").click()
    expect(page.locator(".ol-terms dt")).to_have_count(len(LESSONS["separation"].words["en"].glossary.entries), timeout=PATIENCE)


def test_the_switch_between_guide_lab_and_present_is_in_sight_in_all_of_them(opened: Callable[..., Page]) -> None:
    page = opened()
    for mode, sign in (("lab", ".ol-question"), ("present", ".ol-present"), ("lab", ".ol-question"), ("guide", ".ol-card")):
        page.locator(f".ol-mode[data-value='mode:{mode}']").click(timeout=PATIENCE)
        expect(page.locator(sign).first).to_be_visible(timeout=PATIENCE)
        expect(page.locator(f".ol-mode[data-value='mode:{mode}']")).to_have_attribute("aria-pressed", "true", timeout=PATIENCE)
        assert "WebGL" not in page.inner_text("body")


def test_nothing_of_the_frame_that_has_no_name_or_address_shows(opened: Callable[..., Page]) -> None:
    page = opened()
    assert page.evaluate(NAMELESS) == []
    assert "ws://" not in page.inner_text("body") and "WebGL" not in page.inner_text("body")


SMALL_PRINT = """() => {
  const least = innerHeight / 40, seen = e => e.checkVisibility({visibilityProperty: true, opacityProperty: true});
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const found = [];
  while (walk.nextNode()) {
    const e = walk.currentNode.parentElement, size = parseFloat(getComputedStyle(e).fontSize);
    if (walk.currentNode.data.trim() && !e.closest('style, script, svg, canvas, math') && seen(e) && e.getBoundingClientRect().width > 1
        && size < least - 0.01) found.push(`${size.toFixed(1)} px: ${e.className}: ${walk.currentNode.data.trim().slice(0, 40)}`);
  }
  return found;
}"""


@pytest.mark.parametrize("language", ["en", "zh"])
def test_a_lecture_is_given_in_letters_for_a_hall_with_notes_in_a_window_of_their_own(
        still_page: Callable[..., Page], serve: Callable[..., AbstractContextManager[str]], language: str) -> None:
    with serve(0, "--view", "guide", "--lecture", str(LECTURE), "--lang", language) as address:
        give_a_lecture(shown(still_page(1920, 1080), address), language)


def give_a_lecture(page: Page, language: str) -> None:
    """To its second stop, by a key in the window of the notes."""
    expect(page.locator(".ol-where span").first).to_have_text("1/7", timeout=PATIENCE)
    assert page.evaluate(SMALL_PRINT) == []
    page.locator(".ol-more summary").click()
    with page.expect_popup() as popup:
        page.locator(".ol-notes").click()
    notes = popup.value
    expect(notes.locator("#clock")).to_contain_text("/ 10 min", timeout=PATIENCE)
    first = notes.locator("#note").inner_text()
    assert first == read_lecture(LECTURE.read_text("utf-8"), LESSONS).stops[0].note[language]
    notes.keyboard.press("ArrowRight")
    expect(page.locator(".ol-where span").first).to_have_text("2/7", timeout=PATIENCE)
    expect(notes.locator("#note")).not_to_have_text(first, timeout=PATIENCE)
    expect(page.locator(".ol-more[open]")).to_have_count(0)
    answer(page, 0)
    assert page.evaluate(SMALL_PRINT) == []
    eventually(lambda: question_faults(page, hall=True), lambda bad: not bad, "the question's figure in a hall's letters, wholly in sight")


@pytest.mark.parametrize("size", [SIZES[0], SIZES[-1]], ids=["wide", "phone"])
def test_the_rules_of_accessibility_find_nothing_serious(opened: Callable[..., Page], size: tuple[int, int]) -> None:
    page = opened(size=size)
    assert serious(page) == []
    page.locator(".ol-menu").click(timeout=PATIENCE)
    expect(page.locator(".ol-close")).to_be_visible(timeout=PATIENCE)
    assert serious(page) == []


def test_a_term_that_comes_under_a_resting_pointer_covers_no_verdict(opened: Callable[..., Page]) -> None:
    page = opened()
    box = page.locator(".ol-card").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.up()
    page.evaluate("""([x, y]) => document.body.append(Object.assign(document.createElement('span'), {className: 'ol-term', title: 'said',
      textContent: 'a term', style: `position:fixed;z-index:9999;left:${x - 40}px;top:${y - 20}px;width:80px;height:40px`}))""", [x, y])
    page.evaluate("() => new Promise(done => setTimeout(done, 400))")
    expect(page.locator(".ol-tip")).to_be_hidden()
    page.mouse.move(x + 8, y)
    expect(page.locator(".ol-tip")).to_have_text("said", timeout=PATIENCE)


def test_a_prediction_is_drawn_with_the_mouse_and_with_keys(opened: Callable[..., Page]) -> None:
    """A curve drawn into the figure answers the question: the verdict says how near it is, and the figure keeps it beside the run.

    The figure may come anew while a hand draws: hand and keys go on in it.
    """
    page = opened(scene="recall")
    plot = page.locator(".ol-sketch svg")
    box = plot.bounding_box(timeout=PATIENCE)
    assert box is not None
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 0.3 * box["height"])
    page.mouse.down()
    for k in range(1, 9):
        if k == 3:
            page.evaluate(ANEW)
        page.mouse.move(box["x"] + (0.25 + 0.08 * k) * box["width"], box["y"] + min(0.3 + 0.09 * k, 0.8) * box["height"])
    page.mouse.up()
    send = page.locator(".ol-sketch button")
    expect(send).to_be_enabled(timeout=PATIENCE)
    send.click(timeout=PATIENCE)
    expect(page.locator(".ol-answer")).to_contain_text("Your drawing is nearest to answer", timeout=PATIENCE)
    expect(page.locator('.ol-figure[data-figure="question"]')).to_contain_text("you", timeout=PATIENCE)
    expect(page.locator(".ol-sketch")).to_have_count(0, timeout=PATIENCE)

    names = [scene.id for scene in LESSONS["separation"].path]
    page.locator(".ol-dot").nth(names.index("surprise")).click(timeout=PATIENCE)
    page.wait_for_selector(".ol-card[data-scene=surprise]", timeout=PATIENCE)
    plot = page.locator(".ol-sketch svg")
    plot.focus(timeout=PATIENCE)
    for key in ("ArrowDown", "ArrowRight", "ArrowUp"):
        page.keyboard.press(key)
        page.evaluate(ANEW)
    expect(page.locator(".ol-sketch button")).to_be_enabled(timeout=PATIENCE)
    page.keyboard.press("Enter")
    expect(page.locator(".ol-answer")).to_contain_text("Your drawing is nearest to answer", timeout=PATIENCE)


def test_a_diagram_moves_with_the_run_lights_its_equations_and_opens_its_loop(opened: Callable[..., Page]) -> None:
    page = opened("virtual-sensor", scene="why")
    said = page.locator(".ol-wire text").nth(1)
    expect(said).to_contain_text("y = ", timeout=PATIENCE)
    before = said.text_content()
    page.get_by_role("button", name="▶").first.click(timeout=PATIENCE)
    expect(said).not_to_have_text(before or "", timeout=PATIENCE)
    page.locator(".ol-diagram [data-block=observer]").hover(timeout=PATIENCE)
    expect(page.locator(".ol-law[data-block=observer].ol-lit")).to_be_visible(timeout=PATIENCE)
    page.locator(".ol-law[data-block=plant]").focus(timeout=PATIENCE)
    expect(page.locator(".ol-diagram [data-block=plant].ol-lit")).to_be_visible(timeout=PATIENCE)
    press = page.locator(".ol-law[data-block=L] button")
    expect(press).to_contain_text("θ = 0", timeout=PATIENCE)
    press.click(timeout=PATIENCE)
    expect(press).to_contain_text("θ = 1", timeout=PATIENCE)
    expect(page.locator(".ol-diagram [data-block=L] rect")).to_have_attribute("stroke-dasharray", "5 4", timeout=PATIENCE)


LANDMARKS = """() => [document.querySelectorAll("main,[role=main]").length,
  document.querySelectorAll("h1,[role=heading][aria-level='1']").length]"""
LOW = """names => [...document.querySelectorAll(names)].filter(each => each.checkVisibility() && each.getBoundingClientRect().height < 43.5)
  .map(each => `${each.getBoundingClientRect().height} ${each.outerHTML.slice(0, 60)}`)"""
PRESSED = ".ol-next, .ol-way .ol-do, .ol-option, .ol-dot, .ol-menu, .ol-mode, .ol-more summary, .ol-pull input"


def test_the_focus_goes_to_the_verdict_of_an_answer_by_keys(opened: Callable[..., Page]) -> None:
    page = opened(scene="recall")
    eventually(lambda: page.evaluate(LANDMARKS), lambda found: found == [1, 1], "one main part and one first heading")
    page.locator(".ol-option").nth(1).focus()
    page.keyboard.press("Enter")
    eventually(lambda: page.evaluate("document.activeElement.className"), lambda name: "ol-answer" in name, "the focus on the verdict")


def test_a_finger_finds_controls_of_44_pixels_on_a_phone(still_page: Callable[..., Page], guide: str) -> None:
    lesson = LESSONS["separation"]
    page = still_page(390, 844, has_touch=True, is_mobile=True)
    for scene in ("meet", "recall"):
        shown(page, f"{guide}#{write_token(lesson, SavedState(lesson.start(), 'en', mode='guide', scene=scene))}")
        page.wait_for_selector(f'.ol-card[data-scene="{scene}"]', timeout=PATIENCE)
        eventually(lambda: page.evaluate(LOW, PRESSED), lambda low: not low, "controls of 44 px")
