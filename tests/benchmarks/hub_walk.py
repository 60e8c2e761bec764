"""A walk through a JupyterHub of its own with two students in a browser, through a lab with workers and a token, and through TLS.

    python tests/benchmarks/hub_walk.py [--in FOLDER]

On loopback alone. The hub, jupyter-server-proxy and the lab are installed from the package registries into a folder (a temporary
one; one that is given is used again), configurable-http-proxy by npm. The hub reads assets/deploy/jupyterhub_config.py; only who
may log in, as whom servers run and the ports are set here. nginx reads assets/deploy/nginx.conf, with ports and a certificate
of its own; it and openssl must be there. Prints a line for each check; exit status 1 where one fails.
"""

# ruff: noqa: E402 — the folders of the app and of the browser tests must be found first

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests" / "e2e")]

from conftest import chromium  # type: ignore[import-not-found]
from playwright.sync_api import Browser, Page, sync_playwright
from tab import FLAGS, Tab  # type: ignore[import-not-found]

KNOB = "stiffness believed wrong by [%]"
STUDENTS = ("alice", "bob")
PATIENCE = 120.0  # s
CONFIG = """
load_subconfig({recipe!r})
c.JupyterHub.bind_url = "http://127.0.0.1:{port}"
c.JupyterHub.hub_port = {hub}
c.ConfigurableHTTPProxy.api_url = "http://127.0.0.1:{api}"
c.ConfigurableHTTPProxy.command = [{proxy!r}]
c.JupyterHub.authenticator_class = "dummy"
c.DummyAuthenticator.password = "walk"
c.Authenticator.allow_all = True
c.JupyterHub.spawner_class = "simple"
c.SimpleLocalProcessSpawner.home_dir_template = {homes!r}
c.Spawner.args = ["--allow-root", "--ServerApp.log_level=WARN"]
c.Spawner.environment = {{**c.Spawner.environment, "OBSERVER_LAB_KERNELS": "off"}}
"""


class Walk:
    """The checks so far: one line each."""

    def __init__(self) -> None:
        self.failed = 0

    def check(self, words: str, holds: object, seen: object = "") -> None:
        """Print whether something holds, and what was seen where it does not."""
        self.failed += not holds
        print(f"{'ok    ' if holds else 'FAILED'} {words}" + ("" if holds else f": {str(seen)[:300]}"), flush=True)


def installed(folder: Path) -> tuple[Path, Path]:
    """The commands of an environment with the hub and the lab, and configurable-http-proxy; made where they are not there yet."""
    commands, proxy = folder / "venv" / "bin", folder / "node_modules" / ".bin" / "configurable-http-proxy"
    if not (commands / "jupyterhub").exists():
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
        subprocess.run([commands / "pip", "install", "--quiet", "jupyterhub", "jupyter-server-proxy", "jupyterlab"], check=True)
    with tempfile.TemporaryDirectory() as source:  # building leaves its traces beside the sources
        for name in ("app", "lessons", "pyproject.toml", "README.md", "LICENSE"):
            (shutil.copytree if (HERE / name).is_dir() else shutil.copy2)(HERE / name, Path(source) / name)
        subprocess.run([commands / "pip", "install", "--quiet", "--upgrade", "--force-reinstall", "--no-deps", source], check=True)
    subprocess.run([commands / "pip", "install", "--quiet", "-c", HERE / "constraints.txt", "observer-lab"], check=True)
    if not proxy.exists():
        subprocess.run(["npm", "install", "--silent", "--no-audit", "--no-fund", "configurable-http-proxy"], cwd=folder, check=True)
    return commands, proxy


