"""Keep logins and hand-ins in a Redis server, for labs on several machines."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ...classroom.redis_connection import connect, key
from ...course.handin.ledger import NONCE_KEPT_S

OPTION = "--course-store"
REPORTS = key("course", "reports")  # the time of the last list of hand-ins that was told, in ms


class RedisLedger:
    """Keys of students and what they handed in, on a Redis server; it does what `Ledger` does."""

    def __init__(self, address: str) -> None:
        """Raises RoomProblem where the server cannot be used."""
        self._redis, self.failing = connect(address, OPTION), False  # whether the last login or hand-in could not be kept

    def use_nonce(self, nonce: str) -> bool:
        """Note that a login is used; False where it was before. Raises OSError."""
        with self._told():
            name = key("course", "nonce", hashlib.sha256(nonce.encode()).hexdigest())
            return bool(self._redis.set(name, 1, nx=True, ex=NONCE_KEPT_S))

    def choose(self, student: str, pick: Callable[[Sequence[str]], str | None]) -> str | None:
        """Keep the token that `pick` gives for those kept of a student, None for none; no other is kept meanwhile. Raises OSError."""
        name = _hand_ins(student)

        def write(pipe: Any) -> str | None:
            kept = _tokens(pipe, name)
            token = pick(kept)
            pipe.multi()
            if token is not None and token not in kept:
                pipe.rpush(name, token)
            return token
        with self._told():
            return self._redis.transaction(write, name, value_from_callable=True)

    def add(self, student: str, token: str, now: float) -> tuple[list[str], int]:
        """Keep a hand-in of a student's key; all that are kept of it in the order in which they came, and the time of that list (ms).

        No two lists have the same time, and a later one holds all that an earlier one does, whichever machine asked. Raises OSError.
        """
        name = _hand_ins(student)

        def write(pipe: Any) -> tuple[list[str], int]:
            kept, ms = _tokens(pipe, name), max(int(pipe.get(REPORTS) or 0) + 1, int(now * 1000))
            pipe.multi()
            if token not in kept:
                pipe.rpush(name, token)
                kept.append(token)
            pipe.set(REPORTS, ms)
            return kept, ms
        with self._told():
            return self._redis.transaction(write, name, REPORTS, value_from_callable=True)

    @contextmanager
    def _told(self) -> Iterator[None]:
        """What goes wrong in the server is an OSError, without the address, which may hold a password."""
        import redis

        try:
            yield
            self.failing = False
        except redis.RedisError as problem:
            self.failing = True
            raise OSError(f"the Redis server of {OPTION} does not answer ({type(problem).__name__})") from None


def _hand_ins(student: str) -> str:
    return key("course", "hand-ins", student)


def _tokens(client: Any, name: str) -> list[str]:
    return [token.decode() for token in client.lrange(name, 0, -1)]
