"""What holds for every lesson on the screen, on one walk: words, names, widths, console; `--whole` has all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page
from tab import Tab, eventually

from observer_lab.course.knobs import Number
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.print_sizes import RIGHT_COLUMN_PX, RUN_PANEL_PX
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.words import phrases
from observer_lab.session.handlers.playback import PREDICT_FIRST
from observer_lab.text import name_of

GLYPHS = """() => {
  const pen = new OffscreenCanvas(48, 48).getContext('2d', {willReadFrequently: true});
  pen.font = '40px ' + getComputedStyle(document.querySelector('.ol-question') || document.body).fontFamily;
  return Array.from('观测器极点', sign => {
    pen.clearRect(0, 0, 48, 48); pen.fillText(sign, 2, 42);
    return Array.from(pen.getImageData(0, 0, 48, 48).data).join();
  });
}"""
SPILT = """() => {
  const out = [];
  for (const e of document.querySelectorAll('.ol-question, .ol-note, .ol-caption, .ol-veil, .mantine-Button-label'))
    if (e.clientWidth && e.scrollWidth > e.clientWidth + 1) out.push(e.textContent.slice(0, 60));
  if (document.documentElement.scrollWidth > innerWidth) out.push('the whole page');
  return out;
}"""
UNDRAWN = """() => Array.from(document.querySelectorAll('math'))
  .filter(m => { const b = m.getBoundingClientRect(); return m.checkVisibility() && (b.width < 4 || b.height < 6); })
  .map(m => m.textContent)"""

NAMES = """() => {  // the names of curves: within their chart, off each other, and in place of its key
  const out = [], charts = Object.values(window.__viserTestpoints?.uplots ?? {}).map(held => held.chart)
    .filter(chart => chart.root.isConnected && chart.over.checkVisibility() && chart.over.clientWidth);
  for (const chart of charts) {
    const all = chart.over.getBoundingClientRect(), key = chart.root.querySelector('.u-legend').checkVisibility();
    const words = new Set(chart.series.slice(1).map(series => series.label).filter(Boolean));
    const names = [...chart.over.querySelectorAll('.ol-name')].filter(e => e.checkVisibility())
      .map(e => [e.textContent, e.getBoundingClientRect()]);
    if (words.size <= 4 && key) out.push(`a key below ${[...words]}`);
    for (const [word, box] of names) {
      if (!words.has(word)) out.push(`${word} names nothing`);
      if (box.left < all.left - 1 || box.right > all.right + 1 || box.top < all.top - 1 || box.bottom > all.bottom + 1)
        out.push(`${word} beyond its chart`);
    }
    names.forEach(([a, p], i) => names.slice(i + 1).forEach(([b, q]) => {
      if (Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1 && Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) > 1)
        out.push(`${a} on ${b}`);
    }));
  }
  return out;
}"""
FIGURES = """() => [...document.querySelectorAll('.uplot canvas, .ol-figure > *')].filter(each => each.checkVisibility())
  .map(each => getComputedStyle(each).filter)"""
RUN_PANEL = """() => {  // px: the panel about the clock
  const panels = [...document.querySelectorAll('.mantine-Paper-root')].filter(panel => panel.querySelector('.ol-dim'));
  return Math.min(...panels.map(panel => panel.getBoundingClientRect().width));
}"""
COLUMN = "() => Math.round(document.querySelector('[data-dock-region=right]')?.getBoundingClientRect().width ?? -1)"


def blurred(tab: Tab) -> tuple[int, int]:
    """How many of the open tab's figures are under the veil, and how many are not."""
    seen = tab.page.evaluate(FIGURES)
    return sum("blur" in each for each in seen), sum("blur" not in each for each in seen)


def in_the_tab_that_answers(tab: Tab, lesson: Lesson, language: str) -> tuple[int, int]:
    """The same with the tab open whose figure answers the first question."""
    answering = next(figure for figure in lesson.figures(lesson.compute(lesson.start())) if figure.id == lesson.answering)
    tab.page.get_by_role("tab", name=answering.tab(language), exact=True).press("Enter")
    found = eventually(lambda: blurred(tab), any, "figures of that tab")
    tab.page.evaluate("document.activeElement.blur()")  # so that keys mean the run
    return found


