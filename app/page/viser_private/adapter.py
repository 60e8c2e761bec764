"""Serve viser's tabs by subclasses of its classes: nothing of viser is replaced while it runs.

Each class names the seam on which it stands, a private method or field of viser 1.1 that a new version may move.
`tests/test_viser_seams.py` has one test for each and says which one broke; `assets/viser-requests.md` asks viser for a
public call in its place.
"""

from __future__ import annotations

import asyncio
import atexit
import dataclasses
import inspect
import itertools
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import aclosing, suppress
from functools import cache
from typing import Any, cast, get_type_hints

import numpy as np
import viser
from viser import _messages, _scene_api, infra
from viser.infra import _async_message_buffer, _infra
from websockets.exceptions import ConnectionClosed

from .message_transport import log_failed_callback, pack, read_messages, sendable
from .packed_images import pack_cached
from .thread_event import LoopEvent

Serve = Callable[..., Any]  # as `websockets.asyncio.server.serve`
hints_of = cache(get_type_hints)  # of a class of properties, which viser finds out anew for each handle
pack_image = pack_cached(_scene_api._encode_image_binary)


class TabBuffer(_async_message_buffer.AsyncMessageBuffer):
    """What waits to be sent to a page; a page may leave in the middle of an answer.

    Seam: `AsyncMessageBuffer(event_loop, persistent_messages, message_event)` and its `push`. viser keeps what is written to a page
    that has left in a queue that nobody reads, and warns. It rings an event of the loop from other threads.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, persistent: bool) -> None:
        super().__init__(loop, persistent_messages=persistent, message_event=LoopEvent())

    def push(self, message: infra.Message) -> None:
        """Keep a message until it is sent, unless nobody is there any more."""
        if not self.done:
            super().push(message)


class SocketServer(infra.WebsockServer):
    """Serve viser's connections as `serve` does it, and keep each alive whatever it says or is told.

    Seam: `WebsockServer._background_worker(ready_sem)`, which opens the port and holds the loop. viser's own opens a port by itself, asks
    nobody who comes, ends a connection at the first message that it cannot read or write, and prints. It hands each message to handlers
    that all tabs share, too: one keeps it for those who come later, one opens a public tunnel. Here none of them is called.
    """

    def __init__(self, host: str, port: int, serve: Serve) -> None:
        super().__init__(host, port, _messages.Message, None, False, _messages.ReplayDoneMessage())
        self._open_port, self._numbers = serve, itertools.count()
        self._answers: set[asyncio.Task[None]] = set()

    def _background_worker(self, ready_sem: threading.Semaphore) -> None:
        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        self._background_event_loop, self._stop_event = loop, asyncio.Event()
        self._broadcast_buffer = TabBuffer(loop, persistent=True)
        loop.run_until_complete(self._hold(self._stop_event, ready_sem))
        loop.close()

    async def _hold(self, stop: asyncio.Event, ready: threading.Semaphore) -> None:
        async with self._open_port(self._tend, self._host, self._port, compression=None, select_subprotocol=_viser_protocol) as served:
            self._port = served.sockets[0].getsockname()[1]
            ready.release()
            await stop.wait()

    async def _tend(self, socket: Any) -> None:
        """Carry messages between a page and its tab until one of them ends."""
        number = infra.ClientId(next(self._numbers))
        loop = asyncio.get_running_loop()
        state = _infra._ClientHandleState(TabBuffer(loop, persistent=False), loop)
        connection = infra.WebsockClientConnection(number, state)
        self._client_state_from_id[number], self._live_connections[number] = state, socket
        carriers: list[asyncio.Task[None]] = []

        def heard(message: infra.Message) -> None:
            answer = loop.create_task(connection._handle_incoming_message(number, message))
            self._answers.add(answer)
            answer.add_done_callback(self._answered)
        try:
            await _call_each(self._client_connect_cb, connection)
            carriers += map(loop.create_task, (send_messages(socket, state.message_buffer, number),
                                               send_messages(socket, self._broadcast_buffer, number, self._backlog_done_message),
                                               read_messages(socket, heard, self._message_class)))
            with suppress(ConnectionClosed):
                await asyncio.gather(*carriers)
        finally:
            for carrier in carriers:
                carrier.cancel()
            await asyncio.gather(*carriers, return_exceptions=True)
            state.message_buffer.set_done()
            self._client_state_from_id.pop(number, None)
            self._live_connections.pop(number, None)
            self._broadcast_buffer.generator_cursors.pop(number, None)
            await _call_each(self._client_disconnect_cb, connection)

    def _answered(self, answer: asyncio.Task[None]) -> None:
        self._answers.discard(answer)
        problem = None if answer.cancelled() else answer.exception()
        if problem is not None:
            log_failed_callback(problem)


class HintedHandles(dict[str, Any]):
    """viser's table of the widgets in a container or of the nodes of a scene, which tells each what its properties are.

    Seam: `AssignablePropsBase._prop_hints`, a cached property of each handle. Its 0.1 to 0.9 ms were a third of the price of a tab.
    """

    def __init__(self, handles: Iterable[tuple[str, Any]] = ()) -> None:
        super().__init__(handles)

    def __setitem__(self, name: str, handle: Any) -> None:
        if "_impl" in vars(handle):
            vars(handle).setdefault("_prop_hints", hints_of(type(handle._impl.props)))
        super().__setitem__(name, handle)


class LabImage(viser.ImageHandle):
    """An image whose file is packed once for all tabs. Seam: `ImageHandle.image`, whose setter packs it anew for each."""

    @property
    def image(self) -> np.ndarray:
        """The picture that is shown."""
        return self._image

    @image.setter
    def image(self, image: np.ndarray) -> None:
        self._image = image
        self._format, self._data = pack_image(image, self._user_format, self._jpeg_quality)


class LabScene(viser.SceneApi):
    """A scene whose images are packed once for all tabs, and whose failed callbacks stand in the log.

    Seams: `SceneApi.add_image`, which packs an image for each tab (50 ms), `SceneApi._dispatch_callback`, which prints what failed,
    and the table `_handle_from_node_name`.
    """

    def __init__(self, owner: Any, executor: Any, loop: Any) -> None:
        super().__init__(owner, executor, loop)
        self._handle_from_node_name = HintedHandles(self._handle_from_node_name.items())

    def add_image(self, name: str, image: np.ndarray, render_width: float, render_height: float, *, format: Any = "auto",
                  jpeg_quality: int | None = None, cast_shadow: bool = True, receive_shadow: bool | float = True, scale: Any = 1.0,
                  wxyz: Any = (1.0, 0.0, 0.0, 0.0), position: Any = (0.0, 0.0, 0.0), visible: bool = True) -> viser.ImageHandle:
        """An image of so many stage units, as viser's own."""
        kind, data = pack_image(image, format, jpeg_quality)
        props = _messages.ImageProps(_format=kind, _data=data, render_width=render_width, render_height=render_height,
                                     cast_shadow=cast_shadow, receive_shadow=receive_shadow, scale=scale)
        handle = LabImage._make(self, _messages.ImageMessage(name=name, props=props), name, wxyz, position, visible)
        handle._image, handle._jpeg_quality, handle._user_format = image, jpeg_quality, format
        return handle

    async def _dispatch_callback(self, cb: Callable[[Any], Any], event: Any) -> None:
        await _call_each([cb], event)


