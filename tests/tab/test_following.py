"""A presenter's other page follows the one that leads, except where the lead is behind what a hand has done."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from fakes import Tab

from observer_lab.classroom.room import VoteDesk
from observer_lab.course.lectures import Lecture, Stop, write_lecture
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.guide import OpenLecture, TurnedTo, TurnScene
from observer_lab.session.commands.room import LeadShown
from observer_lab.session.handlers.sharing import LEAD_S, STALE_S
from observer_lab.session.state.token import write_token
from observer_lab.session.state.view import Picture

STOPS = [("separation", "predict"), ("duality", "meet")]
TALK = write_lecture(Lecture({"en": "Short"}, tuple(Stop(lesson, scene, {}, 4.0) for lesson, scene in STOPS), 8.0))


def page() -> Tab:
    """A presenter's page, at the first stop of a lecture."""
    tab = Tab(LESSONS, desk=cast(VoteDesk, SimpleNamespace(audience="")))
    tab.do(OpenLecture(TALK.encode()))
    return tab


def shown(tab: Tab) -> str:
    """What the room's store keeps of the page."""
    return write_token(tab.picture.lesson, tab.picture.saved(tab.picture.design, None))


def where(picture: Picture) -> tuple[str, str]:
    assert picture.scene is not None
    return picture.lesson.id, picture.scene.id


def lead(tab: Tab, token: str, after: float) -> Any:
    tab.clock.advance(after)
    tab.do(LeadShown(token))
    return where(tab.picture), tab.picture.place[0]


def test_a_lead_that_lags_behind_turns_nothing_back() -> None:
    tab = page()
    before = shown(tab)
    tab.do(TurnScene(1))
    for after in (0.1, LEAD_S + 0.1, STALE_S / 2):
        assert lead(tab, before, after) == (STOPS[1], 1)


def test_a_lead_that_does_not_come_after_is_followed_in_the_end_with_its_stop() -> None:
    tab = page()
    before = shown(tab)
    tab.do(TurnScene(1))
    after = shown(tab)
    assert lead(tab, before, STALE_S + 0.1) == (STOPS[0], 0)
    assert lead(tab, after, 0.0) == (STOPS[1], 1), "no hand has been here since"


def test_a_lead_that_goes_elsewhere_is_followed_once_the_hand_rests() -> None:
    tab, other = page(), page()
    other.do(TurnScene(1))
    assert lead(tab, shown(other), LEAD_S / 2) == (STOPS[0], 0)
    assert lead(tab, shown(other), LEAD_S) == (STOPS[1], 1)


def test_a_turn_of_another_page_leads_where_that_page_stands() -> None:
    tab = page()
    for _ in range(2):  # a page that has followed the lead already stays
        tab.do(TurnedTo(1))
        assert (where(tab.picture), tab.picture.place[0]) == (STOPS[1], 1)
    tab.do(TurnedTo(0))
    assert where(tab.picture) == STOPS[0]
