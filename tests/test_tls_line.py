"""The line by which the tests' tabs speak TLS: one thread reads it while another writes, and no byte is lost or changed."""

from __future__ import annotations

import asyncio
import socket
import ssl
import subprocess
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from tls_line import tls_line

NUMBERS = 40_000


@pytest.fixture
def echo(tmp_path: Path) -> Iterator[int]:
    """The port of a server that gives back over TLS what it is told."""
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-keyout", key,
                    "-out", certificate], check=True, capture_output=True)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate, key)
    ready, end = threading.Event(), asyncio.Event()
    ports: list[int] = []
    loops: list[asyncio.AbstractEventLoop] = []

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with suppress(asyncio.CancelledError):  # asyncio asks this task for its error when the loop ends
            while data := await reader.read(5000):
                writer.write(data)
                await writer.drain()
            writer.close()

    async def serve() -> None:
        async with await asyncio.start_server(answer, "127.0.0.1", 0, ssl=context) as server:
            ports.append(server.sockets[0].getsockname()[1])
            loops.append(asyncio.get_running_loop())
            ready.set()
            await end.wait()
    thread = threading.Thread(target=lambda: asyncio.run(serve()))
    thread.start()
    assert ready.wait(60)
    yield ports[0]
    loops[0].call_soon_threadsafe(end.set)
    thread.join(60)


def test_one_thread_reads_while_another_writes(echo: int) -> None:
    line = tls_line("127.0.0.1", echo, ssl._create_unverified_context())
    sent = b"".join(number.to_bytes(4, "big") for number in range(NUMBERS))
    heard = bytearray()

    def read() -> None:
        while len(heard) < len(sent) and (data := line.recv(3000)):
            heard.extend(data)
    reader = threading.Thread(target=read)
    reader.start()
    for at in range(0, len(sent), 400):
        line.sendall(sent[at:at + 400])
    reader.join(60)
    assert bytes(heard) == sent
    line.close()


def test_a_far_end_that_is_gone_ends_the_line() -> None:
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        port = nobody.getsockname()[1]
    line = tls_line("127.0.0.1", port, ssl._create_unverified_context())
    line.settimeout(60)
    assert line.recv(1) == b""
    line.close()