class LabGui(viser.GuiApi):
    """Widgets that know their properties at once. Seam: `GuiApi._resolve_container_handle`, asked for the container of each widget."""

    def __init__(self, owner: Any, executor: Any, loop: Any) -> None:
        super().__init__(owner, executor, loop)

    def _resolve_container_handle(self, container_uuid: str) -> Any:
        container = super()._resolve_container_handle(container_uuid)
        if not isinstance(container._children, HintedHandles):
            container._children = HintedHandles(container._children.items())
        return container


class LabClient(viser.ClientHandle):
    """A tab with our scene and widgets. Seam: the fields that `ClientHandle.__init__` sets; it has no place for a scene of ours."""

    def __init__(self, conn: infra.WebsockClientConnection, server: LabViser) -> None:
        self._websock_connection, self._viser_server, self.client_id = conn, server, conn.client_id
        self.scene = LabScene(self, server._thread_executor, server._event_loop)
        self.gui = LabGui(self, server._thread_executor, server._event_loop)
        self.camera = viser.CameraHandle(self)
        self.local_storage = viser.LocalStorageHandle(self)


class LabViser(viser.ViserServer):
    """viser's server on a `SocketServer`, with tabs of `LabClient`, without a line on the terminal.

    Seam: the fields that `ViserServer.__init__` sets; it makes its own socket server, opens a port and prints a table.
    """

    def __init__(self, host: str, port: int, label: str, serve: Serve) -> None:
        self._websock_server = self._connection = server = SocketServer(host, port, serve)
        self._initial_camera = viser.InitialCameraConfig(broadcast=server.queue_message)
        self._connected_clients, self._client_lock = {}, threading.Lock()
        self._scene_lifecycle_lock, self._share_tunnel_lock = threading.RLock(), threading.Lock()
        self._client_connect_cb, self._client_disconnect_cb = [], []
        self._thread_executor = ThreadPoolExecutor(max_workers=1)  # for callbacks that are no coroutines, of which we have none
        self._share_tunnel = None
        server.on_client_connect(self._arrive)
        server.on_client_disconnect(self._depart)
        server.start()
        atexit.register(self.stop)
        self._event_loop = server._broadcast_buffer.event_loop
        self.scene = viser.SceneApi(self, self._thread_executor, self._event_loop)
        self.gui = viser.GuiApi(self, self._thread_executor, self._event_loop)
        self.scene.reset()
        self.scene.set_up_direction("+z")
        self.gui.reset()
        self.gui.set_panel_label(label)

    def _arrive(self, connection: infra.WebsockClientConnection) -> None:
        """Take in a connection; it becomes a tab when its page first says where its camera is."""
        self._run_garbage_collector()
        client = LabClient(connection, self)

        async def looked(_: infra.ClientId, message: _messages.ViewerCameraMessage) -> None:
            camera, seen = client.camera, message
            new = client.client_id not in self._connected_clients
            camera._state = dataclasses.replace(
                camera._state, wxyz=np.array(seen.wxyz), position=np.array(seen.position), fov=seen.fov, near=seen.near, far=seen.far,
                image_height=seen.image_height, image_width=seen.image_width, look_at=np.array(seen.look_at),
                up_direction=np.array(seen.up_direction), update_timestamp=1.0)
            if new and not connection.get_message_buffer().done:
                with self._client_lock:
                    self._connected_clients[client.client_id] = client
                    callbacks = tuple(self._client_connect_cb)
                await self._dispatch_client_callbacks(callbacks, client)
            for callback in camera._state.camera_cb:
                await _call_each([callback], camera)
        connection.register_handler(_messages.ViewerCameraMessage, looked)

    async def _depart(self, connection: infra.WebsockClientConnection) -> None:
        with self._client_lock:
            client = self._connected_clients.pop(connection.client_id, None)
            callbacks = tuple(self._client_disconnect_cb)
        if client is None:
            return
        number = infra.ClientId(client.client_id)
        client.gui._drop_uploads_from_client(number)
        await client.scene._drop_active_drags_for_client(number, event_client=client)
        await self._dispatch_client_callbacks(callbacks, client)

    async def _dispatch_client_callbacks(self, callbacks: Iterable[Callable[[Any], Any]], client: viser.ClientHandle) -> None:
        await _call_each(callbacks, client)


