"""The replay of every lesson, read as a browser reads it: what moves stands at every moment where the body has it.

    python tests/lessons/all_replays.py [language] [lesson …]
"""

from __future__ import annotations

import base64
import json
import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import zstandard

if __name__ == "__main__":
    tests = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(tests.parent), str(tests), str(tests / "lessons")]

from observer_lab.course.figures.records import LineFigure, MapFigure
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.replay.replay import replay
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import read_token, write_token
from observer_lab.session.state.view import Picture, State

LARGEST = 10_000_000  # bytes
NEAR = 1.5e-4  # stage units: positions are written to four decimals
MOMENTS = (0.0, 0.37, 1.0, 0.05)  # of the run, in no order: a slider goes back as well
FIELDS = {"SetPositionMessage": "position", "SetOrientationMessage": "wxyz", "SetSceneNodeVisibilityMessage": "visible"}
EMBEDDED, ARGUMENT = re.compile(r'"recording": "([^"]+)"'), re.compile(r".*\n\}\n\)\((\{.*\})\)\}\)$", re.S)


class Reader(HTMLParser):
    """Elements with their attributes, and all words that stand on the page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.words, self._silent = "", False
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        self._silent = tag in ("script", "style")

    def handle_endtag(self, tag: str) -> None:
        self._silent = False

    def handle_data(self, data: str) -> None:
        self.words += "" if self._silent else data

    def of(self, name: str) -> list[dict[str, str]]:
        """The attributes of each element of a kind, or of a class."""
        return [given for tag, given in self.elements if name in (tag, *given.get("class", "").split())]


def state_in(page: str) -> str:
    """The token that a page carries."""
    (token,) = [given["content"] for given in Reader(page).of("meta") if given.get("name") == "observer-lab-state"]
    return token


def messages_in(page: str) -> list[dict[str, Any]]:
    """What viser's own page finds in the recording, which must be one that stands still."""
    found = EMBEDDED.search(page)
    assert found is not None
    packed = base64.b64decode(found[1])
    whole = zstandard.ZstdDecompressor().decompress(packed[8:], int.from_bytes(packed[:8], "little"))
    length = int.from_bytes(whole[:8], "little")
    data = msgspec.msgpack.decode(whole[8:8 + length])
    assert data["durationSeconds"] == 0.0
    return [message for _, message in data["messages"]]


def places_at(messages: list[dict[str, Any]], run: dict[str, Any], moment: int) -> dict[tuple[str, str], Any]:
    """Every property of a node at a moment: as it was recorded, or as the run has it then."""
    out = {(m["name"], FIELDS[m["type"]]): m[FIELDS[m["type"]]] for m in messages if m["type"] in FIELDS}
    for channel in run["moves"]:
        assert channel["at"][0] == 0 and channel["at"] == sorted(set(channel["at"])) and len(channel["to"]) == len(channel["at"])
        out[channel["name"], channel["prop"]] = channel["to"][sum(k <= moment for k in channel["at"]) - 1]
    return out


def check(lesson: Lesson, language: str = "en") -> int:
    """Judge the replay of a lesson's start; its size in bytes. Raises AssertionError."""
    design = lesson.start()
    outcome = lesson.compute(design)
    figures, stage = tuple(lesson.figures(outcome)), outcome.stage
    assert stage is not None
    page = replay(Picture(lesson, design, outcome, figures, State(language=language), True), write_token(lesson, SavedState(design)))
    size = len(page.encode())
    assert size <= LARGEST, size
    read, words = Reader(page), lesson.words[language]
    assert read_token(state_in(page), LESSONS).design == design
    assert words.title in read.words and words.question in read.words
    assert read.of("html")[0]["lang"] == language and "default-src 'none'" in read.of("meta")[-2]["content"]
    links = [given[name] for _, given in read.elements for name in ("src", "href", "srcset", "data", "action") if name in given]
    assert links and all(link.startswith("data:") for link in links)
    shown = [f for f in figures if not isinstance(f, MapFigure) or np.any(f.values >= 0)]
    assert len(read.of("figure")) == len(shown)
    assert len(read.of("ol-replay-now")) == sum(isinstance(f, LineFigure) and not f.log_x for f in shown)
    messages = messages_in(page)
    assert not [m["type"] for m in messages if "Gui" in m["type"] or "Bindings" in m["type"]]
    found = ARGUMENT.search([m["source"] for m in messages if m["type"] == "RunJavascriptMessage"][-1])
    assert found is not None
    run = json.loads(found[1])["run"]
    body, names = stage.body, [part.name for part in stage.body.parts]
    for share in MOMENTS:
        k = round(share * (len(run["t"]) - 1))
        index = int(np.argmin(np.abs(stage.t - run["t"][k])))
        now = places_at(messages, run, k)
        for root, states in (("/plant", stage.x), ("/ghost", stage.xhat)):
            poses = {} if states is None else body.pose(states[index].tolist(), body.gain)
            for name, node in ((name, f"{root}/{name}") for name in names if (f"{root}/{name}", "position") in now):
                assert np.allclose(now[node, "position"], poses[name].position, atol=NEAR, rtol=0), (node, share)
                assert np.allclose(now.get((node, "wxyz"), (1, 0, 0, 0)), poses[name].wxyz, atol=NEAR, rtol=0), (node, share)
    moving = {channel["name"].split("/")[1] for channel in run["moves"]}
    assert moving >= {"plant"} | ({"ghost"} if stage.xhat is not None and any(part.twin for part in body.parts) else set()), moving
    return size


if __name__ == "__main__":
    spoken, asked = (sys.argv[1] if len(sys.argv) > 1 else "en"), sys.argv[2:] or list(LESSONS)
    for id in asked:
        print(f"{id:20s} {check(LESSONS[id], spoken) / 1e6:6.2f} MB")
