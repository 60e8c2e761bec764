"""Each place where we stand on what is private in viser: a new version that moves it fails one test here, by the seam's name."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import logging
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_type_hints

import msgspec
import numpy as np
import pytest
import viser
import zstandard
from syntax import ROOT
from viser import _messages, infra
from viser._assignable_props_api import AssignablePropsBase
from viser.infra import _async_message_buffer, _infra
from websockets.asyncio.server import serve
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from observer_lab.page.viser_private import adapter, message_transport
from observer_lab.page.viser_private.scene_tape import Tape
from observer_lab.page.viser_private.shared_page import SharedPage

SEAMS = {  # class of ours or function → what of viser it takes the place of, and its parameters
    adapter.TabBuffer.push: (_async_message_buffer.AsyncMessageBuffer.push, "self message"),
    adapter.SocketServer._background_worker: (infra.WebsockServer._background_worker, "self ready_sem"),
    adapter.LabScene.add_image: (viser.SceneApi.add_image, "self name image render_width render_height format jpeg_quality cast_shadow "
                                                           "receive_shadow scale wxyz position visible"),
    adapter.LabScene._dispatch_callback: (viser.SceneApi._dispatch_callback, "self cb event"),
    adapter.LabGui._resolve_container_handle: (viser.GuiApi._resolve_container_handle, "self container_uuid"),
    adapter.LabViser._dispatch_client_callbacks: (viser.ViserServer._dispatch_client_callbacks, "self callbacks client"),
    adapter.CleanRecorder._insert_message: (infra.StateSerializer._insert_message, "self message"),
    message_transport.read_messages: (_infra._message_consumer, "websocket handle_message message_class"),
}


@contextlib.contextmanager
def seam(name: str) -> Iterator[None]:
    """Say which seam broke, whatever breaks in it."""
    try:
        yield
    except Exception as problem:
        raise AssertionError(f"viser {viser.__version__} moved the seam {name}: see app/page/viser_private/adapter.py "
                             f"({type(problem).__name__}: {problem})") from problem


def parameters(function: Callable[..., object]) -> str:
    return " ".join(inspect.signature(function).parameters)


@pytest.mark.parametrize("ours", SEAMS, ids=lambda ours: ours.__qualname__)
def test_what_ours_takes_the_place_of_is_there_and_takes_what_it_took(ours: Callable[..., object]) -> None:
    theirs, taken = SEAMS[ours]
    with seam(theirs.__qualname__):
        assert parameters(theirs) == taken
        if ours is not message_transport.read_messages:
            assert parameters(ours) == taken


@pytest.fixture(scope="module")
def stock() -> Iterator[viser.ViserServer]:
    """viser's own server, with one tab of its own."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


def fields(thing: object) -> set[str]:
    return set(vars(thing))


def connection(server: viser.ViserServer) -> Any:
    loop = server._event_loop
    return infra.WebsockClientConnection(0, _infra._ClientHandleState(adapter.TabBuffer(loop, persistent=False), loop))


@pytest.fixture(scope="module")
def lab() -> Iterator[adapter.LabViser]:
    """Our server on a port that the system gives, asking nobody who comes."""
    server = adapter.LabViser("127.0.0.1", 0, "seams", serve)
    yield server
    server.stop()


def test_a_server_has_the_fields_that_visers_own_has(stock: viser.ViserServer, lab: adapter.LabViser) -> None:
    with seam("ViserServer.__init__"):
        assert fields(lab) == fields(stock)
    with seam("WebsockServer.__init__"):
        assert fields(lab._websock_server) - fields(stock._websock_server) == {"_open_port", "_numbers", "_answers"}
        assert fields(lab._websock_server) >= fields(stock._websock_server)


def test_a_tab_has_the_fields_that_visers_own_has(stock: viser.ViserServer, lab: adapter.LabViser) -> None:
    with seam("ClientHandle.__init__"):
        own, theirs = adapter.LabClient(connection(lab), lab), viser.ClientHandle(connection(stock), stock)
        assert fields(own) == fields(theirs) and fields(own.scene) == fields(theirs.scene) and fields(own.gui) == fields(theirs.gui)


def test_a_page_that_comes_is_sent_what_all_see_and_reported_once(lab: adapter.LabViser) -> None:
    """The loop over a connection: version, backlog, the marker after it, the camera, callbacks, and the end."""
    met, left = [], []

    async def comes(client: viser.ClientHandle) -> None:
        met.append((client.client_id, tuple(client.camera.position), type(client)))

    async def leaves(client: viser.ClientHandle) -> None:
        left.append(client.client_id)
    lab.on_client_connect(comes)
    lab.on_client_disconnect(leaves)
    with seam("WebsockServer._background_worker"):
        with connect(f"ws://127.0.0.1:{lab.get_port()}", subprotocols=[Subprotocol(f"viser-v{viser.__version__}")]) as page:
            kinds = []
            while "ReplayDoneMessage" not in kinds:
                kinds += [message["type"] for message in unpacked(page.recv(timeout=60))]
            assert "SetGuiPanelLabelMessage" in kinds and kinds[-1] == "ReplayDoneMessage"
            look = {"type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (1.0, 2.0, 3.0), "fov": 1.0, "near": 0.1,
                    "far": 9.0, "image_height": 10, "image_width": 20, "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0)}
            for _ in range(2):
                page.send(msgspec.msgpack.encode(look))
            wait_for(lambda: met)
        wait_for(lambda: left)
        assert met == [(left[0], (1.0, 2.0, 3.0), adapter.LabClient)] and len(left) == 1
        server = lab._websock_server
        assert not (server._client_state_from_id or server._live_connections or lab.get_clients())


def wait_for(come: Callable[[], object]) -> None:
    end = time.monotonic() + 60
    while not come():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.01)


