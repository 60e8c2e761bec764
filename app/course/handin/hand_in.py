"""Write and verify a hand-in: a signed token with course, item, student key, answer and time."""

from __future__ import annotations

import base64
import json
import re
import unicodedata
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum

from ...text import read_outside_json
from ..exercises.exam import LONGEST_KEY
from ..exercises.typed_answers import MAX_TYPED_CHARACTERS
from .course_file import Course

PREFIX = "olh1"  # Observer Lab hand-in, version 1
MAX_TOKEN_CHARACTERS = 2000
TOKEN = re.compile(rf"{PREFIX}\.[A-Za-z0-9_-]+\.[A-Za-z0-9_-]{{43}}", re.ASCII)
STUDENT = re.compile(r"[^\W_][\w .@+-]*")  # nothing that a spreadsheet takes for a formula, nor a terminal for a command
SOLVED = "solved"  # the answer of a task


class Refusal(StrEnum):
    """Why a hand-in does not count."""

    FORGED = "forged"
    OTHER_COURSE = "another course"
    NOT_ASKED = "not asked"
    LATE = "late"
    DOUBLED = "doubled"
    OTHER_STUDENT = "another student"


class HandInError(ValueError):
    """A token that is no hand-in of this course; `kind` says what it is."""

    def __init__(self, kind: Refusal, words: str) -> None:
        super().__init__(kind, words)
        self.kind = kind

    def __str__(self) -> str:
        return str(self.args[1])


@dataclass(frozen=True)
class HandIn:
    """What a student handed in; `issued` is the time of the server's signature, in whole seconds since 1970."""

    course: str
    item: str
    student: str
    answer: str
    issued: int

    @property
    def time(self) -> datetime:
        """When it was signed."""
        return datetime.fromtimestamp(self.issued, UTC)


def written_key(student: str) -> str:
    """A student's key as a list of grades shows it; "" where it is none."""
    key = " ".join(unicodedata.normalize("NFKC", student).split())
    return key if len(key) <= LONGEST_KEY and STUDENT.fullmatch(key) else ""


def write_hand_in(course: Course, hand_in: HandIn) -> str:
    """The token of a hand-in: prefix, content and signature, in characters that survive an e-mail."""
    fields = [hand_in.course, hand_in.item, hand_in.student, hand_in.answer, hand_in.issued]
    content = base64.urlsafe_b64encode(json.dumps(fields, ensure_ascii=False, separators=(",", ":")).encode()).decode().rstrip("=")
    return f"{PREFIX}.{content}.{course.keys.sign(f'{PREFIX}.{content}')}"


def read_hand_in(course: Course, token: str) -> HandIn:
    """The hand-in of a token whose signature is this course's. Raises HandInError."""
    if len(token) > MAX_TOKEN_CHARACTERS or TOKEN.fullmatch(token) is None:
        raise HandInError(Refusal.FORGED, "it is no whole hand-in; ask for it again")
    message, _, signature = token.rpartition(".")
    hand_in = _content(message.partition(".")[2])
    if hand_in is not None and hand_in.course != course.id:
        raise HandInError(Refusal.OTHER_COURSE, f"it names course {hand_in.course[:60]!a}, not {course.id}")
    if hand_in is None or not course.keys.signed(message, signature):
        raise HandInError(Refusal.FORGED, "its signature is not that of this course")
    return hand_in


def _content(words: str) -> HandIn | None:
    """The fields of a token, which may be anything before its signature is known to hold."""
    try:
        data = read_outside_json(base64.urlsafe_b64decode(words + "=" * (-len(words) % 4)).decode())
    except ValueError:
        return None
    match data:
        case [str(course), str(item), str(student), str(answer), int(issued)] if len(answer) <= MAX_TYPED_CHARACTERS:
            return HandIn(course, item, student, answer, issued)
    return None
