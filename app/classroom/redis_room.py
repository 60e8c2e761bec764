"""Keep a room's votes and counts in a Redis server, for the workers of several machines."""

from __future__ import annotations

import json
import secrets
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, replace
from typing import Any

from .redis_connection import connect, key, machine_name
from .room_store import SECRET_BYTES, SEED_BITS
from .votes import HIDDEN_BELOW, Answer, Asked, Vote, read_asked

GONE_S = 60  # s without a report after which the followers of a worker are no longer counted
SECRET, STATE, HANDS, SEED, TAKEN, PAUSED = (key(name) for name in ("secret", "state", "hands", "seed", "taken", "paused"))
VOTES, BALLOTS, WORKERS, RUNS, RUN_NUMBER, SEEN = (
    key(name) for name in ("votes", "ballots", "workers", "runs", "run-number", "seen"))
SLOWER = "\0"  # the place under which a worker counts raised hands


class RedisRoom:
    """The room on a Redis server; it does what `RoomStore` does. Votes are as safe as the server's `appendfsync` says.

    Each worker reports under its machine and its number, and is forgotten after GONE_S seconds without a report.
    """

    def __init__(self, address: str, machine: str | None = None) -> None:
        """Raises RoomProblem where the server cannot be used."""
        self._redis, self._machine = connect(address), machine or machine_name()
        self._redis.setnx(SECRET, secrets.token_urlsafe(SECRET_BYTES))
        self._redis.setnx(SEED, secrets.randbits(SEED_BITS))

    def close(self) -> None:
        """Let go of the server."""
        self._redis.close()

    def _word(self, name: str) -> str:
        return (self._redis.get(name) or b"").decode()

    def _number(self, name: str) -> int:
        return int(self._redis.get(name) or 0)

    # --- the room --------------------------------------------------------------------------------------------------
    @property
    def secret(self) -> str:
        """The word that makes a presenter."""
        return self._word(SECRET)

    @property
    def state(self) -> str:
        """The token of what the lecture showed last."""
        return self._word(STATE)

    def keep_state(self, token: str) -> None:
        """Keep what the lecture shows."""
        self._redis.set(STATE, token)

    @property
    def paused(self) -> bool:
        """Whether the pages of the class are paused."""
        return bool(self._number(PAUSED))

    def pause(self, on: bool) -> None:
        """Pause the pages of the class, or let them go on."""
        self._redis.set(PAUSED, int(on))

    # --- votes -----------------------------------------------------------------------------------------------------
    def open_vote(self, lesson: str, scene: str, options: int, asked: Asked | None = None) -> None:
        """Begin a vote; the one that was open ends."""
        count = options if asked is None else asked.places

        def begin(pipe: Any) -> None:
            votes = _votes(pipe)
            times = max((vote.round for vote in votes if (vote.lesson, vote.scene, vote.asked) == (lesson, scene, asked)), default=0)
            fresh = Vote(len(votes) + 1, lesson, scene, times + 1, True, (0,) * count, asked)
            pipe.multi()
            _close(pipe, votes)
            pipe.hset(VOTES, fresh.number, _written(fresh))
        self._redis.transaction(begin, VOTES, BALLOTS)

    def close_vote(self) -> None:
        """Take no more votes: their counts stay, the ballots go."""
        def end(pipe: Any) -> None:
            votes = _votes(pipe)
            pipe.multi()
            _close(pipe, votes)
        self._redis.transaction(end, VOTES, BALLOTS)

    def mark_vote(self, vote: Vote) -> None:
        """Write down how a closed vote is shown."""
        def mark(pipe: Any) -> None:
            stored = next((each for each in _stored(pipe) if each.number == vote.number and not each.open), None)
            pipe.multi()
            if stored is not None:
                marked = replace(stored, counts_out=vote.counts_out, revealed=vote.revealed, talks=vote.talks)
                pipe.hset(VOTES, vote.number, _written(marked))
        self._redis.transaction(mark, VOTES)

    def cast(self, ballots: Iterable[tuple[int, str, Answer]]) -> list[bool]:
        """Write ballots down, all in one transaction; for each whether it counts."""
        given = list(ballots)

        def write(pipe: Any) -> list[bool]:
            open_now = {vote.number: vote for vote in _stored(pipe) if vote.open}
            answers = [open_now[number].kept(answer) if number in open_now else None for number, _, answer in given]
            kept = {ballot: repr(float(answer)) for (_, ballot, _), answer in zip(given, answers, strict=True) if answer is not None}
            pipe.multi()
            if kept:
                pipe.hset(BALLOTS, mapping=kept)
            return [answer is not None for answer in answers]
        return list(self._redis.transaction(write, VOTES, value_from_callable=True))

    def votes(self) -> tuple[Vote, ...]:
        """All votes, the open one with its counts as they are now."""
        return tuple(_votes(self._redis))

    # --- who is here -----------------------------------------------------------------------------------------------
    def report(self, worker: int, people: Mapping[str, int], slower: int) -> None:
        """What a worker counts by place; `slower` are the hands that are raised there."""
        with self._redis.pipeline() as pipe:
            pipe.sadd(WORKERS, self._worker(worker))
            pipe.delete(_people(self._worker(worker)))
            pipe.hset(_people(self._worker(worker)), mapping={**people, SLOWER: slower})
            for name in (_people, _seats):
                pipe.expire(name(self._worker(worker)), GONE_S)
            pipe.execute()
        seen = self.seen()
        grown = {place: count for place, count in self.presence()[0].items() if count >= max(HIDDEN_BELOW, seen.get(place, 0) + 1)}
        if grown:
            self._redis.hset(SEEN, mapping=grown)

    def seen(self) -> dict[str, int]:
        """The most people that were at each place at once; a place where fewer than five were is not kept."""
        return {place.decode(): int(count) for place, count in sorted(self._redis.hgetall(SEEN).items())}

    def presence(self) -> tuple[dict[str, int], int]:
        """The counts of all workers by place, and the raised hands."""
        total: Counter[str] = Counter()
        for counts in self._each(_people, "hgetall"):
            total.update({place.decode(): int(count) for place, count in counts.items()})
        slower = total.pop(SLOWER, 0)
        return dict(total), slower

    def forget_presence(self) -> None:
        """Nobody is here yet: the server of this machine has just begun."""
        for name in self._redis.smembers(WORKERS):
            if name.decode().startswith(f"{self._machine}:"):
                self._redis.delete(_people(name.decode()), _seats(name.decode()))
                self._redis.srem(WORKERS, name)
        self.keep_runs("")

    @property
    def hands(self) -> int:
        """How often the presenter has lowered all hands."""
        return self._number(HANDS)

    def lower_hands(self) -> None:
        """Every raised hand is lowered."""
        with self._redis.pipeline() as pipe:
            pipe.incr(HANDS)
            for name in self._redis.smembers(WORKERS):
                pipe.hdel(_people(name.decode()), SLOWER)
            pipe.execute()

    def _worker(self, worker: int) -> str:
        return f"{self._machine}:{worker}"

    def _each(self, name: Any, question: str) -> list[Any]:
        """The answer of every worker's key."""
        with self._redis.pipeline() as pipe:
            for worker in sorted(self._redis.smembers(WORKERS)):
                getattr(pipe, question)(name(worker.decode()))
            return list(pipe.execute())

    # --- a run for each follower -----------------------------------------------------------------------------------
    @property
    def seed(self) -> int:
        """The seed of the room."""
        return self._number(SEED)

    def take_seats(self, worker: int, count: int) -> list[int]:
        """Numbers for so many followers who have come to a worker; no number is given twice."""
        last = int(self._redis.incrby(TAKEN, count))
        seats = list(range(last - count + 1, last + 1))
        with self._redis.pipeline() as pipe:
            pipe.sadd(WORKERS, self._worker(worker))
            pipe.sadd(_seats(self._worker(worker)), *seats)
            pipe.expire(_seats(self._worker(worker)), GONE_S)
            pipe.execute()
        return seats

    def leave_seats(self, seats: Iterable[int]) -> None:
        """Those followers have left."""
        gone = list(seats)
        with self._redis.pipeline() as pipe:
            for worker in self._redis.smembers(WORKERS):
                pipe.srem(_seats(worker.decode()), *gone)
            pipe.execute()

    def empty_worker(self, worker: int) -> None:
        """Nobody follows at a worker: it has just begun."""
        self._redis.delete(_seats(self._worker(worker)))

    def seats(self) -> tuple[int, ...]:
        """The numbers of all who follow, in all workers."""
        return tuple(sorted(int(seat) for found in self._each(_seats, "smembers") for seat in found))

    def keep_runs(self, words: str) -> None:
        """Keep the runs of the class; "" takes them away."""
        with self._redis.pipeline() as pipe:
            pipe.set(RUNS, words)
            pipe.incr(RUN_NUMBER)
            pipe.execute()

    @property
    def run_number(self) -> int:
        """How often the runs of the class have changed."""
        return self._number(RUN_NUMBER)

    def runs(self) -> str:
        """The runs of the class; "" where there are none."""
        return self._word(RUNS)