def free_ports(count: int) -> list[int]:
    """Ports that nobody listens on now."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def status(url: str, **headers: str) -> int:
    """The status of an answer; 0 where there is none."""
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=20) as answer:
            return answer.status
    except urllib.error.HTTPError as refused:
        return refused.code
    except OSError:
        return 0


@contextmanager
def hub(folder: Path, commands: Path, proxy: Path) -> Iterator[tuple[str, Path]]:
    """A hub that runs while this lasts: its address, and its log."""
    port, inner, api = free_ports(3)
    place = Path(tempfile.mkdtemp(dir=folder))
    recipe = HERE / "assets" / "deploy" / "jupyterhub_config.py"
    (place / "jupyterhub_config.py").write_text(CONFIG.format(
        recipe=str(recipe), port=port, hub=inner, api=api, proxy=str(proxy), homes=f"{place}/{{username}}"))
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    environment["PATH"] = f"{commands}{os.pathsep}{environment['PATH']}"
    with (place / "log").open("w") as log:
        process = subprocess.Popen([commands / "jupyterhub", "--config", "jupyterhub_config.py"], cwd=place, env=environment,
                                   stdout=log, stderr=subprocess.STDOUT)
        try:
            end = time.monotonic() + PATIENCE
            while status(f"http://127.0.0.1:{port}/hub/login") != 200:
                assert process.poll() is None and time.monotonic() < end, (place / "log").read_text()[-3000:]
                time.sleep(0.3)
            yield f"http://127.0.0.1:{port}", place / "log"
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(60)


def logged_in(browser: Browser, url: str, name: str) -> Page:
    """A window of its own in which somebody has logged in to the hub, and whose server stands."""
    page = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce").new_page()
    page.set_default_timeout(PATIENCE * 1000)
    page.goto(f"{url}/hub/login")
    page.fill("#username_input", name)
    page.fill("#password_input", "walk")
    page.click("#login_submit")
    page.wait_for_url(f"**/user/{name}/**")
    return page


def processes(words: str) -> dict[int, list[str]]:
    """The processes of this machine whose command line holds these words."""
    found = {}
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            line = entry.read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if words in " ".join(line):
            found[int(entry.parent.name)] = line
    return found


def walk_hub(walk: Walk, browser: Browser, folder: Path) -> None:
    """Two students, each in a lab of their own."""
    before = set(processes("app.cli serve"))
    commands, proxy = installed(folder)
    with hub(folder, commands, proxy) as (url, log):
        tabs: dict[str, Tab] = {}
        for name in STUDENTS:
            page = logged_in(browser, url, name)
            walk.check(f"who logs in as {name} is in the lab", f"/user/{name}/observer-lab/" in page.url, page.url)
            sockets: list[str] = []
            page.on("websocket", lambda opened, sockets=sockets: sockets.append(opened.url))
            tabs[name] = Tab(page, f"{url}/user/{name}/observer-lab/", drawn=False)
            walk.check(f"{name}'s address bar holds the path alone", page.url.partition("#")[0] == tabs[name].address, page.url)
            walk.check(f"{name}'s WebSocket goes to the same path", sockets == [tabs[name].address.replace("http", "ws", 1)], sockets)
            walk.check(f"the page of {name} has our sign without asking for it",
                       page.locator("link[rel=icon]").first.get_attribute("href", timeout=5000).startswith("data:image/svg"))  # type: ignore
        one, other = (tabs[name] for name in STUDENTS)
        for tab, key in ((one, "ArrowRight"), (other, "ArrowLeft")):
            tab.slide(KNOB, key, 4)
        mine, theirs = one.value(KNOB), other.value(KNOB)
        walk.check("each drags a knob and sees its own value and curves", mine > 0 > theirs and one.shown() != other.shown(),
                   (mine, theirs))
        one.page.reload()
        one.settle()
        walk.check("a reload comes back where it was", one.value(KNOB) == mine, one.value(KNOB))
        walk.check("the other felt nothing", other.value(KNOB) == theirs, other.value(KNOB))
        link = one.page.evaluate("location.href")
        walk.check("the address bar says the state under the student's path", re.fullmatch(re.escape(one.address) + "#.+", link), link)
        answer = other.page.request.get(one.address, max_redirects=0)
        walk.check("one student does not get the other's lab", answer.status in (302, 403, 404), answer.status)
        walk.check("nobody gets it without a login", b"observer lab" not in urllib.request.urlopen(one.address).read().lower())
        told = one.page.request.get(f"{url}/user/{STUDENTS[0]}/server-proxy/servers-info").json()["server_processes"]
        (entry,) = (server["launcher_entry"] for server in told if server["name"] == "observer-lab")
        icon = one.page.request.get(entry["icon_url"] if "://" in entry["icon_url"] else url + entry["icon_url"])
        walk.check("the launcher has a tile with title and picture",
                   entry["title"] == "Observer Lab" and icon.status == 200 and b"<svg" in icon.body(), entry)
        labs = {pid: line for pid, line in processes("app.cli serve").items() if pid not in before}
        ports = [line[line.index("--port") + 1] for line in labs.values()]
        walk.check("there is one lab a student, on ports of loopback", len(ports) == len(STUDENTS), labs)
        walk.check("another user of the machine is turned away at those ports",
                   [status(f"http://127.0.0.1:{port}/") for port in ports] == [401] * len(ports))
        words = [re.findall(rb"OBSERVER_LAB_TOKEN=([^\0]+)", Path(f"/proc/{pid}/environ").read_bytes())[0].decode() for pid in labs]
        lines = " ".join(" ".join(line) for line in processes("").values())
        walk.check("each has a token of its own, which no list of processes and no log shows",
                   len(set(words)) == len(words) and not any(word in lines + log.read_text() for word in words))
        for name, tab in tabs.items():
            walk.check(f"the browser of {name} complained of nothing, and asked nobody else", not tab.complaints, tab.complaints)
            tab.page.context.close()
    gone = time.monotonic() + PATIENCE
    while set(processes("app.cli serve")) - before and time.monotonic() < gone:
        time.sleep(0.2)
    walk.check("with the hub all labs have ended", not set(processes("app.cli serve")) - before)


def walk_token(walk: Walk, browser: Browser) -> None:
    """A lab with two workers and a token."""
    environment = {**os.environ, "PYTHONPATH": str(HERE), "OBSERVER_LAB_TOKEN": "auto", "OBSERVER_LAB_KERNELS": "off"}
    server = subprocess.Popen([sys.executable, "-m", "app.cli", "serve", "--port", "0", "--workers", "2"], cwd=HERE, env=environment,
                              stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    try:
        printed = server.stdout.readline().strip()
        bare = printed.partition("?")[0]
        page = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce").new_page()
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


NGINX = """
daemon off; pid {place}/pid; error_log {place}/errors; worker_processes 1;
events {{ worker_connections 64; }}
http {{ access_log off; client_body_temp_path {place}/body; proxy_temp_path {place}/proxy; fastcgi_temp_path {place}/f;
  uwsgi_temp_path {place}/u; scgi_temp_path {place}/s; include {place}/lab.conf; }}