def move_a_slider(tab: Tab, lesson: Lesson, language: str) -> None:
    """Move the lesson's sliders, one after the other, until a figure follows."""
    start, before, moved = lesson.start(), tab.shown(), []
    for knob in lesson.knobs:
        if isinstance(knob, Number) and lesson.shown(knob, start):
            tab.slide(label_of(knob, language), "ArrowLeft" if start[knob.name] >= knob.high else "ArrowRight", 4)
            moved.append(knob.name)
            tab.answered(rests=True)
            if tab.shown() != before:
                return
    eventually(tab.shown, lambda shown: shown != before, f"a figure follows one of the sliders {moved}")


def fields_that_say_something_else(tab: Tab, lesson: Lesson, language: str) -> list[str]:
    """Knobs in sight whose number field does not hold their value, whatever their slider moves in."""
    start, wrong = lesson.start(), []
    for knob in lesson.knobs:
        if isinstance(knob, Number) and not knob.hidden and knob.name not in lesson.aside and lesson.shown(knob, start):
            seen = tab.value(label_of(knob, language))
            if seen != pytest.approx(start[knob.name], rel=5e-3, abs=1e-9):
                wrong.append(f"{knob.name}: {seen} for {start[knob.name]}")
    return wrong


def look_at(tab: Tab, lesson: Lesson, language: str, path: Path | None = None) -> None:
    """On the whole screen nothing spills and every equation is drawn; keep a picture of it."""
    words: Any = lesson.words[language]
    eventually(tab.question, lambda seen: seen == words.question, f"the question in {language}")
    tab.answered(rests=True)
    tab.close_any_notices()
    if path is not None:
        tab.picture(path)
    assert tab.page.evaluate(SPILT) == []
    assert tab.page.evaluate(UNDRAWN) == []
    eventually(lambda: tab.page.evaluate(NAMES), lambda wrong: not wrong, "names of curves in their places")
    eventually(
        lambda: tab.page.evaluate(COLUMN), lambda wide: wide == -1 or abs(wide - RIGHT_COLUMN_PX) < 8, "the figures' column has its width"
    )
    eventually(lambda: tab.page.evaluate(RUN_PANEL), lambda wide: abs(wide - RUN_PANEL_PX) < 30, "the run's panel has its width")
    assert tab.page.locator("math").count() > 0, "no equation on the page"


@pytest.mark.parametrize("lesson", LESSONS.values(), ids=LESSONS)
def test_a_lesson_from_the_question_to_the_run(lesson: Lesson, walking: Tab, artefacts: Path) -> None:
    """Veiled until predicted, answering to a slider, playing after the prediction, sound in both languages.

    It is played in the language in which the walk arrives, and looked at in the other one last: each lesson the other way round.
    """
    tab = walking
    now, then = ("en", "zh") if tab.language() == "en" else ("zh", "en")
    tab.page.set_viewport_size({"width": 1366, "height": 768})
    tab.choose_lesson(lesson.words[now].title, lesson.words[now].question, phrases.LESSON(now))
    veiled, open_ones = in_the_tab_that_answers(tab, lesson, now)
    assert veiled and not open_ones, "all of the tab that answers is veiled"

    def refused() -> str:
        tab.key("Space")  # again, where the key came while the page was being laid out
        return tab.notices()
    assert PREDICT_FIRST(now) in eventually(refused, bool, "a sentence that says why nothing plays")
    assert tab.clock() == 0.0
    assert fields_that_say_something_else(tab, lesson, now) == []
    move_a_slider(tab, lesson, now)
    tab.predict("B")
    eventually(lambda: blurred(tab), lambda found: found[0] == 0 < found[1], "the veil is lifted")
    assert phrases.YOU_PREDICTED.format(letter="B")(now) in tab.page.locator("body").inner_text()
    eventually(tab.clock, lambda t: t > 0.0, "the run plays")
    tab.press(phrases.RESET(now))
    tab.press(phrases.KICK(now) if lesson.kick else phrases.PLAY(now))
    eventually(tab.clock, lambda t: t > 0.1, "the run plays again")
    tab.button(phrases.PAUSE(now)).or_(tab.button(phrases.PLAY(now))).first.click()
    look_at(tab, lesson, now, artefacts / f"{lesson.number:02d}-{lesson.id}-{now}.png")
    tab.press(name_of(then))
    look_at(tab, lesson, then)  # pictures of all sizes, themes and tabs: tests/benchmarks/bench_sight.py


def test_chinese_signs_are_drawn(blank: Page) -> None:
    """Where a font is missing all of them are the same box."""
    glyphs = blank.evaluate(GLYPHS)
    assert len(set(glyphs)) == len(glyphs)
