"""A room outlives its server and is one on several workers, in a folder and in Redis."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from client import WireTab
from lecture import PREDICT, ask, card, counts, number_of_the_vote, opened, part, say

from observer_lab.classroom.class_runs import seeds_of
from observer_lab.classroom.kept_room import Place, open_room
from observer_lab.course.scenes import entry_values
from observer_lab.lessons import LESSONS


def test_a_restart_brings_back_lecture_and_votes(place: Place) -> None:
    server, secret = opened(place), open_room(place).secret
    with WireTab(server.url, word=secret) as presenter, WireTab(server.url) as follower:
        presenter.settle()
        ask(presenter, f"scene:{PREDICT}")
        ask(presenter, "vote:open")
        vote = number_of_the_vote(follower)
        say(follower, f"vote:{vote}:2:ballot0001")
        follower.until(lambda: follower.notes, "the acknowledgement")
        follower.until(lambda: open_room(place).state, "the kept state")
    server.stop()
    server = opened(place)
    try:
        with WireTab(server.url) as follower:
            follower.until(lambda: 'data-scene="predict"' in card(follower), "the scene of the lecture, before its presenter is back")
            assert open_room(place).votes()[-1].counts == (0, 0, 1) and open_room(place).votes()[-1].open
            with WireTab(server.url, word=secret) as presenter:
                presenter.settle()
                presenter.until(lambda: 'data-scene="predict"' in card(presenter), "the presenter's scene")
    finally:
        server.stop()


def test_another_worker_serves_the_same_page(place: Place) -> None:
    first, second = opened(place, 0), opened(place, 1)
    try:
        with WireTab(first.url, word=open_room(place).secret) as presenter, WireTab(second.url) as follower:
            presenter.settle()
            follower.until(lambda: card(follower), "the page from the other worker")
            ask(presenter, f"scene:{PREDICT}")
            follower.until(lambda: 'data-scene="predict"' in card(follower), "the presenter's scene")
            presenter.until(lambda: "1 here" in counts(presenter), "the follower of the other worker")
            assert not second.sessions
    finally:
        first.stop()
        second.stop()


def test_of_presenters_at_two_workers_the_last_one_leads_and_followers_come_back_to_it(place: Place) -> None:
    one, other = opened(place, 0), opened(place, 1)
    secret = open_room(place).secret
    try:
        with WireTab(one.url, word=secret) as first, WireTab(one.url) as follower:
            first.settle()
            follower.until(lambda: card(follower), "the card")
            with WireTab(other.url, word=secret) as second:
                second.settle()
                assert follower.closed() == 1012, "its page comes back by itself"
                ask(second, f"scene:{PREDICT}")
                first.until(lambda: any("Another tab now leads" in note for note in first.notes), "that another leads")
                with WireTab(one.url) as back:
                    back.until(lambda: 'data-scene="predict"' in card(back), "the scene of the tab that leads now")
    finally:
        one.stop()
        other.stop()


def test_each_follower_runs_one_seed_and_the_presenter_sees_the_cloud_of_all(place: Place) -> None:
    """On two workers: each follower's page shows one run of its own, and another design takes cloud and runs away."""
    one, other = opened(place, 0, "kalman"), opened(place, 1, "kalman")
    store = open_room(place)
    followers: list[WireTab] = []

    def own(tab: WireTab) -> str:
        return part(tab, '<section class="ol-own-run"')

    def cloud() -> str:
        return part(presenter, '<section class="ol-seeds"')

    def all_see(condition: Callable[[WireTab], object], what: str) -> None:
        for follower in followers:
            follower.until(partial(condition, follower), what)
    try:
        with WireTab(one.url, word=store.secret) as presenter:
            presenter.settle()
            followers += [WireTab((one, other)[k % 2].url) for k in range(5)]
            all_see(card, "the card")
            presenter.until(lambda: len(store.seats()) == 5 and "Run one seed for each follower" in cloud(), "all five numbers")
            ask(presenter, "seeds")
            presenter.until(lambda: "average NEES" in cloud(), "the covariances")
            assert "errors of 5 seeds" in cloud() and cloud().count("<circle") == 5
            all_see(lambda tab: "Your run" in own(tab), "its own run")
            assert len({own(follower) for follower in followers}) == 5, "no two have the same noise"
            seeds = {str(seed) for seed in seeds_of(store.seed, store.seats())}
            sent = "".join(str(m) for tab in (presenter, *followers) for m in tab.messages)
            assert not [seed for seed in {*seeds, str(store.seed)} if seed in sent], "nobody is told a seed"
            say(followers[0], "seeds")
            say(followers[0], "slower")
            followers[0].until(lambda: followers[0].notes, "an answer to the hand")
            assert "average NEES" in cloud() and own(followers[1]), "a follower's press runs nothing"
            path, start = LESSONS["kalman"].path, LESSONS["kalman"].start()
            begun = [entry_values(path, k, start) for k in range(len(path))]
            ask(presenter, f"scene:{next(k for k, values in enumerate(begun) if values != begun[0])}")
            all_see(lambda tab: not own(tab), "that the run of another design is gone")
            presenter.until(lambda: "average NEES" not in cloud(), "that the cloud of another design is gone")
            followers.pop().close()
            presenter.until(lambda: len(store.seats()) == 4, "that one has left")
    finally:
        for follower in followers:
            follower.close()
        one.stop()
        other.stop()
