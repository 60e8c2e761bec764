"""The page works under the policy it is sent with, its token leaves the address, and no other site shows it in a frame."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from playwright.sync_api import Browser
from tab import Tab, eventually

WORD = "the-word-of-this-test"
SLIDER = "stiffness error in the model [%]"
BLOCKED = "() => { window.blocked = []; addEventListener('securitypolicyviolation', e => window.blocked.push(e.violatedDirective)) }"


def test_a_lesson_works_under_the_policy_and_the_token_leaves_the_address(
        browser: Browser, serve: Callable[..., AbstractContextManager[str]]) -> None:
    with serve(0, "--lesson", "separation", OBSERVER_LAB_TOKEN=WORD, OBSERVER_LAB_KERNELS="off") as address:
        context = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce")
        page = context.new_page()
        page.add_init_script(f"({BLOCKED})()")
        answered: list[tuple[int, str]] = []
        page.on("response", lambda answer: answered.append((answer.status, answer.url)))
        page.goto(f"{address}/?token={WORD}")
        assert page.url.startswith(f"{address}/") and WORD not in page.url
        assert [status for status, _ in answered[:2]] == [303, 200] and WORD not in answered[1][1]
        tab = Tab(page, f"{address}/", drawn=False)
        tab.slide(SLIDER, "ArrowRight", 3)
        eventually(lambda: tab.value(SLIDER), lambda value: value == 3.0, "the slider")
        assert page.evaluate("window.blocked") == [] and tab.complaints == []
        frame = context.new_page()
        frame.goto("about:blank")
        frame.set_content(f'<iframe src="{address}/"></iframe>')
        frame.wait_for_timeout(500)
        assert all("lab" not in (shown.title() or "").lower() for shown in frame.frames[1:])
        context.close()
