"""Derive the keys of a course from its secret, each student's seeds and the signatures of hand-ins."""

from __future__ import annotations

import base64
import hmac
import unicodedata
from dataclasses import dataclass, field

WORD_BYTES, WORD_HALF = 5, 4  # of a student's word: 40 bits, which only a server can be asked about; two halves of four characters
MISREAD = str.maketrans("018", "olb")  # base32 has none of these digits
SALT = b"observer-lab course keys 1"  # ties what is derived to this use; another scheme takes another salt
PURPOSES = ("numbers", "hand-ins", "students", "words")


def derive_key(secret: bytes, salt: bytes, info: bytes) -> bytes:
    """A key of 32 bytes for one purpose.

    HKDF with SHA-256 and one block of output:

        PRK = HMAC(salt, secret),  key = HMAC(PRK, info ‖ 0x01).

    Keys for two different `info` tell nothing of each other nor of the secret, as long as HMAC is a pseudorandom function.
    Source: RFC 5869, sections 2.2 and 2.3.
    """
    return hmac.digest(hmac.digest(salt, secret, "sha256"), info + b"\x01", "sha256")


@dataclass(frozen=True)
class CourseKeys:
    """The keys of a course: for numbers, hand-ins, the names of students and their words. They stand in no text of it."""

    _numbers: bytes = field(repr=False)
    _signing: bytes = field(repr=False)
    _students: bytes = field(repr=False)
    _words: bytes = field(repr=False)

    @classmethod
    def of(cls, course: str, secret: str) -> CourseKeys:
        """The keys of the course with this id. Courses with the same secret have independent keys."""
        return cls(*(derive_key(secret.encode(), SALT, f"{purpose}\n{course}".encode()) for purpose in PURPOSES))

    def seed(self, student: str, item: str, variant: int) -> str:
        """The seed of an item for a student: HMAC over student, item and variant, in hexadecimal digits.

        `student` is a key as `canonical_key` gives it; neither it nor the name of an item holds a line break.
        """
        return hmac.digest(self._numbers, f"{student}\n{item}\n{variant}".encode("utf-8", "surrogatepass"), "sha256").hex()

    def student(self, platform: str, user: str) -> str:
        """The key of a person whom a learning platform knows under a number: HMAC of both, 24 hexadecimal digits that name nobody."""
        return hmac.digest(self._students, f"{platform}\n{user}".encode("utf-8", "surrogatepass"), "sha256").hex()[:24]

    def word(self, student: str) -> str:
        """The word that a student's key needs, as `canonical_key` gives it: 40 bits of an HMAC in base32."""
        drawn = hmac.digest(self._words, student.encode("utf-8", "surrogatepass"), "sha256")[:WORD_BYTES]
        word = base64.b32encode(drawn).decode().lower()
        return f"{word[:WORD_HALF]}-{word[WORD_HALF:]}"

    def knows(self, student: str, word: str) -> bool:
        """Whether that is the student's word; capitals, blanks and dashes do not count, nor digits misread for letters."""
        typed = "".join(sign for sign in unicodedata.normalize("NFKC", word).lower() if sign.isalnum()).translate(MISREAD)
        mine = self.word(student).replace("-", "")
        return hmac.compare_digest(mine.encode(), typed.encode("utf-8", "surrogatepass"))

    def sign(self, message: str) -> str:
        """The signature of a message: HMAC-SHA-256 in base64 for addresses, without padding."""
        return base64.urlsafe_b64encode(hmac.digest(self._signing, message.encode(), "sha256")).decode().rstrip("=")

    def signed(self, message: str, signature: str) -> bool:
        """Whether the signature of a message is ours; compared in constant time, as text, so that each has one spelling."""
        return hmac.compare_digest(self.sign(message).encode(), signature.encode("utf-8", "surrogatepass"))
