"""Collect all code that touches private parts of viser 1.1, so that an upgrade checks one file."""

from __future__ import annotations

import asyncio
import secrets
import socket
import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from functools import cache
from types import MappingProxyType, SimpleNamespace
from typing import Any, cast, get_type_hints
from unittest import mock

import msgspec
import viser
import websockets.asyncio.server
from viser import _assignable_props_api, _messages, _scene_api, _threadpool_exceptions, infra
from viser.infra import _infra

from .. import web
from ..access.connection import Connection
from ..access.handshake import MAX_MESSAGE_BYTES, AdmissionControl, PackedPage, serve_guarded
from ..web.html_page import APP_NAME, app_page
from .browser_storage import check_browser_memory
from .message_transport import log_failed_callback, pack_any_text, read_messages
from .packed_images import pack_cached
from .stage_frames import Frame, viser_value
from .thread_event import LoopEvent

SPARE = 10_000  # bytes of a message beside what it carries
OPENING = threading.Lock()  # two servers opened at once would take each other's socket
OWN_DOORS = frozenset({"ViewerCameraMessage", "GuiUpdateMessage", "CommandTriggerMessage", "SceneNodeDragMessage",
                       "SceneNodeClickMessage", "FileTransferStartUpload", "FileTransferPart"})
HINTS = cache(get_type_hints)  # of a class, which viser finds out anew for each handle: a third of the price of a tab
_assignable_props_api.AssignablePropsBase._prop_hints = property(lambda handle: HINTS(type(handle._impl.props)))  # type: ignore
_scene_api._encode_image_binary = pack_cached(_scene_api._encode_image_binary)
_infra._message_consumer = read_messages
_infra.msgspec = SimpleNamespace(msgpack=SimpleNamespace(encode=pack_any_text(msgspec.msgpack.encode)))  # type: ignore[assignment]
_threadpool_exceptions.print = lambda *_, **__: None  # type: ignore[attr-defined]
_threadpool_exceptions.traceback = SimpleNamespace(print_exception=log_failed_callback)  # type: ignore[assignment]
MOVES = MappingProxyType({"SetPositionMessage": "position", "SetOrientationMessage": "wxyz", "SetSceneNodeVisibilityMessage": "visible"})


