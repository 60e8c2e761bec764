"""A walk through a lab with two workers and an access token: `hub_walk.py --only token`."""

from __future__ import annotations

import json
import subprocess
import sys
import time
import urllib.request

from playwright.sync_api import Browser
from tab import Tab  # type: ignore[import-not-found]
from walks import HERE, KNOB, PATIENCE, Walk, surroundings, window  # type: ignore[import-not-found]


def walk_token(walk: Walk, browser: Browser) -> None:
    """A lab with two workers and a token."""
    server = subprocess.Popen([sys.executable, "-m", "observer_lab", "serve", "--port", "0", "--workers", "2"], cwd=HERE,
                              env=surroundings(), stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    try:
        printed = server.stdout.readline().strip()
        bare = printed.partition("?")[0]
        page = window(browser)
        page.goto(bare)
        page.wait_for_url("**/?again")
        walk.check("without the token there is one sentence", "access token" in page.inner_text("body"), page.inner_text("body"))
        tab = Tab(page, bare, drawn=False) if page.goto(printed) else None
        assert tab is not None
        walk.check("with it the lab opens, and the address bar forgets it", page.url.partition("#")[0] == bare, page.url)
        cookie = page.context.cookies()[0]
        walk.check("the cookie is for requests of this site's own pages",
                   cookie.get("httpOnly") and cookie.get("sameSite") == "Strict", cookie)
        tab.slide(KNOB, "ArrowRight", 4)
        value = tab.value(KNOB)
        places = [figures["tabs"] for figures in health(bare, printed.rpartition("=")[2])]
        second = Tab(page.context.new_page(), bare, drawn=False)
        spread = [figures["tabs"] for figures in health(bare, printed.rpartition("=")[2])]
        walk.check("a second tab of the browser needs no token and is at the other worker", sum(places) == 1 and spread == [1, 1], spread)
        walk.check("and goes on where the first one was, kept by the browser", second.value(KNOB) == value, second.value(KNOB))
        other = page.context.new_page()
        other.route("http://elsewhere.example/", lambda route: route.fulfill(content_type="text/html", body=f'<a href="{bare}">lab</a>'))
        other.goto("http://elsewhere.example/")
        other.click("a")
        other.wait_for_selector(".ol-question", timeout=PATIENCE * 1000)
        walk.check("a link on another site's page opens it too", other.url.partition("#")[0] == bare, other.url)
        walk.check("the browser complained of nothing", not tab.complaints + second.complaints, tab.complaints + second.complaints)
        page.context.close()
        browser_of_others = browser.new_context().new_page()
        browser_of_others.goto(bare)
        walk.check("another browser is turned away", "access token" in browser_of_others.inner_text("body"))
        browser_of_others.context.close()
    finally:
        began = time.monotonic()
        server.terminate()
        walk.check("all ends well within five seconds", server.wait(30) == 0 and time.monotonic() - began < 5.5, time.monotonic() - began)


def health(url: str, word: str) -> list[dict[str, int]]:
    """The figures of each worker."""
    question = urllib.request.Request(f"{url}health", headers={"Authorization": f"Bearer {word}"})
    with urllib.request.urlopen(question, timeout=20) as answer:
        return json.loads(answer.read())["workers"]
