"""A real Redis server on a free port of loopback, for as long as a test needs one."""

from __future__ import annotations

import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import redis

START_S = 30.0  # s until it must answer
PROGRAM = "redis-server"
MISSING = "redis-server is not installed here and .ci/test could not install it, so nothing is tested against Redis."


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class RedisServer:
    """The server of a folder. What it has acknowledged is on the disk."""

    def __init__(self, folder: Path, *options: str) -> None:
        self.folder, self.port, self._options = folder, free_port(), options
        self.address = f"redis://127.0.0.1:{self.port}/0"
        self.start()

    def start(self) -> None:
        """Begin, and wait until it answers."""
        program = shutil.which(PROGRAM)
        assert program is not None
        self._process = subprocess.Popen(
            [program, "--port", str(self.port), "--bind", "127.0.0.1", "--dir", str(self.folder), "--save", "", "--appendonly", "yes",
             "--appendfsync", "always", *self._options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + START_S
        while True:
            try:
                with redis.Redis(port=self.port) as client:
                    client.ping()
                return
            except redis.AuthenticationError:
                return
            except redis.ConnectionError:
                assert time.monotonic() < end and self._process.poll() is None, "the Redis server did not start"
                time.sleep(0.02)

    def kill(self) -> None:
        """End it at once, as a power cut does."""
        self._process.kill()
        self._process.wait()

    def empty(self) -> None:
        """Forget everything."""
        with redis.Redis(port=self.port) as client:
            client.flushall()


@contextmanager
def redis_serving(folder: Path, *options: str) -> Iterator[RedisServer]:
    """A server while the context lasts; where the program is missing the test is skipped and says so."""
    if shutil.which(PROGRAM) is None:
        pytest.skip(MISSING)
    server = RedisServer(folder, *options)
    try:
        yield server
    finally:
        server.kill()