def open_server(listener: socket.socket, reception: AdmissionControl, language: str = "en") -> viser.ViserServer:
    """viser's server on a socket that listens, behind a reception, with our own page.

    viser itself opens a port of its own, asks nobody who comes, takes messages of 50 MB, serves the page that it is
    shipped with and prints a table. Here nobody is let in until every door that all tabs share is closed.
    """
    ready = threading.Event()
    host, port = listener.getsockname()[:2]
    serve = serve_guarded(listener, PackedPage.of(app_page(language)), reception, ready.is_set, f"viser-v{viser.__version__}")
    with OPENING, mock.patch.object(websockets.asyncio.server, "serve", serve), mock.patch("rich.print"):
        server = viser.ViserServer(host=host, port=port, label=APP_NAME, verbose=False)
    close_shared_doors(server)

    @server._websock_server.on_client_connect
    def _(connection: infra.WebsockClientConnection) -> None:
        keep_own_doors(connection)

    ready.set()
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop the server, without the line that viser prints."""
    with OPENING, mock.patch("rich.print"):
        server.stop()


def open_tab(server: viser.ViserServer, client_id: int) -> Connection | None:
    """Tell the connection that its tab stands: from now on it may send what a page in use sends. None where it has left."""
    connection = server._websock_server._live_connections.get(infra.ClientId(client_id))
    if not isinstance(connection, Connection):
        return None
    connection.open_tab()
    return connection


def fixed_camera(client: viser.ClientHandle, width: int, height: int) -> viser.CameraHandle:
    """A camera that no browser moves, in a canvas of so many pixels."""
    camera = viser.CameraHandle(client)
    state = camera._state
    state.image_width, state.image_height, state.update_timestamp = width, height, 1.0
    state.position[1] = -1.0  # none stands where it looks at
    return camera


def close_shared_doors(server: viser.ViserServer) -> frozenset[str]:
    """Take away every handler by which a message of one tab acts on the server or on all tabs; their names.

    Among them are one that hands a message on to everybody and keeps it for those who come later, and one that opens a
    public tunnel. All that we show belongs to one tab, so none is needed.
    """
    handlers = server._websock_server._incoming_handlers
    names = frozenset(message.__name__ for message in handlers)
    handlers.clear()
    return names


def keep_own_doors(connection: infra.WebsockClientConnection) -> frozenset[str]:
    """Leave to a connection, before its first message is read, the handlers that our widgets use; the names of the others."""
    handlers = connection._incoming_handlers
    closed = [message for message in handlers if message.__name__ not in OWN_DOORS]
    for message in closed:
        del handlers[message]
    return frozenset(message.__name__ for message in closed)


def accept_values_only(client: viser.ClientHandle, refused: Callable[[], object]) -> None:
    """Let a browser set the `value` of its widgets and nothing else.

    viser sets whatever attribute of a widget a message names, without a check; a value of the wrong kind raises
    before any callback of ours. Both end here: `refused` is called, and nothing was changed.
    """
    connection, inner = client._websock_connection, client.gui._handle_gui_updates
    connection.unregister_handler(_messages.GuiUpdateMessage, inner)

    async def guarded(client_id: Any, message: _messages.GuiUpdateMessage) -> None:
        if not isinstance(message.updates, dict) or set(message.updates) != {"value"}:
            refused()
            return
        try:
            await inner(client_id, message)
        except (TypeError, ValueError, AssertionError, OverflowError):
            refused()

    connection.register_handler(_messages.GuiUpdateMessage, guarded)


def may_leave(client: viser.ClientHandle) -> None:
    """Let a tab leave in the middle of an answer: what is written to it after that is dropped.

    viser keeps it in a queue that nobody reads any more, and warns of the first message. No order of ending things could
    avoid that: a browser goes without asking, and its answer is written on another thread.
    """
    buffer = client._websock_connection.get_message_buffer()
    buffer.message_event.__class__ = LoopEvent  # the tab's own thread rings it
    push, buffer._warned_push_after_done = buffer.push, True

    def push_to_who_is_there(message: _messages.Message) -> None:
        if not buffer.done:
            push(message)

    buffer.push = push_to_who_is_there  # type: ignore[method-assign]


def hang_up(server: viser.ViserServer, client_id: int) -> None:
    """Close the connection of a tab from any thread; viser has no call for it. Its page comes back by itself."""
    connection = server._websock_server._live_connections.get(infra.ClientId(client_id))
    if connection is not None:
        asyncio.run_coroutine_threadsafe(connection.close(1011), connection.loop)


def accept_small_files_only(client: viser.ClientHandle, most_bytes: int, refused: Callable[[], object]) -> None:
    """Let a browser send files to upload buttons alone, one at a time, and none beyond `most_bytes`.

    viser gathers the parts of whatever is announced, to any widget, without a bound. Here a transfer that announces too
    much, or sends more than it announced, is dropped before it is gathered, and `refused` is called once for it.
    """
    connection, gui = client._websock_connection, client.gui
    start, part = gui._handle_file_transfer_start, gui._handle_file_transfer_part
    connection.unregister_handler(_messages.FileTransferStartUpload, start)
    connection.unregister_handler(_messages.FileTransferPart, part)

    def over(message: Any) -> None:  # what its own button would say, if the page had not another one by then
        connection.queue_message(_messages.FileTransferPartAck(str(message.source_component_uuid), str(message.transfer_uuid), 1, 1))
        connection.queue_message(_messages.RemoveNotificationMessage(f"upload-{message.transfer_uuid}"))

    async def starts(client_id: Any, message: _messages.FileTransferStartUpload) -> None:
        handle = gui._gui_input_handle_from_uuid.get(message.source_component_uuid)
        sizes = (message.size_bytes, message.part_count)
        whole = all(isinstance(size, int) and 0 <= size <= most_bytes for size in sizes)
        if not isinstance(handle, viser.GuiUploadButtonHandle) or not whole or not isinstance(message.filename, str):
            over(message)
            refused()
            return
        gui._drop_uploads_from_client(client_id)
        start(client_id, message)
        if not message.part_count:
            over(message)

    async def goes_on(client_id: Any, message: _messages.FileTransferPart) -> None:
        state, content = gui._current_file_upload_states.get(message.transfer_uuid), message.content
        if state is None:
            return
        if isinstance(content, bytes) and state["transferred_bytes"] + len(content) <= state["total_bytes"]:
            part(client_id, message)
        else:
            gui._drop_uploads_from_client(client_id)
            refused()
        if message.transfer_uuid not in gui._current_file_upload_states:
            over(message)

    connection.register_handler(_messages.FileTransferStartUpload, starts)
    connection.register_handler(_messages.FileTransferPart, goes_on)


def run_script(client: viser.ClientHandle, name: str, **given: object) -> None:
    """Run a script of ours in one browser: only for what viser has no call for."""
    client._websock_connection.queue_message(_messages.RunJavascriptMessage(source=web.call_reporting_errors(name, **given)))


def move(scene: viser.SceneApi, frame: Frame) -> None:
    """Move nodes, by one message for each value; viser's own way compares every number a second time."""
    for (name, kind), value in frame.items():
        numbers = viser_value(kind, value)
        scene._queue_scene_message(_messages.SetPositionMessage(name, numbers) if kind == "position" else
                                   _messages.SetOrientationMessage(name, numbers) if kind == "wxyz" else
                                   _messages.SceneNodeUpdateMessage(name, {kind: numbers}))


