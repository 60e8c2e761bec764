"""A platform whose keys do not answer: it holds up no door of another, its old keys serve on, and it is seldom asked."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from lti_platform import KID, LearningBrowser, LearningPlatform, key_set, pem, signed

from observer_lab.course.handin.ledger import Ledger
from observer_lab.lessons import LESSONS
from observer_lab.page.access.addresses import listen
from observer_lab.page.lti.doors import LtiDoors
from observer_lab.page.lti.fetching import LtiRefused
from observer_lab.page.lti.key_sets import ASK_AGAIN_S, KEPT_S, STALE_S, KeySets, KeysWantedError
from observer_lab.page.lti.keys import ToolKeys
from observer_lab.page.lti.settings import Platform, read_settings
from observer_lab.page.screen.server import LabServer

CROWD = 40  # launches at once: more than any pool of threads


@pytest.fixture
def platforms() -> Iterator[tuple[LearningPlatform, LearningPlatform]]:
    both = LearningPlatform(), LearningPlatform()
    yield both
    for each in both:
        each.close()


def test_launches_of_a_dead_platform_hold_up_no_other_door(platforms: tuple[LearningPlatform, LearningPlatform], tmp_path: Path) -> None:
    dead, alive = platforms
    dead.state.silent = threading.Event()
    listener = listen("127.0.0.1", 0)
    port = listener.getsockname()[1]
    url = f"http://127.0.0.1:{port}"
    toml = alive.toml(url) + dead.toml(url)[dead.toml(url).index("[[platforms]]"):]
    settings = read_settings(toml, lambda name: pem("lab"))
    doors = LtiDoors(settings, ToolKeys(settings.private_key), Ledger(tmp_path), LESSONS, None, port, time.time)
    server = LabServer(LESSONS, listener=listener, lesson="separation", doors=doors)

    def launch(platform: LearningPlatform) -> int:
        return platform.launch(LearningBrowser(url), "kalman").status
    try:
        with ThreadPoolExecutor(CROWD) as crowd:
            refused = [crowd.submit(launch, dead) for _ in range(CROWD)]
            while not dead.state.key_sets_given:
                time.sleep(0.01)
            assert LearningBrowser(url).ask("/lti/jwks").status == 200
            assert launch(alive) == 303
            assert alive.begin(LearningBrowser(url))["nonce"]
            assert not dead.state.silent.is_set() and not any(each.done() for each in refused)
            assert {each.result(60) for each in refused} == {502}
        assert launch(dead) == 502 and dead.state.key_sets_given == 1, "the failure is remembered"
        dead.state.silent.set()
    finally:
        server.stop()


class Clock:
    """Seconds that a test sets."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


class Source:
    """A key set that comes or does not."""

    def __init__(self) -> None:
        self.comes, self.asked = True, 0

    def __call__(self, url: str) -> dict[str, object]:
        self.asked += 1
        if not self.comes:
            raise LtiRefused("no answer")
        return key_set()


PLATFORM = Platform("i", "c", "https://a/", "https://b/", "https://keys/", None, frozenset({"1"}), "b")


def key(keys: KeySets, kid: str = KID) -> object:
    """What the door does."""
    try:
        return keys.key(PLATFORM, kid)
    except KeysWantedError as wanted:
        asyncio.run(keys.ask(wanted.platform))
        return keys.key(PLATFORM, kid)


def test_old_keys_serve_on_for_a_day_and_a_failure_is_remembered() -> None:
    clock, source = Clock(), Source()
    keys = KeySets(source, clock)
    first = key(keys)
    clock.now = KEPT_S - 1
    assert key(keys) is first and source.asked == 1
    source.comes, clock.now = False, KEPT_S + 1
    for _ in range(5):
        assert key(keys) is first and source.asked == 2
    clock.now += ASK_AGAIN_S + 1
    assert key(keys) is first and source.asked == 3
    clock.now = STALE_S + 1
    for _ in range(3):
        with pytest.raises(LtiRefused):
            key(keys)
    assert source.asked == 4
    source.comes, clock.now = True, clock.now + ASK_AGAIN_S + 1
    assert key(keys) is not first and source.asked == 5


def test_an_unknown_key_is_refused_while_the_known_ones_hold() -> None:
    clock, source = Clock(), Source()
    keys = KeySets(source, clock)
    key(keys)
    for _ in range(5):
        with pytest.raises(LtiRefused, match="signed by a key"):
            key(keys, "other")
    clock.now += ASK_AGAIN_S + 1
    source.comes = False
    with pytest.raises(LtiRefused, match="does not show"):
        key(keys, "other")
    assert key(keys) and source.asked == 2


def test_many_launches_wait_for_one_question_and_no_longer_than_the_bound() -> None:
    asked, go = list[str](), threading.Event()

    def fetch(url: str) -> dict[str, object]:
        asked.append(url)
        go.wait(60)
        return key_set()

    async def crowd(keys: KeySets) -> None:
        await asyncio.gather(*(keys.ask(PLATFORM) for _ in range(50)))
    keys = KeySets(fetch, wait=0.1)
    asyncio.run(crowd(keys))
    with pytest.raises(LtiRefused, match="does not show"):
        keys.key(PLATFORM, KID)
    asyncio.run(crowd(keys))
    assert asked == [PLATFORM.key_set], "what has not come back is not asked again"
    go.set()
    while keys._asking:
        time.sleep(0.01)
    assert keys.key(PLATFORM, KID) and signed({})
