"""Walk a published folder in Firefox: `python tests/e2e/published_in_firefox.py FOLDER [LESSON …]`.

Firefox (Debian's `firefox-esr`) is told by WebDriver BiDi what to do, on a screen of `xvfb`: without one it draws no WebGL. Every scene of
each lesson is opened from its file, questions are answered. A line for each lesson; the status is 1 where an error was reported or a
request left the folder.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from websockets.sync.client import ClientConnection, connect

from observer_lab.course.scenes import Choose
from observer_lab.lessons import LESSONS

START_S, CARD_S = 120.0, 180.0  # s in which the browser listens, and in which a card stands
PREFERENCES = ('user_pref("security.sandbox.content.level", 0);\nuser_pref("app.update.enabled", false);\n'
               'user_pref("datareporting.policy.dataSubmissionEnabled", false);\nuser_pref("webgl.force-enabled", true);\n'
               'user_pref("ui.prefersReducedMotion", 1);\n')
HARMLESS = ("WebGL", "downloadable font", "unreachable code", "Permissions-Policy", "Layout was forced")
AT = """() => [document.querySelector('.ol-card')?.dataset.scene ?? '', !!document.querySelector('.ol-cover')?.checkVisibility(),
  document.querySelectorAll('.ol-way .ol-next').length]"""


class Firefox:
    """One tab, and what it complained about."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._number = socket, count(1)
        self.complaints: list[str] = []
        self.home = "file:"
        self.ask("session.new", capabilities={})
        self.ask("session.subscribe", events=["log.entryAdded", "network.beforeRequestSent"])
        self._tab = self.ask("browsingContext.getTree")["contexts"][0]["context"]

    def ask(self, method: str, **given: Any) -> Any:
        """The answer to a command; what happens meanwhile is written down."""
        number = next(self._number)
        self._socket.send(json.dumps({"id": number, "method": method, "params": given}))
        while True:
            said = json.loads(self._socket.recv(timeout=CARD_S))
            if said.get("id") == number:
                if said["type"] != "success":
                    raise RuntimeError(f"{method}: {said.get('message')}")
                return said["result"]
            self._note(said)

    def _note(self, said: Any) -> None:
        if said.get("method") == "log.entryAdded" and said["params"]["level"] == "error":
            words = str(said["params"]["text"])
            if not any(each in words for each in HARMLESS):
                self.complaints.append(words)
        elif said.get("method") == "network.beforeRequestSent":
            url = said["params"]["request"]["url"]
            if not url.startswith((self.home, "data:", "blob:", "about:")):
                self.complaints.append(f"a request left: {url[:120]}")

    def open(self, address: str) -> None:
        """Go to an address."""
        self.ask("browsingContext.navigate", context=self._tab, url=address, wait="none")

    def look(self, function: str) -> Any:
        """What a function of no argument gives on the page."""
        found = self.ask("script.evaluate", expression=f"JSON.stringify(({function})())", target={"context": self._tab}, awaitPromise=False)
        return json.loads(found.get("result", {}).get("value", "null"))

    def press(self, value: str) -> None:
        """Press a button of the card."""
        self.look(f"() => document.querySelector('[data-value=\"{value}\"]')?.click()")

    def wait(self, scene: str, done: bool = False) -> None:
        """Until the card of a scene stands, and its action is done where that is asked for."""
        deadline = time.monotonic() + CARD_S
        while True:
            at, covered, nexts = self.look(AT) or ("", True, 0)
            if at == scene and not covered and (nexts or not done):
                return
            if time.monotonic() > deadline:
                raise TimeoutError(f"{scene} does not stand; {at!r} does; {self.complaints[:3]}")
            time.sleep(0.1)


@contextmanager
def firefox() -> Iterator[Firefox]:
    """A Firefox on a screen that nobody sees while the context lasts."""
    name, screen = shutil.which("firefox-esr") or shutil.which("firefox"), shutil.which("xvfb-run")
    if name is None or screen is None:
        raise SystemExit("There is no Firefox, or no screen for it; apt-get install firefox-esr xvfb xauth")
    with TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        (Path(profile) / "user.js").write_text(PREFERENCES)
        command = [screen, "-a", "-s", "-screen 0 1400x1000x24", name, "--profile", profile, "--remote-debugging-port", "0",
                   "--width", "1366", "--height", "900", "about:blank"]
        process = subprocess.Popen(command, stderr=subprocess.STDOUT, stdout=subprocess.PIPE, text=True, start_new_session=True,
                                   env={**os.environ, "LIBGL_ALWAYS_SOFTWARE": "1"})
        try:
            assert process.stdout is not None
            found = next(filter(None, (re.search(r"ws://\S+", line) for line in process.stdout)), None)
            if found is None:
                raise SystemExit("Firefox does not listen.")
            with connect(f"{found[0]}/session", max_size=None, open_timeout=START_S) as socket:
                yield Firefox(socket)
        finally:
            os.killpg(process.pid, signal.SIGTERM)  # the screen and what stands on it
            process.wait(START_S)


def main() -> int:
    """Walk the lessons of the folder."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("lessons", nargs="*")
    parser.add_argument("--look", default="en-light", help="language and theme")
    asked = parser.parse_args()
    language, _, theme = asked.look.partition("-")
    there = [path.name for path in sorted((asked.folder / "data").iterdir()) if path.name in LESSONS]
    scenes = bad = 0
    with firefox() as tab:
        tab.home = asked.folder.resolve().as_uri()
        for id in asked.lessons or there:
            tab.complaints.clear()
            path = LESSONS[id].path
            tab.open(f"{tab.home}/index.html?lesson={id}&lang={language}&theme={theme}")
            for k, scene in enumerate(path):
                if k:
                    tab.press(f"scene:{k}")
                tab.wait(scene.id)
                if isinstance(scene.do, Choose):
                    tab.press("option:0")
                    tab.wait(scene.id, done=True)
            scenes, bad = scenes + len(path), bad + len(tab.complaints)
            print(f"{id} {asked.look}: {len(path)} scenes, {len(tab.complaints)} errors and requests to elsewhere "
                  f"{tab.complaints[:3] or ''}", flush=True)
    print(f"{scenes} scenes in Firefox, {bad} faults")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