def unsent(client: viser.ClientHandle) -> bool:
    """Whether something still waits to be sent: a browser that is behind, or a server that is, is not given more to show."""
    return bool(client._websock_connection.get_message_buffer().message_from_id)


def node_id(widget: Any) -> str:
    """The name by which a browser's messages speak of a widget."""
    return widget._impl.uuid


def write(widget: Any, value: Any) -> None:
    """Give a widget a value and send it, also where it has it here already: what its browser shows may be another.

    Setting `.value` sends nothing then, and wakes the callbacks that a browser's own change wakes.
    """
    widget._impl.value = value = type(widget.value)(value)
    widget._queue_update("value", value)


def ask_storage(client: viser.ClientHandle, key: str, shelf: str,
                answer: Callable[..., object]) -> None:
    """Ask the page what it keeps under these keys and what stands in its address bar; `answer` is called on the event loop with
    what `check_browser_memory` makes of it, when it comes, which may be never."""
    request, connection = secrets.token_hex(8), client._websock_connection

    def heard(client_id: Any, message: _messages.LocalStorageGetItemResponseMessage) -> None:
        if message.request_uuid == request:
            connection.unregister_handler(_messages.LocalStorageGetItemResponseMessage, heard)
            answer(*check_browser_memory(message.value))

    connection.register_handler(_messages.LocalStorageGetItemResponseMessage, heard)
    run_script(client, "recall", key=key, shelf=shelf, most=MAX_MESSAGE_BYTES - SPARE, request=request)
    client.flush()


class Tape(infra.WebsockMessageHandler):
    """Where a scene is put that no browser looks at: `viser.ClientHandle` as far as the stage and its boards use one.

    viser makes its recording of all that is put there but for what happens in `changes`.
    """

    def __init__(self, camera: Any) -> None:
        super().__init__()
        self.client_id, self.camera = 0, camera
        self._websock_connection = self._viser_server = self
        self._scene_lifecycle_lock = threading.RLock()
        self._sent: list[Any] | None = None  # while changes are watched
        self._recorder = self.get_message_serializer(lambda message: message.include_in_scene_serialization and self._sent is None)
        nobody: Any = None  # looks, so no callback is ever called
        self.scene = viser.SceneApi(cast(Any, self), nobody, nobody)

    def get_message_buffer(self) -> Any:
        """Where viser puts a message."""
        return self

    def push(self, message: infra.Message) -> None:
        """Keep a message while changes are watched."""
        if self._sent is not None:
            self._sent.append(message)

    @contextmanager
    def atomic(self) -> Generator[None, None, None]:
        """Nobody looks, so nothing is seen half done."""
        yield

    def changes(self, step: Callable[[], object]) -> Iterator[tuple[str, str, Any]]:
        """What a step changes: the name of the node, the property and its value."""
        self._sent = sent = []
        step()
        self._sent = None
        for message in sent:
            kind, name = type(message).__name__, message.name
            changed = {MOVES[kind]: getattr(message, MOVES[kind])} if kind in MOVES else message.updates
            yield from ((name, prop, value) for prop, value in changed.items())

    def recording(self) -> bytes:
        """viser's recording, with the scripts that were run; once."""
        return self._recorder.serialize()
