"""A walk through a lab with a token behind nginx with TLS, under a name: `hub_walk.py --only tls`."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from nginx_proxy import NAME, nginx  # type: ignore[import-not-found]
from playwright.sync_api import Browser
from tab import Tab  # type: ignore[import-not-found]
from walks import HERE, KNOB, Walk, free_ports, surroundings, window  # type: ignore[import-not-found]


def walk_tls(walk: Walk, browser: Browser) -> None:
    """A lab with a token behind nginx with TLS, under a name."""
    lab, plain, tls = free_ports(3)
    with tempfile.TemporaryDirectory() as folder, nginx(Path(folder), lab, plain, tls):
        server = subprocess.Popen([sys.executable, "-m", "observer_lab", "serve", "--port", str(lab), "--exact-port", "--allow-host", NAME],
                                  cwd=HERE, env=surroundings(), stdout=subprocess.PIPE, text=True)
        assert server.stdout is not None
        try:
            word = server.stdout.readline().strip().rpartition("=")[2]
            address = f"https://{NAME}:{tls}/"
            page = window(browser, ignore_https_errors=True)
            sockets: list[str] = []
            page.on("websocket", lambda opened: sockets.append(opened.url))
            answer = page.request.get(f"http://127.0.0.1:{plain}/x?y=1", headers={"Host": NAME}, max_redirects=0)
            walk.check("without TLS one is sent to it", (answer.status, answer.headers.get("location")) == (308, f"{address}x"),
                       answer.headers)
            page.goto(address)
            page.wait_for_url("**/?again")
            walk.check("without the token there is one sentence", "access token" in page.inner_text("body"), page.inner_text("body"))
            page.goto(f"{address}?token={word}")
            tab = Tab(page, address, drawn=False)
            walk.check("with it the lab opens under its name, by TLS alone", sockets and all(
                opened.startswith(f"wss://{NAME}:{tls}/") for opened in sockets), sockets)
            cookie = page.context.cookies()[0]
            logs = "".join(path.read_text() for path in Path(folder).glob("observer-lab*.log"))
            walk.check("no log of the proxy holds the token", "GET / " in logs and word not in logs, logs[-2000:])
            walk.check("the token has left the address", word not in page.url, page.url)
            walk.check("the cookie stays on TLS", cookie.get("secure") and cookie.get("httpOnly"), cookie)
            tab.slide(KNOB, "ArrowRight", 4)
            value = tab.value(KNOB)
            page.reload()
            tab.settle()
            walk.check("a reload comes back where it was", value > 0 and tab.value(KNOB) == value, tab.value(KNOB))
            page.goto("about:blank")
            page.evaluate("address => new Promise(done => { const s = new WebSocket(address); s.onopen = () => done('open'); "
                          "s.onerror = () => done('refused'); }).then(how => { window.how = how; })", f"wss://{NAME}:{tls}/")
            walk.check("a page of elsewhere gets no WebSocket", page.evaluate("window.how") == "refused", page.evaluate("window.how"))
            walk.check("the browser complained of nothing", not [line for line in tab.complaints if "wss://" not in line], tab.complaints)
            page.context.close()
        finally:
            server.terminate()
            server.wait(30)
