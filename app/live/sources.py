"""Give the bytes of a device as they come: standard input, datagrams, a serial port, a process."""

from __future__ import annotations

import os
import select
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

__all__ = ["Port", "SourceError", "from_descriptor", "from_serial", "from_udp"]

PIECE_BYTES = 65_536  # read at once, at most
TORN = b"\xff"  # no ASCII: between what came before a cable was pulled and what came after, so that no line is made of both
Read = Callable[[float], "bytes | None"]  # waits so many seconds; b"" where nothing came, None at the end


@dataclass(frozen=True)
class Port:
    """A source of bytes: called, it reads as `Read` says; `send` takes bytes to the device, and is None where nothing can be sent.

    Bytes that the device does not take at once are left out: the next input is newer.
    """

    read: Read
    send: Callable[[bytes], object] | None = None

    def __call__(self, seconds: float) -> bytes | None:
        return self.read(seconds)


class SourceError(OSError):
    """A source that cannot be opened; the message is one sentence."""


@contextmanager
def from_descriptor(descriptor: int, *, answers: bool = False) -> Iterator[Port]:
    """Bytes of an open file, pipe or pseudo-terminal; one that `answers` takes bytes too."""
    def read(seconds: float) -> bytes | None:
        ready, _, _ = select.select([descriptor], [], [], seconds)
        if not ready:
            return b""
        try:
            return os.read(descriptor, PIECE_BYTES) or None
        except OSError:  # the other end of a pseudo-terminal is gone
            return None

    def send(data: bytes) -> None:
        if select.select([], [descriptor], [], 0.0)[1]:
            with suppress(OSError):
                os.write(descriptor, data)
    yield Port(read, send if answers else None)


@contextmanager
def from_udp(port: int, host: str = "127.0.0.1") -> Iterator[Port]:
    """Datagrams to a port, each with whole lines; what is sent goes to whom the last one came from. Raises SourceError."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as door:
        try:
            door.bind((host, port))
        except OSError as problem:
            raise SourceError(f"Port {port} cannot be opened ({problem.strerror}); choose another.") from problem

        sender: tuple[str, int] | None = None

        def read(seconds: float) -> bytes | None:
            nonlocal sender
            door.settimeout(seconds)
            try:
                data, sender = door.recvfrom(PIECE_BYTES)
            except TimeoutError:
                return b""
            return data if data.endswith(b"\n") else data + b"\n"

        def send(data: bytes) -> None:
            if sender is not None:
                with suppress(OSError):
                    door.sendto(data, sender)
        yield Port(read, send)


@contextmanager
def from_serial(port: str, baud: int) -> Iterator[Port]:
    """Bytes of a serial port; it is opened again when the cable comes back, and the line that was cut is refused. Raises SourceError."""
    try:
        import serial
    except ImportError as problem:
        raise SourceError('A serial port needs the package pyserial; run pip install "observer-lab[live]".') from problem
    try:
        line = serial.Serial(port, baud, timeout=0, write_timeout=0)
    except (serial.SerialException, ValueError) as problem:
        raise SourceError(f"{port[:60]} cannot be opened as a serial port; check its name, its rights and the cable.") from problem

    torn = False

    def read(seconds: float) -> bytes | None:
        nonlocal torn
        try:
            if not line.is_open:
                line.open()
            line.timeout = seconds
            found = line.read(1) + line.read(line.in_waiting)
            if torn and found:
                torn, found = False, TORN + found
            return found
        except (serial.SerialException, OSError):
            line.close()
            torn = True
            time.sleep(seconds)
            return b""

    def send(data: bytes) -> None:
        with suppress(serial.SerialException, OSError):
            line.write(data)
    try:
        yield Port(read, send)
    finally:
        line.close()
