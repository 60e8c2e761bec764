"""A follower sees in every scene what the presenter sees: the suite samples the lessons, `--whole` walks all of them."""

from __future__ import annotations

import logging
import re
from functools import partial
from pathlib import Path

import pytest
from client import WireTab
from lecture import ask, card, opened
from shown_page import ShownPage, differences

from observer_lab.classroom.room_store import RoomStore
from observer_lab.course.lesson import Lesson
from observer_lab.course.scenes import Choose
from observer_lab.lessons import LESSONS

SAMPLED = ("hidden-modes", "nonlinear", "record")  # whose bodies change from scene to scene
WORDS = re.compile(r'<h1 class="ol-scene">.*?</h1><div class="ol-text">.*?</div>', re.S)
HANDS = ("/grips", "/locks")  # of boards: what can be dragged, and what cannot
TOLERANCE = 1e-3  # stage units
CANVAS = (929, 768)  # that of the followers' page, so that letters have the same size


def seen(tab: WireTab) -> tuple[object, object, object]:
    """The words of the scene, the curves and the nodes that are in sight."""
    assert tab.shown is not None
    return (WORDS.findall(card(tab)), [chart["data"] for chart in tab.shown.charts.values() if chart["visible"]],
            {name: node for name, node in tab.shown.in_sight().items() if not name.endswith(HANDS)})


def shows(tab: WireTab, scene: str) -> bool:
    """Whether a tab shows the card of a scene."""
    return f'data-scene="{scene}"' in card(tab)


def await_equal(presenter: WireTab, follower: WireTab, scene: str) -> None:
    """Receive on both until the follower sees what the presenter sees: a run may still play for the presenter, too."""
    left = ["everything"]

    def equal() -> bool:
        presenter.pass_time(0.02)
        left[:] = differences(seen(presenter), seen(follower), TOLERANCE)
        return not left
    try:
        follower.until(equal)
    except AssertionError as problem:
        raise AssertionError(f"in {scene} the follower's page differs: {left[:5]}") from problem


@pytest.mark.parametrize("lesson", [pytest.param(lesson, id=id, marks=() if id in SAMPLED else pytest.mark.whole)
                                    for id, lesson in LESSONS.items() if lesson.path])
def test_followers_stage_card_and_curves_equal_the_presenters(lesson: Lesson, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    server = opened(tmp_path, lesson=lesson.id)
    presenter = WireTab(server.url, word=RoomStore(tmp_path).secret, canvas=CANVAS)
    presenter.shown = ShownPage()
    follower = WireTab(server.url)
    follower.shown = ShownPage()
    try:
        with caplog.at_level(logging.WARNING):
            for scene in lesson.path:
                presenter.until(partial(shows, presenter, scene.id), scene.id)
                if scene is lesson.path[0]:
                    for _ in range(2):  # a run of half a minute is over in eight seconds
                        presenter.command("Faster")
                if isinstance(scene.do, Choose):
                    ask(presenter, "option:0")
                presenter.settle()
                await_equal(presenter, follower, scene.id)
                ask(presenter, "turn:1")
        assert not caplog.records
    finally:
        presenter.close()
        follower.close()
        server.stop()
