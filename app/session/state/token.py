"""Encode a state as one word for a link: version, dot, base64url of the packed state.

`1.` and base64url of: the record of `state` as JSON, deflated with the words of version 1 known beforehand, and four bytes
that tell a torn token from a whole one. A token of version 1 is read for ever; whoever changes how it is packed, or the
words, makes version 2 and keeps this.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
import zlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from ...course.knobs import KnobError
from ...course.lesson import Lesson
from ...text import read_outside_json, text
from .saved_state import MAX_STATE_CHARACTERS, VERSION, SavedState, check_state, short

PREFIX = "1."
LONGEST_TOKEN = 60_000  # characters of a token that are read at all
LONGEST_LINK = 2_000  # characters of a token that mail, chats and QR codes carry
CHECKSUM_BYTES = 4  # bytes of the check sum
WORDS = Path(__file__).with_name("token_words_1.txt")
TOKEN = re.compile(r"(\d{1,3})\.([A-Za-z0-9_-]+)")
DAMAGED_LINK = text("This link is torn or was changed on its way; copy it again, whole.")


def write_token(lesson: Lesson, saved: SavedState) -> str:
    """The token of a state; as long as LONGEST_LINK or longer only with a plant of one's own or much drawn by hand."""
    return packed(json.dumps(short(lesson, saved), ensure_ascii=False, separators=(",", ":")))


def read_token(token: str, lessons: Mapping[str, Lesson]) -> SavedState:
    """The state of a token, or of a link that ends in one. Raises KnobError, in one sentence."""
    try:
        data = read_outside_json(unpacked(token.rpartition("#")[2].strip()))
    except ValueError as problem:
        if isinstance(problem, KnobError):
            raise
        raise KnobError(DAMAGED_LINK) from problem
    return check_state({**data, "version": VERSION} if isinstance(data, dict) else data, lessons)


def is_token(words: str) -> bool:
    """Whether words look like a token, or a link that ends in one."""
    return TOKEN.fullmatch(words.rpartition("#")[2].strip()) is not None


def packed(written: str) -> str:
    """A text as a token."""
    plain = written.encode()
    press = zlib.compressobj(9, zlib.DEFLATED, -15, 9, zlib.Z_DEFAULT_STRATEGY, _words())
    pressed = press.compress(plain) + press.flush() + zlib.crc32(plain).to_bytes(CHECKSUM_BYTES, "big")
    return PREFIX + base64.urlsafe_b64encode(pressed).decode().rstrip("=")


def unpacked(token: str) -> str:
    """The text of a token; no more than MAX_STATE_CHARACTERS bytes of it are ever unpacked. Raises KnobError."""
    found = TOKEN.fullmatch(token) if len(token) <= LONGEST_TOKEN else None
    if found is None:
        raise KnobError(DAMAGED_LINK)
    if found[1] != str(VERSION):
        raise KnobError(text("This design has version {found}; this Observer Lab reads version {version}.",
                             found=found[1], version=VERSION))
    try:
        pressed = base64.urlsafe_b64decode(found[2] + "=" * (-len(found[2]) % 4))
        press = zlib.decompressobj(-15, _words())
        plain = press.decompress(pressed[:-CHECKSUM_BYTES], MAX_STATE_CHARACTERS)
        whole = press.eof and not press.unused_data and zlib.crc32(plain).to_bytes(CHECKSUM_BYTES, "big") == pressed[-CHECKSUM_BYTES:]
        if not whole:
            raise KnobError(DAMAGED_LINK)
        return plain.decode()
    except (zlib.error, binascii.Error, UnicodeDecodeError) as problem:
        raise KnobError(DAMAGED_LINK) from problem


@cache
def _words() -> bytes:
    """The words that both sides know."""
    return WORDS.read_bytes()