"""
NAME = "lab.example.org"


def listens(port: int) -> bool:
    """Whether somebody listens on a port of loopback."""
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@contextmanager
def nginx(place: Path, lab: int, plain: int, tls: int) -> Iterator[None]:
    """nginx by our recipe on ports of loopback; only ports and the certificate are others."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={NAME}",
                    "-keyout", place / "privkey.pem", "-out", place / "fullchain.pem"], check=True, capture_output=True)
    recipe = (HERE / "assets" / "deploy" / "nginx.conf").read_text()
    for ours, here in (("listen 80;", f"listen 127.0.0.1:{plain};"), ("listen 443 ssl;", f"listen 127.0.0.1:{tls} ssl;"),
                       ("127.0.0.1:8080", f"127.0.0.1:{lab}"), (f"/etc/letsencrypt/live/{NAME}", str(place)),
                       ("https://$host$", f"https://$host:{tls}$")):
        assert recipe.count(ours) >= 1, ours
        recipe = recipe.replace(ours, here)
    (place / "lab.conf").write_text(recipe)
    (place / "nginx.conf").write_text(NGINX.format(place=place))
    process = subprocess.Popen(["nginx", "-p", place, "-c", place / "nginx.conf"])
    try:
        end = time.monotonic() + PATIENCE
        while not listens(plain):
            assert process.poll() is None and time.monotonic() < end, (place / "errors").read_text()[-2000:]
            time.sleep(0.1)
        yield
    finally:
        process.terminate()
        process.wait(30)


def walk_tls(walk: Walk, browser: Browser) -> None:
    """A lab with a token behind nginx with TLS, under a name."""
    lab, plain, tls = free_ports(3)
    environment = {**os.environ, "PYTHONPATH": str(HERE), "OBSERVER_LAB_TOKEN": "auto", "OBSERVER_LAB_KERNELS": "off"}
    with tempfile.TemporaryDirectory() as folder, nginx(Path(folder), lab, plain, tls):
        server = subprocess.Popen([sys.executable, "-m", "app.cli", "serve", "--port", str(lab), "--exact-port", "--allow-host", NAME],
                                  cwd=HERE, env=environment, stdout=subprocess.PIPE, text=True)
        assert server.stdout is not None
        try:
            word = server.stdout.readline().strip().rpartition("=")[2]
            address = f"https://{NAME}:{tls}/"
            page = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce", ignore_https_errors=True).new_page()
            sockets: list[str] = []
            page.on("websocket", lambda opened: sockets.append(opened.url))
            answer = page.request.get(f"http://127.0.0.1:{plain}/x?y=1", headers={"Host": NAME}, max_redirects=0)
            walk.check("without TLS one is sent to it", (answer.status, answer.headers.get("location")) == (308, f"{address}x?y=1"),
                       answer.headers)
            page.goto(address)
            page.wait_for_url("**/?again")
            walk.check("without the token there is one sentence", "access token" in page.inner_text("body"), page.inner_text("body"))
            page.goto(f"{address}?token={word}")
            tab = Tab(page, address, drawn=False)
            walk.check("with it the lab opens under its name, by TLS alone", sockets and all(
                opened.startswith(f"wss://{NAME}:{tls}/") for opened in sockets), sockets)
            cookie = page.context.cookies()[0]
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


def health(url: str, word: str) -> list[dict[str, int]]:
    """The figures of each worker."""
    question = urllib.request.Request(f"{url}health", headers={"Authorization": f"Bearer {word}"})
    with urllib.request.urlopen(question, timeout=20) as answer:
        return json.loads(answer.read())["workers"]


def main() -> int:
    """Walk, and say what was seen."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--in", dest="folder", metavar="FOLDER", type=Path, help="where to install, and what to use again")
    parser.add_argument("--only", choices=("hub", "token", "tls"), help="one of the walks")
    asked = parser.parse_args()
    folder = asked.folder or Path(tempfile.mkdtemp())
    walk = Walk()
    ways: list[tuple[str, Callable[[Browser], None]]] = [
        ("token", lambda browser: walk_token(walk, browser)),
        ("tls", lambda browser: walk_tls(walk, browser)), ("hub", lambda browser: walk_hub(walk, browser, folder.resolve()))]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True,
                                             args=[*FLAGS, f"--host-resolver-rules=MAP {NAME} 127.0.0.1"])
        for name, way in ways:
            if asked.only in (None, name):
                way(browser)
        browser.close()
    if asked.folder is None:
        shutil.rmtree(folder, ignore_errors=True)
    return int(walk.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
