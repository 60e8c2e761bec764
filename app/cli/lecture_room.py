"""Open the room of a lecture: its folder, its two links, and the code that a phone reads."""

from __future__ import annotations

import io
import socket
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from .options import CommandError, error_cause

DOCUMENTATION_ADDRESS = "192.0.2.1"  # RFC 5737: nobody has it; asking for a way there sends nothing
ROOM_TOLD = """\
Presenter's link (keep it secret): {presenter}
Audience: {audience}
{code}{note}"""
LOOPBACK_ONLY = ("This server listens on this computer alone, so no phone can open the audience's link. "
                 "For a hall add --host 0.0.0.0 --public.\n")
NO_FOLDER = "The room ends with this server; give --data-dir FOLDER to keep votes and links through a restart.\n"


@dataclass(frozen=True)
class LecturePlace:
    """Where a room is kept, and the presenter's word. `temporary` is the folder that goes with the server, if it is one."""

    place: Path | str = field(repr=False)  # an address may hold a password
    secret: str = field(repr=False)
    temporary: tempfile.TemporaryDirectory[str] | None = None


def open_room_place(data_dir: str | None, store: str | None) -> LecturePlace:
    """The place of the room, with what it needs in it: the Redis server at `store`, else a folder. Raises CommandError."""
    import sqlite3

    from ..classroom.kept_room import open_room
    from ..classroom.redis_connection import RoomProblem

    temporary = tempfile.TemporaryDirectory(prefix="observer-lab-room-") if data_dir is None and store is None else None
    path = Path(data_dir or (temporary.name if temporary else "."))
    try:
        if store is None:
            path.mkdir(parents=True, exist_ok=True)
        kept = open_room(store or path)
        kept.forget_presence()
        secret = kept.secret
        kept.close()
    except (OSError, sqlite3.Error) as problem:
        cause = error_cause(problem) if isinstance(problem, OSError) else str(problem)
        raise CommandError(f"{str(path)[:80]} cannot hold the room ({cause}); choose another folder.") from problem
    except RoomProblem as problem:
        raise CommandError(str(problem)) from problem
    return LecturePlace(store or path, secret, temporary)


def audience_address(host: str, port: int, at: str | None) -> str:
    """The address that the audience types: as given, else the machine's own on the network that it listens on."""
    if at is not None:
        return at.rstrip("/") + "/"
    from ..page.access.addresses import EVERYWHERE, url

    return url(own_address(host) if host in EVERYWHERE else host, port) + "/"


def own_address(host: str) -> str:
    """This machine's address on the network of its usual way out; where there is none, `host` itself."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as way:
        try:
            way.connect((DOCUMENTATION_ADDRESS, 9))
            return str(way.getsockname()[0])
        except OSError:
            return host


def names_of(at: str | None) -> tuple[str, ...]:
    """The name, and the port that is not the usual one, by which the audience's link calls the server, which then answers to it."""
    return () if at is None else (urlsplit(at).netloc.rpartition("@")[2],)


def room_told(presenter: str, audience: str, kept: bool) -> str:
    """What is printed: both links, the code of the audience's, and what stands in the way of a phone."""
    import segno

    from ..page.access.addresses import is_reachable

    drawn = io.StringIO()
    segno.make(audience, error="m", micro=False).terminal(drawn, compact=True, border=2)
    note = ("" if is_reachable(audience) else LOOPBACK_ONLY) + ("" if kept else NO_FOLDER)
    return ROOM_TOLD.format(presenter=presenter, audience=audience, code=drawn.getvalue(), note=note).rstrip()
