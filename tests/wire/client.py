"""A tab without a browser: speaks viser's protocol over a WebSocket and keeps what a page would hold.

Messages go out as plain dictionaries, so that a test may send what no browser would.
"""

from __future__ import annotations

import json
import re
import socket
import ssl
import struct
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from importlib.metadata import version
from types import TracebackType
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import msgspec
import zstandard
from tls_line import tls_line
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from observer_lab.page.screen.server import LabServer

if TYPE_CHECKING:
    from shown_page import ShownPage

PATIENCE = 60.0  # s for something that must come; a busy machine is slow, and a test that waits is not one that fails
MARK = re.compile(r'<i class="ol-mark" hidden data-ask="([^"]+)" data-answer="([^"]+)" data-rests="([01])" ')
CALLED = re.compile(r"// (\w+)\.js\n.*\n\)\((\{.*\})\)\}\)", re.S)  # a script of ours and what it is given


def eventually(condition: Callable[[], Any], what: str) -> None:
    """Wait until something about the server holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, f"{what} never came"
        time.sleep(0.01)


def empty(server: LabServer) -> None:
    """Wait until every tab has left."""
    eventually(lambda: not server.sessions, "the end of every session")


def unpack(data: bytes) -> tuple[list[dict[str, Any]], list[bytes]]:
    """The messages of one batch as viser packs it, and the arrays that stand behind them."""
    size = int.from_bytes(data[8:16], "little")
    content = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(
        data[16:16 + size], max_output_size=int.from_bytes(data[:8], "little")), strict=False)
    arrays, at = [], 16 + size
    for length in content["binaryBufferLengths"]:
        at += -at % 8
        arrays.append(data[at:at + length])
        at += length
    return content["messages"], arrays


class WirePage(ABC):
    """What a page holds: `widgets` and `nodes` are kept up to date by the messages that are taken; a subclass sends."""

    def __init__(self, kept: str | None = None, answers: bool = True, plays: bool = False) -> None:
        self.widgets: dict[str, dict[str, Any]] = {}  # uuid → message with its props
        self.commands: dict[str, str] = {}  # label → uuid
        self.nodes: dict[str, dict[str, Any]] = {}  # scene nodes by name
        self.ticket = ""  # of its place
        self.notes: list[str] = []  # bodies of notifications, in order
        self.kept = kept  # what the page's sessionStorage holds
        self.answers = answers  # whether it says what it holds
        self.plays = plays  # whether it says that it moves between poses by itself

    @abstractmethod
    def send_raw(self, data: bytes | str) -> None:
        """Send anything at all."""

    def send(self, kind: str, **fields: Any) -> None:
        """Send one message of a kind."""
        self.send_raw(msgspec.msgpack.encode({"type": kind, **fields}))

    def look(self, across: int = 1280, up: int = 720) -> None:
        """The camera message after which viser takes a connection for a tab, from a canvas of some pixels."""
        self.send("ViewerCameraMessage", wxyz=(1.0, 0.0, 0.0, 0.0), position=(0.0, -13.0, 4.0), fov=0.6, near=0.01,
                  far=1000.0, image_height=up, image_width=across, look_at=(0.0, 0.0, 2.0), up_direction=(0.0, 0.0, 1.0))

    def command(self, label: str) -> None:
        """Trigger a command of the palette."""
        self.send("CommandTriggerMessage", uuid=self.commands[label])

    def take(self, message: dict[str, Any]) -> None:
        """Do what a message from the server says."""
        kind = message["type"]
        if kind in ("GuiUpdateMessage", "SceneNodeUpdateMessage"):
            holder = self.widgets if kind[0] == "G" else self.nodes
            thing = holder.get(message.get("uuid") or message.get("name") or "")
            if thing is not None:
                for name, value in message["updates"].items():
                    (thing if name == "value" else thing["props"])[name] = value
        elif kind == "SetSceneNodeVisibilityMessage" and message["name"] in self.nodes:
            self.nodes[message["name"]]["visible"] = message["visible"]
        elif kind == "GuiRemoveMessage":
            self.widgets.pop(message["uuid"], None)
        elif kind.startswith("Gui") and "props" in message:
            self.widgets[message["uuid"]] = message
        elif kind == "RemoveSceneNodeMessage":
            self.nodes.pop(message["name"], None)
        elif kind == "RegisterCommandMessage":
            self.commands[message["props"]["label"]] = message["uuid"]
        elif kind in ("NotificationShowMessage", "NotificationUpdateMessage"):
            self.notes.append(message["props"]["body"])
        elif kind == "RunJavascriptMessage" and (called := CALLED.fullmatch(message["source"])):
            self._run(called[1], json.loads(called[2]))
        elif "name" in message and "props" in message:
            self.nodes[message["name"]] = message

    def _run(self, script: str, given: dict[str, Any]) -> None:
        if script == "remember":
            self.kept = given["text"]
        elif script == "play" and "widget" in given and self.plays:
            self.send("GuiUpdateMessage", uuid=given["widget"], updates={"value": 1})
        elif script == "ticket":
            self.ticket = given["ticket"]
        elif script == "recall" and self.answers:
            value = json.dumps([self.kept, "", False, "http://127.0.0.1/", None, None])
            self.send("LocalStorageGetItemResponseMessage", value=value, error=None, request_uuid=given["request"])

    def offers(self, label: str) -> bool:
        """Whether a group of buttons has that word."""
        return any(label in (w["props"].get("options") or ()) for w in self.widgets.values())

    def press(self, label: str) -> None:
        """Press a word of a button group, or a button."""
        for uuid, widget in self.widgets.items():
            if label in (widget["props"].get("options") or ()) and widget["type"] == "GuiButtonGroupMessage":
                self.send("GuiUpdateMessage", uuid=uuid, updates={"value": label})
                break
        else:
            self.send("GuiUpdateMessage", uuid=self.find(label), updates={"value": True})

    def mark(self) -> tuple[str, float, bool] | None:
        """Where to ask, the last question answered, whether the knobs rest; None while the page is being laid out."""
        for widget in self.widgets.values():
            if found := MARK.match(str(widget["props"].get("content"))):
                return found[1], float(found[2]), found[3] == "1"
        return None

    def find(self, label: str) -> str:
        """The uuid of the widget with a label."""
        for uuid, widget in self.widgets.items():
            if widget["props"].get("label") == label:
                return uuid
        labels = sorted({str(w["props"].get("label")) for w in self.widgets.values()})
        raise LookupError(f"no widget {label!r}; there are {labels}")

    def has(self, label: str) -> bool:
        """Whether there is a widget with a label."""
        return any(w["props"].get("label") == label for w in self.widgets.values())

    def labels(self, label: str) -> int:
        """How many widgets have a label."""
        return sum(widget["props"].get("label") == label for widget in self.widgets.values())

    def value(self, label: str) -> Any:
        """The value that a widget shows."""
        return self.widgets[self.find(label)]["value"]

    def kinds(self) -> set[str]:
        """The kinds of widgets on the page."""
        return {w["type"] for w in self.widgets.values()}


class WireTab(WirePage):
    """One connection that whoever waits reads from."""

    def __init__(self, url: str, origin: str | None = None, protocol: str | None = None, kept: str | None = None,
                 camera: bool = True, hosts: Sequence[str] = (), answers: bool = True, canvas: tuple[int, int] = (1280, 720),
                 plays: bool = False, word: str = "", path: str = "", cookies: str = "", tls: ssl.SSLContext | None = None,
                 sender: str = "") -> None:
        super().__init__(kept, answers, plays)
        self.messages: list[dict[str, Any]] = []  # everything received
        self.shown: ShownPage | None = None  # what its stage and charts show, where a test asks for it before the first message
        self._questions = 0
        self.url = url
        place = urlsplit(url)
        name, *more = hosts or (place.netloc,)
        host, port = place.hostname or "", place.port or 0
        self._socket = connect(f"ws://{name}{path}", origin=Origin(origin) if origin else None,
                               sock=socket.create_connection((host, port), timeout=PATIENCE) if tls is None else tls_line(host, port, tls),
                               subprotocols=[Subprotocol(protocol or f"viser-v{version('viser')}")],
                               additional_headers=[*(("Host", host) for host in more),
                                                   *([("Cookie", cookies)] if cookies else []),
                                                   *([("X-Forwarded-For", sender)] if sender else []),
                                                   *([("Authorization", f"Bearer {word}")] if word else [])],
                               compression=None, max_size=None, open_timeout=PATIENCE, close_timeout=1.0)
        if camera:
            self.look(*canvas)

    def __enter__(self) -> WireTab:
        return self

    def __exit__(self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Leave, as a closed tab does."""
        self._socket.close()

    def cut(self) -> None:
        """Be gone without a word, as a machine is whose cable is pulled: the connection is reset."""
        self._socket.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._socket.socket.shutdown(socket.SHUT_RD)
        self._socket.socket.close()

    # --- sending ---------------------------------------------------------------------------------------------------
    def update(self, label: str, **updates: Any) -> None:
        """Change a widget as its browser would, and see it changed at once."""
        self.until(lambda: self.has(label), label)
        uuid = self.find(label)
        self.send("GuiUpdateMessage", uuid=uuid, updates=updates)
        if "value" in updates:
            self.widgets[uuid]["value"] = updates["value"]

    def press(self, label: str) -> None:
        """Press a word of a button group, or a button, once it is there."""
        self.until(lambda: self.has(label) or self.offers(label), label)
        super().press(label)

    def drag(self, name: str, phase: str, dx: float) -> None:
        """Drag a node of the scene across by dx."""
        self.until(lambda: name in self.nodes, name)
        x, y, z = 1.9, 1.45, 3.7
        self.send("SceneNodeDragMessage", phase=phase, name=name, instance_index=None, start_position=(x, y, z),
                  start_screen_pos=(0.5, 0.5), end_position=(x + dx, y, z), end_screen_pos=(0.5, 0.5), button="left",
                  modifier=None, owner=self.nodes[name].get("owner", ""))

    def send_raw(self, data: bytes | str) -> None:
        """Send anything at all."""
        self._socket.send(data)

    # --- receiving -------------------------------------------------------------------------------------------------
    def until(self, condition: Callable[[], Any], what: str = "it", patience: float = PATIENCE) -> None:
        """Receive until a condition holds; it may also be about the server."""
        end = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < end, f"{what} never happened; last notes: {self.notes[-3:]}"
            self._receive(0.05)

    def answered(self, rests: bool = False) -> None:
        """Receive until all that was sent has been answered, and the knobs rest if that is asked."""
        self._questions += 1
        asked = None

        def done() -> bool:
            nonlocal asked
            seen = self.mark()
            if seen is None:
                return False
            place, answer, resting = seen
            if place != asked:  # the page was laid out anew, and the question went with the old one
                self.send("GuiUpdateMessage", uuid=place, updates={"value": self._questions})
                asked = place
            return answer >= self._questions and (resting or not rests)
        self.until(done, "an answer to everything")

    def settle(self) -> None:
        """Receive until all is answered, the final picture stands and what follows it has been said too."""
        self.answered(rests=True)
        self.answered(rests=True)

    def unasked(self) -> list[dict[str, Any]]:
        """What comes although nothing was done: all that stands between the last message and the answer to a question."""
        before = len(self.messages)
        self.answered()
        return [m for m in self.messages[before:] if not MARK.match(str(m.get("updates", {}).get("content")))]

    def pass_time(self, seconds: float) -> None:
        """Receive while a hand makes its next move; nothing is concluded from the silence."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self._receive(left)

    def closed(self, patience: float = PATIENCE) -> int | None:
        """Receive until the server has closed the connection; the code it gave."""
        end = time.monotonic() + patience
        try:
            while time.monotonic() < end:
                self._receive(0.1)
        except ConnectionClosed as left:
            return left.rcvd.code if left.rcvd is not None else 1006
        return None

    def _receive(self, timeout: float) -> None:
        try:
            data = self._socket.recv(timeout=timeout)
        except TimeoutError:
            return
        assert isinstance(data, bytes)
        messages, arrays = unpack(data)
        for message in messages:
            self.messages.append(message)
            self.take(message)
            if self.shown is not None:
                self.shown.take(message, arrays)
