"""A browser and a server for each worker, a fresh tab for each test."""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO, Any

import pytest
from playwright.sync_api import Browser, Error, Page, sync_playwright
from tab import FLAGS, UNDRAWN, Tab

ROOT = Path(__file__).parents[2]
ARTEFACTS = ROOT / "artefacts"
WIDE = 800  # px from which on a window is laid out as a wide one
START = 180.0  # s until a server must have printed its address
PASSED = pytest.StashKey[bool]()
LOGS: list[IO[bytes]] = []  # of the servers that run
LOOKED_AT: list[Tab] = []  # the tabs of the test that runs
SERVE = "from observer_lab.cli import main; raise SystemExit(main())"


def chromium() -> str | None:
    """The system's Chromium, best the one without a window, a fifth cheaper; None leaves the choice to Playwright, which takes its own."""
    names = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
    return next((path for name in names if (path := shutil.which(name))), None)


def _address(process: subprocess.Popen[bytes], log: IO[bytes]) -> str:
    """The address that a starting server prints."""
    deadline, seen = time.monotonic() + START, b""
    while time.monotonic() < deadline and process.poll() is None:
        log.seek(0)
        seen = log.read()
        if found := re.search(rb"http://[\w.]+:\d+(?=\s)", seen):
            return found[0].decode()
        time.sleep(0.02)
    raise RuntimeError(f"the server printed no address: {seen.decode(errors='replace')[-2000:]}")


def _free_port() -> int:
    """A port that nobody listens on now; the server takes the next one if that changes, and prints which."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def serving(port: int = 0, *options: str, **surroundings: str) -> Iterator[str]:
    """`observer-lab serve` on a port, a free one if it is 0, while the context lasts; its address."""
    env = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1", **surroundings}
    with NamedTemporaryFile() as log, open(log.name, "ab") as writing:  # a pipe that nobody reads would stop who says much
        process = subprocess.Popen([sys.executable, "-c", SERVE, "serve", "--port", str(port or _free_port()),
                                    *(() if "--view" in options else ("--view", "lab")), *options],
                                   cwd=ROOT, env=env, stdout=writing, stderr=subprocess.STDOUT)
        LOGS.append(log.file)
        try:
            yield _address(process, log.file)
            assert process.poll() is None, "the server has died"
            log.seek(0)
            said = log.read().decode(errors="replace")
            assert " ERROR " not in said and "Traceback" not in said, f"the server's log: {said[-4000:]}"
        finally:
            process.terminate()
            process.wait(60)
            LOGS.remove(log.file)


@pytest.fixture(scope="session")
def serve() -> Callable[..., AbstractContextManager[str]]:
    """Serves the app for as long as a context lasts, on a port."""
    return serving


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    """The address of the app, served for the whole session."""
    with serving() as address:
        yield address


@pytest.fixture(scope="session")
def guide() -> Iterator[str]:
    """The address of the app as people start it, with the guide, served for the whole session."""
    with serving(0, "--view", "guide") as address:
        yield address


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """One headless Chromium."""
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def blank(browser: Browser) -> Iterator[Page]:
    """A page without the app: what is asked here is asked of the browser alone."""
    page = browser.new_page()
    yield page
    page.close()


@pytest.fixture
def still_page(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Opens pages of people who were never here, and closes them: they ask for calm, and their scene is drawn for pictures alone."""
    pages: list[Page] = []

    def opened(width: int = 1366, height: int = 768, **more: Any) -> Page:
        context = browser.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce", **more)
        context.add_init_script(f"({UNDRAWN})()")
        pages.append(context.new_page())
        return pages[-1]
    yield opened
    for page in pages:
        page.context.close()


@pytest.fixture(scope="session")
def left_well(browser: Browser) -> Iterator[list[Page]]:
    """Pages of the guide that tests have left well, for the next one: what is compiled once is not compiled again."""
    pages: list[Page] = []
    yield pages
    for page in pages:
        page.context.close()


@pytest.fixture
def guide_page(browser: Browser, left_well: list[Page], request: pytest.FixtureRequest) -> Iterator[Callable[..., Page]]:
    """Opens calm pages as `still_page` does, for tests that hang nothing into them: one that was left well has forgotten all it kept."""
    pages: list[Page] = []

    def opened(width: int = 1366, height: int = 768, dark: bool = False) -> Page:
        if left_well:
            page = left_well.pop()
            page.goto("/".join((*page.url.split("/")[:3], "health")))  # of the same origin, and plain
            page.evaluate("() => { localStorage.clear(); sessionStorage.clear(); }")
            page.context.clear_cookies()
            page.set_viewport_size({"width": width, "height": height})
        else:
            context = browser.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce")
            context.add_init_script(f"({UNDRAWN})()")
            page = context.new_page()
        page.emulate_media(color_scheme="dark" if dark else "light", reduced_motion="reduce")
        pages.append(page)
        return page
    yield opened
    for page in pages:
        if not left_well and request.node.stash.get(PASSED, False) and not page.is_closed():
            left_well.append(page)
        else:
            page.context.close()


