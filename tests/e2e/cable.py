"""A cable between browsers and a server, which a test pulls out, cuts, or makes long."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress
from types import TracebackType
from urllib.parse import urlsplit

CHUNK = 65536


class Cable:
    """A port of the loopback that leads to a server; its thread ends with the block.

    `state` is "whole"; "silent", where what is sent waits until the cable is whole again, as in a network that is gone; "lost", where it
    is lost and no connection of before ever answers; or "cut", where every connection is closed and none can be made.
    """

    def __init__(self, server: str) -> None:
        self._there = urlsplit(server)
        self.delay = 0.0  # s on the way, each way
        self._state, self._generation = "whole", 0
        self._loop = asyncio.new_event_loop()
        self._whole = asyncio.Event()
        self._whole.set()
        self._open: set[asyncio.StreamWriter] = set()
        self._thread = threading.Thread(target=self._loop.run_forever, name="cable", daemon=True)
        self._thread.start()
        self._server = asyncio.run_coroutine_threadsafe(asyncio.start_server(self._carry, "127.0.0.1", 0), self._loop).result(5.0)
        self.port = self._server.sockets[0].getsockname()[1]

    @property
    def address(self) -> str:
        """What to open instead of the server's address."""
        return f"http://127.0.0.1:{self.port}"

    def lead_to(self, server: str) -> None:
        """Lead new connections to another server, which may stand where none has stood."""
        self._there = urlsplit(server)

    def __enter__(self) -> Cable:
        return self

    def __exit__(self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None) -> None:
        self.become("cut")
        asyncio.run_coroutine_threadsafe(self._end(), self._loop).result(5.0)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5.0)

    def become(self, state: str) -> None:
        """Change the state, at once for every connection."""
        asyncio.run_coroutine_threadsafe(self._become(state), self._loop).result(5.0)

    async def _end(self) -> None:
        self._server.close()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _become(self, state: str) -> None:
        self._state = state
        if state == "whole":
            self._whole.set()
        else:
            self._whole.clear()
        if state in ("cut", "lost"):
            self._generation += 1
        if state == "cut":
            for writer in list(self._open):
                writer.transport.abort()

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        # No server may stand there; and asyncio asks this task for its error when it ends, where a cancelled one raises.
        with suppress(asyncio.CancelledError, OSError):
            await self._carry_on(reader, writer)

    async def _carry_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._state == "cut":
            writer.transport.abort()
            return
        born = self._generation if self._state != "lost" else -1
        self._open.add(writer)
        try:
            there, back = await asyncio.open_connection(self._there.hostname, self._there.port)
            self._open.add(back)
            await asyncio.wait([asyncio.ensure_future(self._pass_on(*way, born)) for way in ((reader, back), (there, writer))],
                               return_when=asyncio.FIRST_COMPLETED)
        finally:
            for each in (writer, *([back] if "back" in locals() else [])):
                self._open.discard(each)
                with suppress(Exception):
                    each.close()

    async def _pass_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, born: int) -> None:
        with suppress(OSError, asyncio.IncompleteReadError):
            while data := await reader.read(CHUNK):
                if self.delay:
                    await asyncio.sleep(self.delay)
                await self._whole.wait()
                if born != self._generation:  # of a network that has forgotten this connection
                    continue
                writer.write(data)
                await writer.drain()
