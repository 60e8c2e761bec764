"""What the frame around the lessons promises: languages, large print, a phone, and one sentence for bad input."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tab import Tab, eventually

from observer_lab.lessons import LESSONS, OPENING
from observer_lab.page.charts.print_sizes import Sizes
from observer_lab.session.state.view import State

SLIDER = "stiffness error in the model [%]"
RUN = "() => document.querySelector('.ol-parts').closest('.mantine-Paper-root').getBoundingClientRect().width"
CLICK = "words => [...document.querySelectorAll('button')].find(b => b.textContent.trim() === words)?.click()"  # if it is there
SIZE = "() => parseFloat(getComputedStyle(document.querySelector('.ol-question')).fontSize)"


def test_the_language_changes_at_run_time_and_the_design_stays(tab: Tab) -> None:
    tab.slide(SLIDER, "ArrowRight", 4)
    eventually(lambda: tab.value(SLIDER), lambda v: v == 4.0, "the slider")
    tab.press("中文")
    eventually(tab.question, lambda words: words == LESSONS[OPENING].words["zh"].question, "the question in Chinese")
    eventually(tab.curves, lambda plots: plots and all(not title.isascii() for title, _ in plots), "the plots in Chinese")
    eventually(lambda: tab.value("模型刚度误差 [%]"), lambda v: v == 4.0, "the slider as it was")
    tab.press("English")
    eventually(tab.question, lambda words: words == LESSONS[OPENING].words["en"].question, "the question in English")


def test_large_print_enlarges_the_whole_frame(new_tab: Callable[..., Tab], artefacts: Path) -> None:
    tab = new_tab(1600, 900)
    before = tab.page.evaluate(SIZE)
    assert tab.page.evaluate(RUN) == Sizes(State(window=(1600.0, 900.0))).run
    tab.press("large print")
    eventually(lambda: tab.page.evaluate(SIZE), lambda size: size > 1.4 * before, "large print")
    tab.picture(artefacts / "lecture.png")
    tab.press("large print")
    eventually(lambda: tab.page.evaluate(SIZE), lambda size: size == before, "normal print")


def test_the_page_opens_on_a_phone(new_tab: Callable[..., Tab], artefacts: Path) -> None:
    tab = new_tab(390, 844)
    assert tab.page.evaluate("document.documentElement.scrollWidth") <= 390
    assert tab.page.locator(".ol-question").is_visible()
    tab.picture(artefacts / "phone.png")


def test_a_number_out_of_bounds_costs_one_sentence_and_nothing_else(tab: Tab) -> None:
    before = tab.shown()
    tab.type_number(SLIDER, "1000000000")
    sentence = eventually(tab.notices, lambda words: "1e+09" in words, "a sentence about the number")
    assert "-30 … 30 %" in sentence
    eventually(lambda: tab.value(SLIDER), lambda v: v == 0.0, "the accepted value comes back")
    assert tab.shown() == before, "the last good picture stays"
    tab.slide(SLIDER, "ArrowRight", 3)
    eventually(tab.shown, lambda shown: shown != before, "the tab still works")


def test_a_slow_machine_draws_the_scene_coarser_while_it_moves_and_sharp_at_rest(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1200, 800, own=True)
    tab.predict("skip")
    tab.key("0")
    tab.drawn()
    tab.page.evaluate("""() => {
        const scene = window.__viserMutable.scene, finest = () => scene.__r3f.root.getState().viewport.dpr;
        window.drawnWith = [];
        scene.onBeforeRender = () => {
          window.drawnWith.push(finest() >= devicePixelRatio);
          const begun = performance.now();
          while (performance.now() - begun < 45);
        }; }""")
    tab.press("▶ play")
    eventually(lambda: tab.page.evaluate("drawnWith.includes(false) && drawnWith.at(-1)"), bool,
               "fewer pixels while it plays, all of them when the run has ended")


def test_the_page_plays_a_run_by_itself(new_tab: Callable[..., Tab]) -> None:
    """The stage and the clock move by poses that came ahead of their time; where the run is stopped, all stand at one moment."""
    tab = new_tab(own=True)
    tab.page.evaluate("""() => {
        const page = window.__viserMutable, seen = page.scene.onAfterRender;
        window.stood = new Set();
        page.scene.onAfterRender = (...all) => {
          seen(...all);
          stood.add(Object.entries(page.nodeRefFromName).filter(([name]) => name.startsWith('/plant/'))
            .map(([, held]) => ('current' in held ? held.current : held)?.position.toArray().join()).join());
        }; }""")
    tab.predict("skip")

    def stopped_on_the_way() -> float:  # again, where a busy machine has come to the end first
        tab.press("slower")
        tab.press("|◀ start")
        tab.page.evaluate(CLICK, "▶ play")
        eventually(lambda: tab.page.evaluate("[observerLabPlayer.count, stood.size]"), lambda seen: min(seen) > 8, "poses of the page")
        tab.page.evaluate(CLICK, "‖ pause")
        tab.answered(rests=True)
        eventually(lambda: tab.page.evaluate("observerLabPlayer.queue.length"), lambda n: n == 0, "no pose that is still to come")
        return tab.clock()
    clock = eventually(stopped_on_the_way, lambda t: 0 < t < 3.0, "a run that is stopped before its end")
    assert abs(tab.value("time t [s]") - clock) < 0.02


def test_without_a_graphics_card_the_scene_is_drawn_without_multisampling(tab: Tab) -> None:
    assert tab.page.evaluate("window.observerLabNoCard") is True, "the tests' browser draws with the processor"
    assert not tab.page.evaluate("window.__viserMutable.scene.__r3f.root.getState().gl.getContextAttributes().antialias")
    assert not tab.page.evaluate("window.__viserMutable.backgroundMaterial.visible"), "no picture behind, nothing drawn"


def test_an_answer_costs_one_frame_of_the_scene(new_tab: Callable[..., Tab]) -> None:
    """viser alone draws two: one for what moved, one for what React changed after that."""
    tab = new_tab(own=True)
    tab.predict("skip")
    tab.page.evaluate(CLICK, "‖ pause")
    tab.answered(rests=True)
    tab.drawn()
    tab.page.evaluate("""() => { const page = window.__viserMutable, state = page.scene.__r3f.root.getState();
        const seen = page.scene.onAfterRender, ask = page.requestRender, draw = state.setDpr;
        window.counted = {drawn: 0, asked: 0, rested: 0, begun: performance.now()};
        page.scene.onAfterRender = (...all) => { counted.drawn += 1; seen(...all); };
        page.requestRender = () => { counted.asked += page.messageQueue.length > 0; ask(); };
        state.setDpr = dpr => { counted.rested += dpr >= devicePixelRatio; draw(dpr); }; }""")
    tab.thumb(SLIDER).focus()
    drawn = asked = rested = seconds = 0
    for turn in range(20):  # a busy machine answers many steps at once
        tab.quick_keys(("ArrowRight", "ArrowLeft")[turn % 2], 9)
        tab.answered(rests=True)
        drawn, asked, rested, seconds = tab.page.evaluate(
            "() => [counted.drawn, counted.asked, counted.rested, (performance.now() - counted.begun) / 1000]")
        if asked >= 3:
            break
    beats = seconds + 1  # viser draws once a second whatever happens
    assert asked >= 3 and drawn <= 1.3 * asked + rested + beats, f"{drawn} frames for {asked} answers, {rested} rests, {beats:.0f} beats"


def test_the_browsers_tab_is_named_after_the_lesson_in_its_language(tab: Tab) -> None:
    words = LESSONS[OPENING].words
    assert tab.page.title() == f"{words['en'].title} · Observer Lab"
    assert tab.page.evaluate("document.documentElement.lang") == "en"
    tab.press("中文")
    eventually(tab.page.title, lambda title: title == f"{words['zh'].title} · Observer Lab", "the title in Chinese")
    assert tab.page.evaluate("document.documentElement.lang") == "zh"