@pytest.fixture(scope="session")
def spare(browser: Browser) -> Iterator[list[Tab]]:
    """A tab that a test has left well, for the next one: to load the page costs as much as most tests."""
    tabs: list[Tab] = []
    yield tabs
    for tab in tabs:
        tab.page.context.close()


@pytest.fixture
def new_tab(browser: Browser, server: str, spare: list[Tab], request: pytest.FixtureRequest) -> Iterator[Callable[..., Tab]]:
    """Opens tabs that share nothing, each with a window of its own size; closes them and checks that none complained."""
    tabs: list[Tab] = []
    lent: list[Tab] = []

    def opened(width: int = 900, height: int = 560, motion: bool = False, own: bool = False) -> Tab:
        """Without `motion` the browser asks pages for calm, and a lesson that opens stands still.

        A wide one may be a tab that has forgotten all it was told before; `own` where a test looks at how the page is loaded, or
        hangs something of its own into it.
        """
        lends = not motion and not own and width >= WIDE
        left = next((tab for tab in spare if tab.address == server), None)
        if lends and left is not None:
            spare.remove(left)
            tab = left
            LOOKED_AT.append(tab)
            tab.begin_anew(width, height)
        else:
            context = browser.new_context(viewport={"width": width, "height": height},
                                          reduced_motion="no-preference" if motion else "reduce")
            tab = Tab(context.new_page(), server, drawn=False)
        tabs.append(tab)
        if tab not in LOOKED_AT:
            LOOKED_AT.append(tab)
        if lends:
            lent.append(tab)
        return tab
    yield opened
    LOOKED_AT.clear()
    complaints = [line for tab in tabs for line in tab.complaints]
    well = not complaints and request.node.stash.get(PASSED, False)
    for tab in tabs:
        if well and tab in lent and not spare and not tab.page.is_closed() and tab.in_lab():
            spare.append(tab)
        else:
            tab.page.context.close()
    assert not complaints, f"the browser's console: {complaints}"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Keep how a test went, for the fixtures that outlive it; beside one that failed, what the servers have said."""
    report = yield
    if report.failed:
        for log in LOGS:
            log.seek(0)
            report.sections.append(("what a server said last", log.read()[-8000:].decode(errors="replace")))
        for k, seen in enumerate(LOOKED_AT):
            report.sections.append(("what a page complained of", "\n".join(seen.complaints)))
            with suppress(Error):
                ARTEFACTS.mkdir(exist_ok=True)
                name = re.sub(r"[^\w-]+", "-", item.name)
                seen.page.screenshot(path=ARTEFACTS / f"failed-{name}-{k}.png", timeout=20_000)
    item.stash[PASSED] = item.stash.get(PASSED, True) and report.passed
    return report


@pytest.fixture(scope="module")
def walk(browser: Browser, server: str, spare: list[Tab]) -> Iterator[list[Tab]]:
    """The tab of a file's walk through the lessons; empty before the first test and after one that failed. It may be a spare one."""
    tabs: list[Tab] = []
    yield tabs
    for tab in tabs:
        if spare or not tab.in_lab():
            tab.page.context.close()
        else:
            spare.append(tab)


@pytest.fixture
def walking(walk: list[Tab], browser: Browser, server: str, spare: list[Tab], request: pytest.FixtureRequest) -> Iterator[Tab]:
    """One tab that goes from test to test, as a person goes from lesson to lesson; a new one after a test that failed."""
    if not walk and spare:
        walk.append(spare.pop())
        walk[0].begin_anew(900, 560)
    elif not walk:
        context = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce")
        walk.append(Tab(context.new_page(), server, drawn=False))
    tab = walk[0]
    LOOKED_AT.append(tab)
    yield tab
    LOOKED_AT.clear()
    complaints, tab.complaints = tab.complaints, []
    if complaints or not request.node.stash.get(PASSED, False):
        walk.pop().page.context.close()
    assert not complaints, f"the browser's console: {complaints}"


@pytest.fixture
def tab(new_tab: Callable[..., Tab]) -> Tab:
    """One tab on the opening lesson."""
    return new_tab()


@pytest.fixture(scope="session")
def artefacts() -> Path:
    """Where pictures for people are kept; git ignores it."""
    ARTEFACTS.mkdir(exist_ok=True)
    return ARTEFACTS
