"""The derivation on the page: hidden until a prediction is made, opened step by step, and left open by new numbers."""

from __future__ import annotations

from tab import Tab, eventually

from observer_lab.lessons import LESSONS


def test_what_was_opened_of_a_derivation_stays_open_while_its_numbers_change(tab: Tab) -> None:
    lesson = LESSONS["error-dynamics"]
    words = lesson.words["en"]
    tab.choose_lesson(words.title, words.question)
    derive, step = tab.page.get_by_text("Derive", exact=True), tab.page.get_by_text(f"3 {words.derivation[2].heading}", exact=True)
    assert derive.count() == 0, "formulas answer the prediction"
    tab.predict("skip")
    eventually(derive.count, lambda n: n == 1, "the derivation")
    derive.click()
    step.click()
    why, line = tab.page.locator(".ol-why:visible"), tab.page.locator(".ol-derived:visible").last
    eventually(why.count, lambda n: n == 1, "the step that was opened")
    why.locator("summary").press("Enter")  # a click may miss what still moves while its folder opens
    eventually(lambda: why.get_attribute("open"), lambda opened: opened is not None, "the reason is open")
    before = eventually(line.inner_text, lambda said: len(said) > 20, "the numbers")
    tab.row("gain by").locator("input").first.click()
    tab.page.get_by_role("option", name="typing numbers", exact=True).click()
    tab.answered(rests=True)
    eventually(line.inner_text, lambda said: len(said) > 20 and said != before, "other numbers")
    assert why.get_attribute("open") is not None and why.count() == 1