class CleanRecorder(infra.StateSerializer):
    """A recording that holds any text. Seam: `StateSerializer._insert_message`; viser's packs half of a surrogate pair and fails."""

    def _insert_message(self, message: infra.Message) -> None:
        if self._filter(message):
            self._messages.append((self._time, sendable(message.as_serializable_dict(self._binary_buffers))))


async def send_messages(socket: Any, buffer: _async_message_buffer.AsyncMessageBuffer, number: int,
                        last: infra.Message | None = None) -> None:
    """Send what stands in a buffer, batch by batch, until the page has left; `last` goes after what stood there at the start.

    Seam: `AsyncMessageBuffer.window_generator`, which gathers a batch.
    """
    async with aclosing(cast(Any, buffer.window_generator(number, backlog_done_message=last))) as batches:
        async for batch in batches:
            await socket.send(pack(batch))


async def _call_each(callbacks: Iterable[Callable[[Any], Any]], told: Any) -> None:
    """Call each; one that fails stands in the log and keeps nobody from the next."""
    for callback in tuple(callbacks):
        try:
            answer = callback(told)
            if inspect.isawaitable(answer):
                await answer
        except Exception as problem:
            log_failed_callback(problem)


def _viser_protocol(_: object, offered: Iterable[Any]) -> Any:
    """The protocol that viser's page offers, whatever its version."""
    return next((protocol for protocol in offered if protocol.startswith("viser-v")), None)
