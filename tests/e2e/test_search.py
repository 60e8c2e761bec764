"""The page's own search finds what people type, and opens the scene that answers."""

from __future__ import annotations

import json
from collections.abc import Callable

from playwright.sync_api import Page
from sampling import some
from tab import Tab, eventually

from observer_lab.course.search.questions import questions

FIELD = "input.mantine-Spotlight-search, .mantine-Spotlight-search input"
FIRST, AMONG_THREE = 0.9, 1.0  # of the phrases of the list
TYPED = """async phrases => {
  const field = document.querySelector('input.mantine-Spotlight-search, .mantine-Spotlight-search input'), found = {};
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set, frame = () => new Promise(requestAnimationFrame);
  for (const phrase of phrases) {
    set.call(field, phrase);
    field.dispatchEvent(new Event('input', {bubbles: true}));
    await frame();
    await frame();
    found[phrase] = [...document.querySelectorAll('.mantine-Spotlight-action')].slice(0, 3).map(each => each.textContent);
  }
  return found;
}"""


def opened(page: Page) -> None:
    """Open the palette."""
    page.evaluate("() => window.observerLabViser.search()")
    page.wait_for_selector(".mantine-Spotlight-search")


def test_every_phrase_finds_its_question(tab: Tab) -> None:
    entries = questions()["en"].entries
    opened(tab.page)
    wanted = dict(some("phrases find questions", [(phrase, entry.title) for entry in entries for phrase in entry.phrases], 4))
    found = tab.page.evaluate(TYPED, list(wanted))
    later = {phrase: found[phrase][:1] for phrase, title in wanted.items() if not found[phrase] or title not in found[phrase][0]}
    lost = {phrase: found[phrase] for phrase, title in wanted.items() if not any(title in each for each in found[phrase])}
    assert len(later) <= (1 - FIRST) * len(wanted), (len(later), len(wanted), json.dumps(later, indent=1))
    assert len(lost) <= (1 - AMONG_THREE) * len(wanted), lost


def test_a_question_opens_its_scene(tab: Tab) -> None:
    opened(tab.page)
    tab.page.locator(FIELD).fill("latency")
    eventually(lambda: tab.page.locator(".mantine-Spotlight-action").first.inner_text(), lambda said: "latency" in said, "the question")
    tab.page.locator(".mantine-Spotlight-action").first.click()
    eventually(lambda: tab.page.locator(".ol-card").get_attribute("data-scene"), lambda scene: scene == "delay", "its scene")


def test_a_link_opens_without_storage(still_page: Callable[..., Page], server: str, capsys) -> None:
    from observer_lab.cli.entry import main

    assert main(["link", "kalman", "--view", "guide", "--scene", "shrink", "--at", server]) == 0
    page = still_page()
    refuse = "{get() { throw new DOMException('refused', 'SecurityError'); }}"
    page.context.add_init_script(f"for (const name of ['sessionStorage', 'localStorage']) Object.defineProperty(window, name, {refuse});")
    page.goto(capsys.readouterr().out.strip())
    eventually(lambda: page.locator(".ol-card").get_attribute("data-scene"), lambda scene: scene == "shrink", "the scene of the link")
