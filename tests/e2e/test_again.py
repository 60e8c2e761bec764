"""The second prediction on the page: it comes with its knob, veils what would answer it and nothing else, and can be answered."""

from __future__ import annotations

from tab import Tab, eventually

from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.words import phrases

GUESS = label_of(LESSONS["error-dynamics"].knob("guess_q"), "en")
BLURRED = """figure => [...document.querySelectorAll(`.uplot:has([class*=":${figure}:"]) canvas, .ol-figure[data-figure="${figure}"] > *`)]
    .map(part => getComputedStyle(part).filter.includes('blur'))"""


def blurred(tab: Tab, figure: str) -> bool:
    """Whether a figure is veiled; all of its parts are, or none."""
    found = eventually(lambda: tab.page.evaluate(BLURRED, figure), bool, f"the figure {figure}")
    assert len(set(found)) == 1, found
    return found[0]


def test_a_second_prediction_veils_its_figures_until_an_option_is_chosen(walking: Tab) -> None:
    lesson, tab = LESSONS["error-dynamics"], walking
    words = lesson.words["en"]
    asked = words.again
    assert asked is not None and lesson.again is not None
    tab.open_lesson(words.title, words.question, (1280, 900))
    tab.predict("skip")
    tab.page.get_by_role("tab", name="Error", exact=True).click()
    question = tab.page.get_by_text(asked.question[:40])
    assert question.count() == 0 and not blurred(tab, "error")
    tab.type_number(GUESS, "-1")
    eventually(question.count, lambda n: n == 1, "the second question")
    assert blurred(tab, "error")
    assert tab.page.locator('.ol-caption[data-figure="error"]').evaluate("p => getComputedStyle(p).visibility") == "hidden"
    tab.page.get_by_role("tab", name="Time", exact=True).click()
    assert not blurred(tab, "state0") and not blurred(tab, "force"), "what does not answer stays"
    tab.page.locator(".ol-option:enabled").nth(0).click()
    tab.answered(rests=True)
    tab.page.get_by_role("tab", name="Error", exact=True).click()
    assert not blurred(tab, "error") and tab.page.get_by_text("The run says C.").count() == 1
    tab.press(phrases.TRY_IT("en"))
    assert tab.value(GUESS) == -1.0 and not blurred(tab, "error")
