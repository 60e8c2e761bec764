"""Collect our calls of what is private in viser 1.1; `adapter.py` has classes in place of its own."""

from __future__ import annotations

import asyncio
import secrets
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import viser
from viser import _messages, infra
from websockets.exceptions import ConnectionClosed

from .. import web
from ..access.connection import Connection
from ..access.handshake import MAX_MESSAGE_BYTES, AdmissionControl, PackedPage, serve_guarded
from ..web.html_page import APP_NAME, app_page
from .adapter import LabViser
from .browser_storage import check_browser_memory
from .heartbeat import NAME, beat, press
from .message_transport import pack
from .stage_frames import Frame, viser_value

SPARE = 10_000  # bytes of a message beside what it carries
OWN_DOORS = frozenset({"ViewerCameraMessage", "GuiUpdateMessage", "CommandTriggerMessage", "SceneNodeDragMessage",
                       "SceneNodeClickMessage", "FileTransferStartUpload", "FileTransferPart"})


def open_server(listener: socket.socket, admission: AdmissionControl, language: str = "en") -> LabViser:
    """viser's server on a socket that listens, behind admission control, with our own page. Nobody is let in before all stands."""
    ready = threading.Event()
    host, port = listener.getsockname()[:2]
    serve = serve_guarded(listener, PackedPage.of(app_page(language)), admission, ready.is_set, f"viser-v{viser.__version__}")
    server = LabViser(host, port, APP_NAME, serve)

    @server._websock_server.on_client_connect
    def _(connection: infra.WebsockClientConnection) -> None:
        keep_own_doors(connection)
        answer_beats(server, connection)

    ready.set()
    return server


def open_tab(server: viser.ViserServer, client_id: int) -> Connection | None:
    """Tell the connection that its tab stands: from now on it may send what a page in use sends. None where it has left."""
    connection = connection_of(server, client_id)
    if connection is not None:
        connection.open_tab()
    return connection


def connection_of(server: viser.ViserServer, client_id: int) -> Connection | None:
    """The connection of a tab; None where it has left."""
    connection = server._websock_server._live_connections.get(infra.ClientId(client_id))
    return connection if isinstance(connection, Connection) else None


def fixed_camera(client: viser.ClientHandle, width: int, height: int) -> viser.CameraHandle:
    """A camera that no browser moves, in a canvas of so many pixels."""
    camera = viser.CameraHandle(client)
    state = camera._state
    state.image_width, state.image_height, state.update_timestamp = width, height, 1.0
    state.position[1] = -1.0  # none stands where it looks at
    return camera


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


def tell_what_came_too_late(client: viser.ClientHandle) -> None:
    """Tell the page what came too late for its widget, while the page was being laid out anew. viser drops it; the page does it again.

    Handlers are called in order, and viser's own come later than these.
    """
    connection, gui, last = client._websock_connection, client.gui, 0  # the number of the last press
    inner = {_messages.GuiUpdateMessage: (gui._handle_gui_updates, gui._gui_input_handle_from_uuid),
             _messages.CommandTriggerMessage: (gui._handle_command_trigger, gui._command_handle_from_uuid)}

    def numbered(_: Any, message: _messages.LocalStorageGetItemResponseMessage) -> None:
        nonlocal last
        last = press(message) or last

    def looked_up(_: Any, message: Any) -> None:
        widget: Any = inner[type(message)][1].get(message.uuid)
        if (widget is None or widget._impl.removed) and NAME.fullmatch(message.uuid):
            run_script(client, "missed", widget=message.uuid, press=last)
            client.flush()
    for kind, (takes, _) in inner.items():
        connection.unregister_handler(kind, takes)
        connection.register_handler(kind, looked_up)
        connection.register_handler(kind, takes)
    connection.register_handler(_messages.LocalStorageGetItemResponseMessage, numbered)


def hang_up(server: viser.ViserServer, client_id: int, reason: str = "") -> None:
    """Close the connection of a tab from any thread; viser has no call for it. Its page comes back by itself, or does as `reason` says."""
    connection = server._websock_server._live_connections.get(infra.ClientId(client_id))
    if connection is not None:
        asyncio.run_coroutine_threadsafe(connection.close(1011, reason), connection.loop)


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


def ask_storage(client: viser.ClientHandle, key: str, shelf: str, lessons: str, answer: Callable[..., object]) -> None:
    """Ask the page what it keeps under these keys and what stands in its address bar; `answer` is called on the event loop with
    what `check_browser_memory` makes of it, when it comes, which may be never."""
    request, connection = secrets.token_hex(8), client._websock_connection

    def heard(client_id: Any, message: _messages.LocalStorageGetItemResponseMessage) -> None:
        if message.request_uuid == request:
            connection.unregister_handler(_messages.LocalStorageGetItemResponseMessage, heard)
            answer(*check_browser_memory(message.value))

    connection.register_handler(_messages.LocalStorageGetItemResponseMessage, heard)
    run_script(client, "recall", key=key, shelf=shelf, lessons=lessons, most=MAX_MESSAGE_BYTES - SPARE,
               request=request)
    client.flush()


def answer_beats(server: viser.ViserServer, connection: infra.WebsockClientConnection) -> None:
    """Answer each question of a page whether its connection is alive with an empty batch, whether it has a tab yet or not."""
    socket: Any = server._websock_server._live_connections[infra.ClientId(connection.client_id)]

    async def heard(_: Any, message: _messages.LocalStorageGetItemResponseMessage) -> None:
        if beat(message) is not None and not socket.transport.get_write_buffer_size():  # else it gets something as it is
            with suppress(ConnectionClosed):  # the page has left meanwhile
                await socket.send(pack([]))
    connection.register_handler(_messages.LocalStorageGetItemResponseMessage, heard)


def hear_beats(client: viser.ClientHandle, asked: Callable[[int], object], pressed: Callable[[int], object] = id) -> None:
    """Hand on the number of the last edit that a page waits for, each time that it asks, and that of each press before it comes."""
    def heard(_: Any, message: _messages.LocalStorageGetItemResponseMessage) -> None:
        if number := beat(message):
            asked(int(number))
        elif count := press(message):
            pressed(count)
    client._websock_connection.register_handler(_messages.LocalStorageGetItemResponseMessage, heard)
