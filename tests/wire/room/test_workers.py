"""A room outlives its server and is one on several workers, in a folder and in Redis."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial

from client import WireTab
from lecture import PREDICT, ask, card, counts, number_of_the_vote, opened, part, say

from observer_lab.classroom.kept_room import KeptPages, Place, open_pages, open_room
from observer_lab.classroom.room import seeds_of
from observer_lab.course.scenes import entry_values
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.guide import SetMode


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
                first.until(lambda: any("Another page of yours" in note for note in first.notes), "that another leads")
                with WireTab(one.url) as back:
                    back.until(lambda: 'data-scene="predict"' in card(back), "the scene of the tab that leads now")
    finally:
        one.stop()
        other.stop()


def standing(pages: KeptPages) -> int:
    """The series of the page that a new tab gets."""
    found = pages.standing("en-wide")
    return -1 if found is None else found.series


def test_presenters_pages_at_two_workers_follow_each_other_and_one_leads_on_when_the_other_is_gone(place: Place) -> None:
    one, other, secret = opened(place, 0), opened(place, 1), open_room(place).secret
    pages, knob, here = open_pages(place), "stiffness error in the model [%]", [scene.id for scene in LESSONS["separation"].path]

    def stand(index: int, *pages: WireTab) -> None:
        for page in pages:
            page.until(lambda page=page: f'data-scene="{here[index]}"' in card(page), f"scene {here[index]} on every page")
    try:
        with WireTab(one.url, word=secret) as tablet:
            tablet.settle()
            with WireTab(other.url, word=secret) as projector, ExitStack() as followers:
                projector.settle()
                tablet.until(lambda: tablet.notes, "that another page presents")
                near, far = (followers.enter_context(WireTab(server.url)) for server in (one, other))
                for acts, index in ((tablet, 2), (projector, 1), (tablet, PREDICT)):
                    ask(acts, f"scene:{index}")
                    stand(index, tablet, projector, near, far)
                ask(tablet, "option:1")
                projector.until(lambda: "ol-chosen" in card(projector), "the answer on the page at the other worker")
                projector.settle()
                ask(projector, "mode:lab")
                for page in (tablet, projector):
                    page.until(lambda page=page: page.has(knob) and page.mark(), "the lab on both pages")
                    page.settle()
                shown = len(projector.messages)
                for value in range(1, 13):
                    tablet.update(knob, value=float(value))
                projector.until(lambda: projector.value(knob) == 12.0, "the last of many moves of a knob")
                far.until(lambda: "<dd>12 %</dd>" in part(far, '<dl class="ol-knobs"'), "the knob at the follower")
                assert len(projector.messages) > shown and tablet.value(knob) == 12.0, "nothing comes back to the hand"
                for session in (*one.sessions.values(), *other.sessions.values()):
                    session.post(SetMode("guide"))
                stand(PREDICT, tablet, projector)
                led = pages.series
            tablet.until(lambda: standing(pages) > led, "that the page which is left leads")
            ask(tablet, "scene:1")
            with WireTab(other.url) as late:
                stand(1, tablet, late)
    finally:
        one.stop()
        other.stop()


def test_a_page_leads_again_when_the_worker_of_the_leading_one_is_killed(place: Place) -> None:
    """Its lead runs out, as nothing says that it has left."""
    one, secret = opened(place, 0), open_room(place).secret
    pages = open_pages(place)
    try:
        with WireTab(one.url, word=secret) as tablet, WireTab(one.url) as follower:
            tablet.settle()
            follower.until(lambda: card(follower), "the card")
            pages.begin_series()  # as a page at another worker does
            pages.keep_lead(1.0)
            tablet.until(lambda: tablet.notes, "that another page presents")
            led = pages.series
            tablet.until(lambda: standing(pages) > led, "the lead, once the other one has run out")
            ask(tablet, "scene:1")
            with WireTab(one.url) as back:
                back.until(lambda: f'data-scene="{LESSONS["separation"].path[1].id}"' in card(back), "the page that leads again")
    finally:
        one.stop()


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