def _people(worker: str) -> str:
    return key("people", worker)


def _seats(worker: str) -> str:
    return key("seats", worker)


def _written(vote: Vote) -> str:
    return json.dumps(asdict(vote))


def _stored(client: Any) -> list[Vote]:
    """All votes as they were written last, in their order."""
    found = []
    for words in client.hvals(VOTES):
        said = json.loads(words)
        said |= {"counts": tuple(said["counts"]), "edges": tuple(said["edges"]), "asked": read_asked(said["asked"])}
        if "revealed" not in said:  # of a version that showed all as soon as a vote was closed
            said |= {"counts_out": not said["open"], "revealed": not said["open"]}
        found.append(Vote(**said))
    return sorted(found, key=lambda vote: vote.number)


def _votes(client: Any) -> list[Vote]:
    """All votes, the open one with its ballots counted."""
    return [vote.counting([float(answer) for answer in client.hvals(BALLOTS)]) if vote.open else vote for vote in _stored(client)]


def _close(pipe: Any, votes: list[Vote]) -> None:
    """Write down that those votes are closed, with their counts, and delete the ballots."""
    for vote in votes:
        if vote.open:
            pipe.hset(VOTES, vote.number, _written(Vote(**{**vars(vote), "open": False})))
    pipe.delete(BALLOTS)
