"""The page in a frame: of a notebook, of another site, and where the browser refuses to store anything."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Frame, Page
from tab import DRAWN, HARMLESS, eventually

from observer_lab import notebook
from observer_lab.notebook import Lab

ESM = Path(notebook.__file__).with_name("lab.js").read_text(encoding="utf-8")
NOTEBOOK = """<!doctype html><meta charset="utf-8"><title>Notebook</title><div id="cell"></div><script type="module">
import widget from "./lab.js";
const heard = {}, traits = {title: 'A lesson', width: '900px', height: 620};
const model = {get: name => traits[name], on: (kind, act) => { heard[kind] = act; }, off: () => {},
  send: async content => heard['msg:custom'](await window.kernel(content))};
widget.render({model, el: document.getElementById('cell')});
</script>"""
REFUSE = """for (const name of ['localStorage', 'sessionStorage']) Object.defineProperty(window, name, {
  get() { window.refusals = (window.refusals ?? 0) + 1; throw new DOMException('The request was denied.', 'SecurityError'); }});"""
STOOD = "() => document.querySelector('.ol-mark') !== null"


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    """Another site: the address of a page for anything."""
    class Handler(BaseHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            """Nothing."""

        def do_GET(self) -> None:
            content, kind = (ESM, "text/javascript") if self.path == "/lab.js" else (NOTEBOOK, "text/html; charset=utf-8")
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content.encode())))
            self.end_headers()
            self.wfile.write(content.encode())
    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://localhost:{server.server_port}"
    server.shutdown()
    server.server_close()


def opened(page: Page, site: str, address: str) -> list[str]:
    """Open the notebook whose kernel gives this address; what the page complains of."""
    complaints: list[str] = []
    page.on("pageerror", lambda problem: complaints.append(str(problem)))
    page.on("console", lambda said: complaints.append(said.text) if said.type == "error" and not any(
        harmless in said.text for harmless in HARMLESS) else None)
    page.expose_function("kernel", lambda content: {"address": address} if content["origin"] == site else {"problem": "another origin"})
    page.goto(site)
    return complaints


def frame_of(page: Page) -> Frame:
    """The lesson's frame, once the lesson stands."""
    def standing() -> list[Frame]:
        page.evaluate("1")  # lets the browser's questions come in
        return [frame for frame in page.frames[1:] if frame.url.startswith("http") and frame.evaluate(STOOD)]
    return eventually(standing, bool, "the lesson")[0]


def keep_a_picture(page: Page, frame: Frame, path: Path) -> None:
    """For people to look at: the stage is drawn once."""
    frame.evaluate("window.observerLabDraws = true")
    eventually(lambda: frame.evaluate(DRAWN), bool, "a drawn stage")
    page.screenshot(path=path)
    frame.evaluate("window.observerLabDraws = false")


def knob(frame: Frame) -> str | None:
    """What the first slider says."""
    return frame.locator("[role=slider]").first.get_attribute("aria-valuenow")


def drag(page: Page, frame: Frame, by: int) -> str | None:
    """Drag the first slider a little to the side; what it says then, once the server has answered."""
    before = knob(frame)
    thumb = frame.locator("[role=slider]").first
    thumb.scroll_into_view_if_needed()
    box = thumb.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + by, y, steps=4)
    page.mouse.up()
    return eventually(lambda: knob(frame), lambda now: now != before, "the knob under the hand")


def test_a_notebook_shows_the_lesson_and_no_other_origin_does(still_page: Callable[..., Page], site: str, artefacts: Path) -> None:
    address = Lab("kalman").address_for(site)
    page = still_page(1000, 700)
    complaints = opened(page, site, address)
    frame = frame_of(page)
    assert "token" not in frame.url and frame.title().endswith("Observer Lab")
    eventually(lambda: frame.locator(".ol-scene").count(), bool, "the first scene")
    keep_a_picture(page, frame, artefacts / "notebook.png")
    assert complaints == []
    other = still_page()
    other.goto(site.replace("localhost", "127.0.0.1") + "/other")
    other.set_content(f'<iframe src="{address}"></iframe>')
    eventually(lambda: [frame.url for frame in other.frames[1:]], lambda urls: urls and urls[0].startswith("chrome-error:"), "a refusal")


def test_the_stage_alone_fills_its_frame(still_page: Callable[..., Page], site: str, artefacts: Path) -> None:
    page = still_page(1000, 700)
    opened(page, site, Lab("separation", "stage").address_for(site))
    frame = frame_of(page)
    eventually(lambda: frame.evaluate("[...document.querySelectorAll('canvas[data-engine]')].map(c => c.clientWidth / innerWidth)"),
               lambda shares: shares and shares[0] > 0.98, "a stage as wide as the frame")
    assert not frame.locator(".ol-question").first.is_visible()
    keep_a_picture(page, frame, artefacts / "stage-alone.png")


def test_a_frame_of_another_site_keeps_its_word_in_a_partitioned_cookie(still_page: Callable[..., Page], site: str) -> None:
    """`localhost` and `127.0.0.1` are two sites; a strict cookie would not come with the frame's own requests."""
    address = Lab("kalman").address_for(site).replace("//localhost", "//127.0.0.1")
    page = still_page(1000, 700)
    complaints = opened(page, site, address)
    frame_of(page)
    (cookie,) = [each for each in page.context.cookies() if each["name"] == f"observer-lab-{urlsplit(address).port}"]
    assert cookie["httpOnly"] and cookie["secure"] and cookie["sameSite"] == "None" and cookie.get("partitionKey")
    assert complaints == []


def test_a_lesson_survives_that_the_browser_stores_nothing(still_page: Callable[..., Page], site: str) -> None:
    address = Lab("separation", "lab").address_for(site)
    page = still_page(1000, 700)
    page.context.add_init_script(REFUSE)
    complaints = opened(page, site, address)
    frame = frame_of(page)
    assert frame.evaluate("window.refusals") > 0, "the page has asked"
    moved = drag(page, frame, 25)
    frame.evaluate("window.before = true")
    frame.evaluate("location.reload()")
    eventually(lambda: frame.evaluate("window.before === undefined") and frame.evaluate(STOOD), bool, "the lesson after the reload")
    eventually(lambda: knob(frame), lambda now: now is not None, "its knob")
    assert moved is not None and drag(page, frame, -25) is not None and complaints == []
