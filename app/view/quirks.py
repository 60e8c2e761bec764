"""Everything that touches what is private in viser 1.1, in one place, so that an upgrade has one file to check."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

import viser
from viser import _messages

STORAGE = "observer-lab"
VISERS_OWN = "viser-user:"  # what viser puts before every key of localStorage that it reads
COARSE_WHILE_MOVING = """(() => {
  const page = window.__viserMutable, root = page?.scene?.__r3f?.root;
  if (!root || page.scene.userData.watched) return;
  page.scene.userData.watched = true;
  const SLOW = 34, COARSE = 0.6, REST = 450, TOGETHER = 24, COUNT = 9, opened = performance.now(), gaps = [];
  let last = 0, slow = false, timer = 0, due = 0;
  const draw = dpr => { if (root.getState().viewport.dpr !== dpr) root.getState().setDpr(dpr); };
  const frame = () => { clearTimeout(due); due = 0; root.getState().invalidate(); };
  page.scene.onAfterRender = () => {
    const now = performance.now(), gap = now - last;
    last = now;
    if (slow || gap > 250 || now - opened < 2500) return;
    gaps.push(gap);
    if (gaps.length > COUNT) gaps.shift();
    slow = gaps.length === COUNT && [...gaps].sort((a, b) => a - b)[COUNT >> 1] > SLOW;
  };
  const ask = page.requestRender;
  page.requestRender = () => {
    if (!slow) { ask(); return; }
    draw(COARSE * devicePixelRatio);
    if (window.event?.type?.startsWith('pointer')) due ||= setTimeout(frame, TOGETHER); else frame();
    clearTimeout(timer);
    timer = setTimeout(() => { draw(devicePixelRatio); ask(); }, REST);
  };
})()"""

FOLDERS_BY_KEY = """(() => {
  if (window.observerLabFolders) return;
  const dress = () => document.querySelectorAll('svg[class*="tabler-icon-chevron"]').forEach(icon => {
    const head = icon.parentElement, box = head?.parentElement;
    if (!head?.matches('.mantine-Paper-root') || !box?.matches('.mantine-Paper-root')) return;
    const open = String(icon.matches('[class*="chevron-up"]'));
    if (head.getAttribute('aria-expanded') === open) return;
    head.tabIndex = 0;
    head.setAttribute('role', 'button');
    head.setAttribute('aria-expanded', open);
  });
  let due = 0;
  window.observerLabFolders = new MutationObserver(() => {
    due ||= setTimeout(() => { due = 0; dress(); }, 200);
  });
  window.observerLabFolders.observe(document.body, {childList: true, subtree: true});
  addEventListener('keydown', event => {
    if ((event.key !== 'Enter' && event.key !== ' ') || !event.target?.matches?.('[role=button][aria-expanded]')) return;
    event.preventDefault();
    event.stopPropagation();
    event.target.click();
  }, {capture: true});
  dress();
})()"""


def close_share_tunnel(server: viser.ViserServer) -> None:
    """Unregister the handlers by which any browser could make this server open a public tunnel."""
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(message)


def foreign_origin(server: viser.ViserServer, client: viser.ClientHandle) -> str | None:
    """The Origin of a connection that another site's page opened, None when it is our own page or a script."""
    connection = server._websock_server._live_connections.get(client.client_id)
    request = getattr(connection, "request", None)
    if request is None:
        return None
    origin, host = request.headers.get("Origin"), request.headers.get("Host", "")
    if not origin:
        return None  # not a browser: a script, a test
    return None if urlsplit(origin).netloc == host else origin


def accept_values_only(client: viser.ClientHandle, refused: Callable[[], None]) -> None:
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


def accept_small_files_only(client: viser.ClientHandle, most_bytes: int, refused: Callable[[], None]) -> None:
    """Let a browser send files to upload buttons alone, one at a time, and none beyond `most_bytes`.

    viser gathers the parts of whatever is announced, to any widget, without a bound. Here a transfer that announces too
    much, or sends more than it announced, is dropped before it is gathered, and `refused` is called once for it.
    """
    connection, gui = client._websock_connection, client.gui
    start, part = gui._handle_file_transfer_start, gui._handle_file_transfer_part
    connection.unregister_handler(_messages.FileTransferStartUpload, start)
    connection.unregister_handler(_messages.FileTransferPart, part)

    async def starts(client_id: Any, message: _messages.FileTransferStartUpload) -> None:
        handle = gui._gui_input_handle_from_uuid.get(message.source_component_uuid)
        sizes = (message.size_bytes, message.part_count)
        whole = all(isinstance(size, int) and 0 <= size <= most_bytes for size in sizes)
        if not isinstance(handle, viser.GuiUploadButtonHandle) or not whole or not isinstance(message.filename, str):
            refused()
            return
        gui._drop_uploads_from_client(client_id)
        start(client_id, message)

    async def goes_on(client_id: Any, message: _messages.FileTransferPart) -> None:
        state = gui._current_file_upload_states.get(message.transfer_uuid)
        if state is None:
            return
        content = message.content
        if not isinstance(content, bytes) or state["transferred_bytes"] + len(content) > state["total_bytes"]:
            gui._drop_uploads_from_client(client_id)
            refused()
            return
        part(client_id, message)

    connection.register_handler(_messages.FileTransferStartUpload, starts)
    connection.register_handler(_messages.FileTransferPart, goes_on)


def disconnect(server: viser.ViserServer, client: viser.ClientHandle) -> None:
    """Close one connection."""
    connection = server._websock_server._live_connections.get(client.client_id)
    if connection is not None:
        server.get_event_loop().create_task(connection.close(1008, "this server answers its own page only"))


def _run(client: viser.ClientHandle, source: str) -> None:
    """Run a script in one browser: only for the calls below, for which viser has none."""
    client._websock_connection.queue_message(_messages.RunJavascriptMessage(source=source))


def coarse_while_moving(client: viser.ClientHandle) -> None:
    """On a machine that draws the scene slowly, draw it with fewer pixels while it moves, sharp again when it rests.

    viser lowers the resolution too, but to three quarters and after seconds; and after every change it goes on drawing
    for a quarter of a second, which here waits until the scene rests; what a pointer and the server's answer to it
    change is drawn in one frame. Where a frame is quick nothing changes.
    """
    _run(client, COARSE_WHILE_MOVING)


def folders_by_key(client: viser.ClientHandle) -> None:
    """Let Tab reach the heads of folders and Enter or Space open them: viser opens folders by the mouse alone."""
    _run(client, FOLDERS_BY_KEY)


def write_tab_storage(client: viser.ClientHandle, text: str) -> None:
    """Keep a text in the browser's sessionStorage: it belongs to one tab and survives a reload."""
    _run(client, f"sessionStorage.setItem({json.dumps(STORAGE)}, {json.dumps(text)})")


def read_tab_storage(client: viser.ClientHandle, timeout: float = 3.0) -> str | None:
    """The text that this tab kept, by way of localStorage, the only storage that viser reads. Blocks; not for the loop."""
    passage = f"{STORAGE}-{secrets.token_hex(8)}"
    _run(client, f"localStorage.setItem({json.dumps(VISERS_OWN + passage)}, sessionStorage.getItem({json.dumps(STORAGE)}) || '')")
    client.flush()
    try:
        return client.local_storage.get_item(passage, timeout=timeout) or None
    except (TimeoutError, RuntimeError):  # a script as client, a browser without storage, or a tab already gone
        return None
    finally:
        client.local_storage.remove_item(passage)
