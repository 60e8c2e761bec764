"""A run that was written as a page plays from its file, with the network off: nothing is asked of anybody."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from all_replays import state_in
from playwright.sync_api import Page, Request
from tab import HARMLESS, eventually

from observer_lab.cli.entry import main
from observer_lab.lessons import LESSONS
from observer_lab.session.state.token import read_token

LESSON, KNOB, VALUE = "error-dynamics", "guess_q", 1.5
ROUNDED = 2e-4  # stage units: places are written to four decimals
PLACES = """() => Object.fromEntries(Object.entries(window.__viserMutable?.nodeRefFromName ?? {})
  .filter(([name]) => /^[/](plant|ghost)[/]/.test(name))
  .map(([name, held]) => [name, (held && 'current' in held ? held.current : held)?.position.toArray()]))"""
CURSORS = "() => Array.from(document.querySelectorAll('.ol-replay-now:not([hidden])'), line => line.getBoundingClientRect().left)"


def moved(before: dict[str, list[float]], now: dict[str, list[float]]) -> set[str]:
    """Of plant and ghost, those of which a part stands elsewhere."""
    return {name.split("/")[1] for name in before if math.dist(now[name], before[name]) > ROUNDED}


def test_a_page_plays_from_its_file_without_a_network(still_page: Callable[..., Page], tmp_path: Path) -> None:
    file, words = tmp_path / "run.html", LESSONS[LESSON].words["zh"]
    assert main(["replay", LESSON, "--set", f"{KNOB}={VALUE}", "--lang", "zh", "--dark", "-o", str(file)]) == 0
    saved = read_token(state_in(file.read_text(encoding="utf-8")), LESSONS)
    assert saved.language == "zh" and saved.design[KNOB] == VALUE
    page, asked, complaints = still_page(900, 560), list[Request](), list[str]()
    page.context.set_offline(True)
    page.on("request", lambda request: asked.append(request))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text)
            if said.type == "error" and not any(word in said.text for word in HARMLESS) else None)
    page.goto(file.as_uri())
    page.wait_for_selector(".ol-replay-wait", state="hidden")
    start = eventually(lambda: page.evaluate(PLACES), lambda found: {name.split("/")[1] for name in found} == {"plant", "ghost"}, "a stage")
    edges, play = page.evaluate(CURSORS), page.locator(".ol-replay-play")
    assert edges and page.locator("html").get_attribute("lang") == "zh"
    assert page.locator("html").get_attribute("data-mantine-color-scheme") == "dark"
    assert words.question in page.inner_text("body") and words.title in page.title() and play.inner_text() == "▶ 播放"
    play.click()
    played = eventually(lambda: page.evaluate(PLACES), lambda now: moved(start, now) == {"plant", "ghost"}, "plant and ghost in motion")
    eventually(lambda: page.evaluate(CURSORS), lambda now: all(x > edge for x, edge in zip(now, edges, strict=True)), "cursors in motion")
    assert play.inner_text() == "‖ 暂停"
    page.locator(".ol-replay-time").press("End")
    eventually(lambda: page.evaluate(PLACES), lambda now: moved(played, now) == {"plant", "ghost"}, "the end of the run")
    assert play.inner_text() == "▶ 播放"
    page.locator(".ol-replay-start").click()
    eventually(lambda: page.evaluate(PLACES), lambda now: not moved(start, now), "the start again")
    assert page.evaluate(CURSORS) == edges
    assert {request.url.split(":")[0] for request in asked} <= {"file", "data", "blob"} and asked[0].url == file.as_uri()
    assert sum(request.url.startswith("file:") for request in asked) == 1
    assert not complaints, complaints
