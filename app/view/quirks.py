"""Everything that touches what is private in viser 1.1, in one place, so that an upgrade has one file to check."""

from __future__ import annotations

from urllib.parse import urlsplit

import viser
from viser import _messages


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
    if not origin or origin == "null":
        return None
    return None if urlsplit(origin).netloc == host else origin


def disconnect(server: viser.ViserServer, client: viser.ClientHandle) -> None:
    """Close one connection."""
    connection = server._websock_server._live_connections.get(client.client_id)
    if connection is not None:
        server.get_event_loop().create_task(connection.close(1008, "this server answers its own page only"))


def run_javascript(client: viser.ClientHandle, source: str) -> None:
    """Run a script in one browser: used only for what viser has no call for."""
    client._websock_connection.queue_message(_messages.RunJavascriptMessage(source=source))
