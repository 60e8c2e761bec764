"""A plain socket whose bytes one thread of asyncio carries over TLS.

Python's `ssl` below 3.13 breaks a connection that one thread reads while another writes: records arrive with a bad code, or the process
ends. The client of `websockets.sync` does just that.
"""

from __future__ import annotations

import asyncio
import socket
import ssl
import threading
from contextlib import suppress

CHUNK = 65536  # bytes


def tls_line(host: str, port: int, tls: ssl.SSLContext) -> socket.socket:
    """The near end of a connection to a server that speaks TLS; it closes when the far end does."""
    with socket.create_server(("127.0.0.1", 0)) as door:  # of TCP, since websockets sets its options
        near = socket.create_connection(door.getsockname())
        far, _ = door.accept()
    threading.Thread(target=lambda: asyncio.run(_carry(far, host, port, tls)), daemon=True, name="tls line").start()
    return near


async def _carry(far: socket.socket, host: str, port: int, tls: ssl.SSLContext) -> None:
    here, to_page = await asyncio.open_connection(sock=far)
    with suppress(OSError):
        there, to_server = await asyncio.open_connection(host, port, ssl=tls, server_hostname=host)
        ways = [asyncio.ensure_future(_copy(here, to_server)), asyncio.ensure_future(_copy(there, to_page))]
        await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        for way in ways:
            way.cancel()
        to_server.close()
    to_page.close()


async def _copy(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
    with suppress(OSError):
        while data := await source.read(CHUNK):
            sink.write(data)
            await sink.drain()
