"""A room in a real Redis server: what several machines share, what a killed server keeps, and what an address does not tell."""

from __future__ import annotations

import argparse
import sys
import threading
from pathlib import Path

import pytest
import redis
from redis_server import RedisServer, redis_serving

from observer_lab.classroom import redis_connection
from observer_lab.classroom.kept_room import VoteWriter, open_pages, open_room
from observer_lab.classroom.redis_connection import RoomProblem, connect
from observer_lab.classroom.redis_room import GONE_S, RedisRoom
from observer_lab.classroom.room import LECTURE
from observer_lab.cli.commands.serve import serve
from observer_lab.cli.lecture_room import open_room_place
from observer_lab.cli.opening import ServeRequest
from observer_lab.cli.options import ROOM_STORE, CommandError, redis_address, stated_redis


@pytest.fixture
def server(redis_server: RedisServer) -> RedisServer:
    redis_server.empty()
    return redis_server


def test_a_redis_server_that_is_killed_keeps_every_acknowledged_vote(tmp_path: Path) -> None:
    with redis_serving(tmp_path) as server:
        store = RedisRoom(server.address)
        store.open_vote("separation", "why", 3)
        vote, writer, told, half = store.votes()[-1], VoteWriter(store), list[bool](), threading.Event()

        def note(counted: bool) -> None:
            told.append(counted)
            if len(told) >= 150:
                half.set()
        writer.start()
        for k in range(300):
            writer.cast(vote.number, f"ballot{k:04d}", k % 3, note)
        assert half.wait(60)
        writer.close()
        server.kill()
        server.start()
        kept = RedisRoom(server.address).votes()[-1]
        assert kept.open and kept.total >= sum(told) >= 150


def test_votes_of_many_workers_are_counted_once_though_the_vote_is_closed_meanwhile(server: RedisServer) -> None:
    """Each worker has a connection of its own; whoever is told that a ballot counts finds it in the counts at the end."""
    store = RedisRoom(server.address)
    store.open_vote("separation", "why", 2)
    vote, counted = store.votes()[-1], list[bool]()
    lock, begun = threading.Lock(), threading.Event()

    def work(worker: int) -> None:
        mine = RedisRoom(server.address)
        for k in range(40):
            taken = mine.cast([(vote.number, f"worker{worker}x{k:04d}", k % 2)])
            with lock:
                counted.extend(taken)
            if k == 10:
                begun.set()
        mine.close()
    threads = [threading.Thread(target=work, args=(worker,)) for worker in range(4)]
    for thread in threads:
        thread.start()
    assert begun.wait(60)
    store.close_vote()
    for thread in threads:
        thread.join()
    closed = store.votes()[-1]
    assert not closed.open and closed.total == sum(counted) > 0 and len(counted) == 160
    assert not redis.Redis(port=server.port).exists("observer-lab:ballots"), "the ballots are gone"


def test_machines_count_beside_each_other_and_one_that_begins_forgets_its_own_counts_alone(server: RedisServer) -> None:
    one, other = RedisRoom(server.address, "one"), RedisRoom(server.address, "other")
    one.report(0, {LECTURE: 3}, 1)
    other.report(0, {LECTURE: 4}, 0)
    seats = one.take_seats(0, 2), other.take_seats(0, 2)
    assert one.presence() == ({LECTURE: 7}, 1) and one.seats() == (1, 2, 3, 4)
    one.forget_presence()
    assert other.presence() == ({LECTURE: 4}, 0) and other.seats() == tuple(seats[1])


def test_a_machine_that_is_gone_is_no_longer_counted(server: RedisServer) -> None:
    store = RedisRoom(server.address, "one")
    store.report(0, {LECTURE: 3}, 0)
    store.take_seats(0, 1)
    client = redis.Redis(port=server.port)
    kept = {bytes(name).decode(): client.ttl(name) for name in client.keys("observer-lab:*:one:0")}
    assert set(kept) == {"observer-lab:people:one:0", "observer-lab:seats:one:0"}
    assert all(0 < seconds <= GONE_S for seconds in kept.values())
    client.delete(*kept)  # as it does after that time
    assert store.presence() == ({}, 0) and store.seats() == ()


def test_what_a_room_keeps_in_redis_tells_nothing_of_a_person(server: RedisServer) -> None:
    store, pages = open_room(server.address), open_pages(server.address)
    store.report(0, {LECTURE: 1}, 0)
    store.take_seats(0, 1)
    store.open_vote("separation", "why", 2)
    store.cast([(1, "ballot0001", 1)])
    store.close_vote()
    store.keep_state("1.abc")
    store.keep_runs("[]")
    pages.want("en-wide")
    pages.append("en-wide", pages.begin_series(), 1, b"batch")
    pages.stand("en-wide", 1, 1, b"whole")
    names = {bytes(name).decode().split(":")[1] for name in redis.Redis(port=server.port).keys("*")}
    assert names == {"secret", "seed", "taken", "state", "votes", "workers", "people", "seats", "runs", "run-number", "series", "wanted",
                     "page", "batches"}


def test_an_address_with_a_password_is_in_no_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(redis_connection, "RETRIES", 1)  # each attempt fails
    word = "a-word-that-nobody-sees"
    with redis_serving(tmp_path, "--requirepass", word) as server:
        good = server.address.replace("//", f"//:{word}@")
        place = open_room_place(None, good)
        assert place.secret and word not in repr(place) and place.secret not in repr(place)
        for bad in (server.address, good.replace(word, word + "s"), good.replace(f":{server.port}", ":1")):
            with pytest.raises(CommandError) as refused:
                open_room_place(None, bad)
            assert word not in str(refused.value) and "Redis server" in str(refused.value)
    with pytest.raises(RoomProblem):
        connect(good)


@pytest.mark.parametrize("words", ["http://127.0.0.1/", "redis://", "redis://host/0?db=1", "redis://a b/0", "unix:///redis", ""])
def test_what_is_no_address_of_a_redis_server_is_refused(words: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError) as refused:
        redis_address(words)
    assert words in ("", "redis://") or words not in str(refused.value)


def test_the_address_comes_from_the_command_line_or_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(ROOM_STORE, raising=False)
    assert stated_redis(None, ROOM_STORE) is None
    monkeypatch.setenv(ROOM_STORE, "redis://:word@there/1")
    assert stated_redis(None, ROOM_STORE) == "redis://:word@there/1"
    given = ServeRequest(room=True, store="redis://:word@here/2")
    assert stated_redis(given.store, ROOM_STORE) == "redis://:word@here/2" and "word" not in repr(given)
    monkeypatch.setenv(ROOM_STORE, "a-word-that-nobody-sees")
    with pytest.raises(CommandError) as refused:
        stated_redis(None, ROOM_STORE)
    assert "nobody" not in str(refused.value)
    with pytest.raises(CommandError, match="--room"):
        serve(ServeRequest(port=0, store="redis://127.0.0.1:1/0"))


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "redis", None)
    with pytest.raises(CommandError, match=r"observer-lab\[redis\]"):
        open_room_place(None, "redis://127.0.0.1:1/0")
