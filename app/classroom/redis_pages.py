"""Keep the packed page that a room shows in a Redis server, for the workers of several machines."""

from __future__ import annotations

from .page_store import KEPT_ACTS, KEPT_BATCHES, StandingPage
from .redis_connection import connect, key

SERIES, WANTED, LEAD, ACTS = (key(name) for name in ("series", "wanted", "lead", "acts"))
KEPT_S = 3600  # s without a new batch after which the batches of a series go; the standing page has them all
NUMBER_BYTES = 8  # of a batch's number before its data, so that no two batches are alike


class RedisPages:
    """The pages on a Redis server; they do what `PageStore` does."""

    def __init__(self, address: str) -> None:
        """Raises RoomProblem where the server cannot be used."""
        self._redis = connect(address)

    def close(self) -> None:
        """Let go of the server."""
        self._redis.close()

    @property
    def series(self) -> int:
        """The number of the present series."""
        return int(self._redis.get(SERIES) or 0)

    def begin_series(self) -> int:
        """Begin another series and give its number."""
        return int(self._redis.incr(SERIES))

    def want(self, page: str) -> None:
        """Somebody is here who needs this kind of page."""
        self._redis.sadd(WANTED, page)

    def wanted(self) -> list[str]:
        """The kinds of pages that somebody needs."""
        return sorted(page.decode() for page in self._redis.smembers(WANTED))

    def append(self, page: str, series: int, batch: int, data: bytes) -> None:
        """Add a batch to a page; one of the same number goes."""
        name = _batches(page, series)
        with self._redis.pipeline() as pipe:
            pipe.zremrangebyscore(name, batch, batch)
            pipe.zadd(name, {batch.to_bytes(NUMBER_BYTES) + data: batch})
            pipe.expire(name, KEPT_S)
            pipe.execute()

    def stand(self, page: str, series: int, batch: int, data: bytes) -> None:
        """Keep the whole page as it is after a batch; those long before it go."""
        with self._redis.pipeline() as pipe:
            pipe.hset(_standing(page), mapping={"series": series, "batch": batch, "data": data})
            pipe.zremrangebyscore(_batches(page, series), "-inf", batch - KEPT_BATCHES)
            pipe.delete(_batches(page, series - 1))
            pipe.execute()

    def standing(self, page: str) -> StandingPage | None:
        """The whole page as it was kept last."""
        found = self._redis.hgetall(_standing(page))
        return StandingPage(int(found[b"series"]), int(found[b"batch"]), found[b"data"]) if found else None

    def after(self, page: str, series: int, batch: int) -> list[tuple[int, bytes]]:
        """The batches of a series after that one, with their numbers."""
        return [(int(score), member[NUMBER_BYTES:]) for member, score in
                self._redis.zrangebyscore(_batches(page, series), batch + 1, "+inf", withscores=True)]

    # --- the presenter's pages at several workers ------------------------------------------------------------------
    def keep_lead(self, seconds: float) -> None:
        """A page leads, and says so again within so many seconds."""
        self._redis.set(LEAD, 1, px=round(1000 * seconds))

    def end_lead(self) -> None:
        """The page that led has left."""
        self._redis.delete(LEAD)

    def is_led(self) -> bool:
        """Whether a page leads."""
        return bool(self._redis.exists(LEAD))

    def add_act(self, words: str) -> None:
        """Add a command of a presenter's hand."""
        self._redis.xadd(ACTS, {"words": words}, maxlen=KEPT_ACTS)

    def last_act(self) -> str:
        """The mark of the last command."""
        last = self._redis.xrevrange(ACTS, count=1)
        return last[0][0].decode() if last else "0-0"

    def acts_after(self, mark: str) -> list[tuple[str, str]]:
        """The commands after the one of that mark, with their marks."""
        return [(name.decode(), fields[b"words"].decode()) for name, fields in self._redis.xrange(ACTS, min=f"({mark}")]



def _batches(page: str, series: int) -> str:
    return key("batches", page, series)


def _standing(page: str) -> str:
    return key("page", page)