def arrays(batch: bytes) -> bytes:
    """What stands behind the messages of a batch, from the first array on."""
    return batch[16 + int.from_bytes(batch[8:16], "little"):].lstrip(b"\0")


def unpacked(batch: bytes | str) -> list[dict[str, Any]]:
    assert isinstance(batch, bytes)
    long, short = (int.from_bytes(batch[at:at + 8], "little") for at in (0, 8))
    return msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(batch[16:16 + short], max_output_size=long))["messages"]


def test_a_batch_is_packed_as_viser_packs_it() -> None:
    """viser's own sender and ours, of the same messages with arrays of odd lengths."""
    messages = [_messages.SetPositionMessage("/a", (1.0, 2.0, 3.0)),
                *(_messages.SceneNodeUpdateMessage("/b", {"points": np.arange(n, dtype=np.uint8)}) for n in (1, 8, 13))]
    sent: list[bytes] = []

    async def send(batch: bytes) -> None:
        sent.append(batch)
        buffer.set_done()

    async def run() -> None:
        nonlocal buffer
        buffer = adapter.TabBuffer(asyncio.get_running_loop(), persistent=False)
        for message in messages:
            buffer.push(message)
        await _infra._message_producer(SimpleNamespace(send=send), buffer, 0)  # type: ignore[arg-type]
        buffer = adapter.TabBuffer(asyncio.get_running_loop(), persistent=False)
        for message in messages:
            buffer.push(message)
        await adapter.send_messages(SimpleNamespace(send=send), buffer, 0)
    buffer: Any = None
    with seam("_message_producer"):
        asyncio.run(run())
        theirs, own = sent
        assert unpacked(theirs) == unpacked(own)
        assert arrays(theirs) == arrays(own) != b""


def test_what_is_written_to_a_page_that_has_left_is_dropped_without_a_warning() -> None:
    with seam("AsyncMessageBuffer.push"):
        buffer = adapter.TabBuffer(asyncio.new_event_loop(), persistent=False)
        buffer.set_done()
        buffer.push(_messages.SetPositionMessage("/a", (1.0, 2.0, 3.0)))
        assert not buffer.message_from_id


def shared_page() -> SharedPage:
    return SharedPage(10, 10, lambda _: None)


def test_each_widget_and_node_knows_its_properties_without_reading_them_anew() -> None:
    page = shared_page()
    with seam("AssignablePropsBase._prop_hints"):
        assert type(vars(AssignablePropsBase)["_prop_hints"]).__name__ == "cached_property"
        with page.gui.add_folder("a"):
            inner = page.gui.add_slider("b", 0.0, 1.0, 0.1, 0.5)
        handles = [inner, page.gui.add_html("c"), page.gui.add_markdown("d"), page.scene.add_frame("/e/f"), page.scene.add_label("/g", "h")]
        for handle in handles:
            assert vars(handle)["_prop_hints"] is adapter.hints_of(type(handle._impl.props))
            assert vars(handle)["_prop_hints"] == get_type_hints(type(handle._impl.props))


def test_an_image_is_packed_once_for_all_tabs_and_sent_as_visers_own() -> None:
    image = np.random.default_rng(5).integers(0, 255, (8, 9, 3), dtype=np.uint8)
    with seam("SceneApi.add_image"):
        pages = [shared_page(), shared_page()]
        given = {"format": "png", "cast_shadow": False, "receive_shadow": 0.5, "position": (1.0, 2.0, 3.0), "wxyz": (0.0, 1.0, 0.0, 0.0)}
        own, other = (page.scene.add_image("/i", image, 2.0, 3.0, **given) for page in pages)
        theirs = viser.SceneApi.add_image(pages[0].scene, "/j", image, 2.0, 3.0, **given)
        assert vars(own._impl.props) == vars(theirs._impl.props) and own._impl.props._data is other._impl.props._data
        for handle in (own, other, theirs):
            handle.image = 255 - image
        assert own._impl.props._data == theirs._impl.props._data and own._impl.props._data is other._impl.props._data
        assert own.image is not image


def test_a_failed_callback_stands_in_the_log_and_keeps_nobody_from_the_next(caplog: pytest.LogCaptureFixture) -> None:
    heard = []

    async def fails(_: object) -> None:
        raise ZeroDivisionError("of a callback")
    with seam("SceneApi._dispatch_callback"), caplog.at_level(logging.ERROR):
        asyncio.run(shared_page().scene._dispatch_callback(fails, None))
        assert [record.exc_info[0] for record in caplog.records if record.exc_info] == [ZeroDivisionError]

        async def meets(client: object) -> None:
            heard.append(client)
        asyncio.run(adapter.LabViser._dispatch_client_callbacks(None, [fails, meets], "tab"))  # type: ignore[arg-type]
        assert heard == ["tab"] and len(caplog.records) == 2


def test_a_recording_holds_any_text() -> None:
    with seam("StateSerializer._insert_message"):
        tape = Tape(None)
        tape.scene.add_label("/a", "half \ud800 a pair")
        assert len(tape.recording()) > 20


def test_what_is_asked_of_viser_names_each_seam() -> None:
    asked = (ROOT / "assets" / "viser-requests.md").read_text(encoding="utf-8")
    source = Path(adapter.__file__).read_text(encoding="utf-8")
    named = {name for words in re.findall(r"Seams?: (.*?)(?:\"\"\"|\n\n)", source, re.S)
             for name in re.findall(r"`([A-Za-z]\w*(?:\.\w+)+)", words)}
    assert len(named) >= 8 and [name for name in sorted(named) if f"`{name}" not in asked] == []
