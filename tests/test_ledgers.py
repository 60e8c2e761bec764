"""Logins and hand-ins are kept once by all workers and machines, in a folder and in a Redis server."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import pytest
from course_makers import course_of
from redis_server import RedisServer, redis_serving

from observer_lab.cli.commands.serve import serve
from observer_lab.cli.courses import open_ledger
from observer_lab.cli.opening import ServeRequest
from observer_lab.cli.options import COURSE_STORE, CommandError
from observer_lab.course.handin.ledger import KeptHandIns, Ledger
from observer_lab.course.handin.served_course import ServedCourse
from observer_lab.page.lti.redis_ledger import RedisLedger

MACHINES, ASKED = 4, 40


@pytest.fixture(params=["folder", "redis"])
def opened(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[[], KeptHandIns]:
    """Opens what is kept, as each worker does."""
    if request.param == "folder":
        return lambda: Ledger(tmp_path)
    server: RedisServer = request.getfixturevalue("redis_server")
    server.empty()
    return lambda: RedisLedger(server.address)


def at_once(ask: Callable[[KeptHandIns, int], object], opened: Callable[[], KeptHandIns]) -> list[object]:
    """The answers to ASKED questions, put to MACHINES at the same time."""
    machines, gate = [opened() for _ in range(MACHINES)], threading.Barrier(ASKED)

    def put(k: int) -> object:
        gate.wait(30)
        return ask(machines[k % MACHINES], k)
    with ThreadPoolExecutor(ASKED) as threads:
        return list(threads.map(put, range(ASKED)))


def test_a_login_is_used_once_whichever_machine_is_asked(opened: Callable[[], KeptHandIns]) -> None:
    assert sorted(at_once(lambda kept, k: kept.use_nonce("the login"), opened)) == [False] * (ASKED - 1) + [True]
    assert opened().use_nonce("another login")


def test_no_machine_signs_more_than_counts(opened: Callable[[], KeptHandIns]) -> None:
    """Two tries, and forty answers at once: two tokens are kept, and everybody else gets none."""
    tokens = at_once(lambda kept, k: kept.choose("s1", lambda held: f"token {k}" if len(held) < 2 else None), opened)
    assert len([token for token in tokens if token is not None]) == 2
    assert opened().choose("s1", lambda held: ",".join(sorted(held))) == ",".join(sorted(filter(None, map(str, filter(None, tokens)))))
    assert opened().choose("s2", lambda held: held[0] if held else None) is None


def test_lists_of_hand_ins_grow_in_the_order_of_their_times(opened: Callable[[], KeptHandIns]) -> None:
    told = at_once(lambda kept, k: kept.add("s1", f"token {k}", 1000.0), opened)
    lists = [tokens for tokens, _ in sorted(told, key=lambda one: one[1])]  # type: ignore[misc,index]
    assert len({ms for _, ms in told}) == ASKED  # type: ignore[misc]
    assert all(later[:len(before)] == before and len(later) == len(before) + 1 for before, later in pairwise(lists))
    assert opened().add("s1", "token 7", 1.0)[0] == lists[-1], "the same hand-in again is kept once"
    assert opened().add("s2", "other", 1.0)[0] == ["other"]


def test_a_course_is_signed_though_its_redis_server_is_gone_and_no_sentence_has_its_address(tmp_path: Path) -> None:
    with redis_serving(tmp_path) as server:
        kept = RedisLedger(server.address)
        course = ServedCourse(course_of(), lambda: 1000.0, kept)
        item = next(item for item in course.course.items.values() if not item.practice)
        first = course.hand_in(item, "s1", "1", known=True)
        server.kill()
        server.start()
        assert kept.add("s1", "later", 1.0)[0] == [first, "later"], "what was acknowledged is on the disk"
        server.kill()
        with pytest.raises(OSError) as gone:
            kept.use_nonce("a login")
        assert str(server.port) not in str(gone.value) and kept.failing
        assert course.hand_in(item, "s1", "1", known=True)
        server.start()
        assert kept.use_nonce("a login") and not kept.failing


def test_the_store_is_named_by_option_or_environment_and_refused_in_one_sentence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(CommandError, match="--course-store") as refused:
        open_ledger(str(tmp_path), "redis://:a-word@127.0.0.1:1/0")
    assert "a-word" not in str(refused.value)
    with pytest.raises(CommandError, match="--course or --lti"):
        serve(ServeRequest(port=0, course_store="redis://127.0.0.1:1/0"))
    monkeypatch.setenv(COURSE_STORE, "a-word-that-nobody-sees")
    course = tmp_path / "course.toml"
    course.write_text('course = "c"\nsecret = "a secret of a course, for tests alone"\n[[lessons]]\nlesson = "kalman"\nexams = "all"\n')
    with pytest.raises(CommandError) as refused:
        serve(ServeRequest(port=0, course=str(course)))
    assert "nobody" not in str(refused.value)
