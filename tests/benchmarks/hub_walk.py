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
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parents[1] / "e2e"), str(Path(__file__).parents[1])]

from conftest import chromium  # type: ignore[import-not-found]
from nginx_proxy import NAME  # type: ignore[import-not-found]
from playwright.sync_api import Browser, Page, sync_playwright
from tab import FLAGS, Tab  # type: ignore[import-not-found]
from tls_walk import walk_tls  # type: ignore[import-not-found]
from token_walk import walk_token  # type: ignore[import-not-found]
from walks import HERE, KNOB, PATIENCE, Walk, free_ports, window  # type: ignore[import-not-found]

STUDENTS = ("alice", "bob")
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
    page = window(browser)
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
    before = set(processes("observer_lab.cli serve"))
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
        labs = {pid: line for pid, line in processes("observer_lab.cli serve").items() if pid not in before}
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
    while set(processes("observer_lab.cli serve")) - before and time.monotonic() < gone:
        time.sleep(0.2)
    walk.check("with the hub all labs have ended", not set(processes("observer_lab.cli serve")) - before)


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
