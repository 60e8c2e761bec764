"""What no browser of ours would send: nothing changes, one sentence comes, the server and the other tabs live on."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
import viser
from client import WireTab
from websockets.exceptions import ConnectionClosed

from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer
from observer_lab.session.session import Session

STIFFNESS, METHOD, LIMITED = "stiffness error in the model [%]", "gains by", "limit the coils"
Enter = Callable[..., WireTab]
Newest = Callable[[], Session]
START = LESSONS["separation"].start()


def still_works(tab: WireTab, session: Session) -> None:
    """The tab obeys its own widgets as before."""
    tab.update(STIFFNESS, value=7.0)
    tab.until(lambda: session.picture.design["stiffness_error"] == 7.0, "a good value")  # type: ignore[union-attr]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf"), 1e9, -30.0001])
def test_a_slider_beyond_its_bounds_gets_a_sentence_and_is_put_back(enter: Enter, newest: Newest, value: float) -> None:
    tab = enter()
    tab.update(STIFFNESS, value=value)
    tab.until(lambda: any("stiffness" in note for note in tab.notes), "the sentence")
    tab.until(lambda: tab.value(STIFFNESS) == 0.0, "the accepted value")
    assert newest().picture.design == START  # type: ignore[union-attr]
    still_works(tab, newest())


def test_a_word_that_is_no_option_gets_a_sentence(enter: Enter, newest: Newest) -> None:
    tab = enter()
    tab.update(METHOD, value="by magic")
    tab.until(lambda: any("by magic" in note for note in tab.notes), "the sentence")
    assert newest().picture.design == START  # type: ignore[union-attr]
    still_works(tab, newest())


def test_a_pole_far_outside_gets_a_sentence(enter: Enter, newest: Newest) -> None:
    tab = enter()
    for row in ((1e9, 0.0), (float("nan"), 1.0)):
        before = len(tab.notes)
        tab.update("q1", value=row)
        tab.until(lambda n=before: len(tab.notes) > n, "the sentence")
    assert newest().picture.design == START  # type: ignore[union-attr]
    still_works(tab, newest())


@pytest.mark.parametrize("label, updates", [
    (STIFFNESS, {"value": "a lot"}), (STIFFNESS, {"value": None}), (STIFFNESS, {"value": [1, 2]}), (STIFFNESS, {"value": {}}),
    (LIMITED, {"value": None}), ("q1", {"value": [1.0, 2.0, 3.0]}), ("q1", {"value": "xy"}), (METHOD, {"value": None}),
    (STIFFNESS, {"visible": False}), (STIFFNESS, {"min": -1e9}), (STIFFNESS, {"max": 1e9}), (STIFFNESS, {"step": 0}),
    (STIFFNESS, {"update_cb": []}), (STIFFNESS, {"removed": True}), (STIFFNESS, {"__class__": 1}), (STIFFNESS, {"props": 3}),
    (STIFFNESS, {}), (STIFFNESS, {"": 1}),
], ids=lambda v: str(v)[:30])
def test_what_viser_itself_refuses_changes_nothing_for_anybody(enter: Enter, server: LabServer, label: str,
                                                               updates: dict[str, Any]) -> None:
    """The design stays, the server stays, and another tab works as if nothing had been."""
    tab = enter()
    mine = server.sessions[max(server.sessions)]
    other = enter()
    theirs = server.sessions[max(server.sessions)]
    tab.send("GuiUpdateMessage", uuid=tab.find(label), updates=updates)
    tab.answered()
    assert mine.picture.design == START  # type: ignore[union-attr]
    assert not other.notes and other.value(STIFFNESS) == 0.0
    still_works(other, theirs)
    assert mine.picture.design == START  # type: ignore[union-attr]


@pytest.mark.parametrize("updates", [{"visible": False}, {"min": -1e9}, {"value": "a lot"}, {"removed": True}, {"props": 3}],
                         ids=str)
def test_a_tab_survives_its_own_nonsense(enter: Enter, newest: Newest, updates: dict[str, Any]) -> None:
    tab = enter()
    tab.send("GuiUpdateMessage", uuid=tab.find(STIFFNESS), updates=updates)
    tab.answered()
    tab.update("input delay [ms]", value=6.0)
    tab.until(lambda: newest().picture.design["delay"] == 6.0, "a good value")  # type: ignore[union-attr]


def test_nobody_can_reach_a_widget_of_another_tab(enter: Enter, server: LabServer) -> None:
    a = enter()
    b = enter()
    theirs = server.sessions[max(server.sessions)]
    a.send("GuiUpdateMessage", uuid=b.find(STIFFNESS), updates={"value": 20.0})
    a.send("CommandTriggerMessage", uuid=b.commands["Chinese / English"])
    a.answered()
    assert b.unasked() == []
    assert theirs.picture.design == START and theirs.picture.state.language == "en"  # type: ignore[union-attr]


def test_a_request_to_share_opens_no_tunnel(enter: Enter, server: LabServer, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    for name in ("request_share_url", "disconnect_share_url"):
        monkeypatch.setattr(viser.ViserServer, name, lambda *args, n=name, **options: asked.append(n))
    tab = enter()
    tab.send("ShareUrlRequest")
    tab.send("ShareUrlDisconnect")
    tab.answered()
    assert not asked
    assert "ShareUrlUpdated" not in {m["type"] for m in tab.messages if m.get("share_url")}


def test_our_own_page_is_welcome(enter: Enter, server: LabServer) -> None:
    assert enter(origin=server.url).has(STIFFNESS)


def test_a_page_of_another_version_is_refused(server: LabServer) -> None:
    tab = WireTab(server.url, protocol="viser-v0.0.1", camera=False)
    try:
        assert tab.closed() == 1002
    finally:
        tab.close()


GARBAGE = [
    b"", b"\x00", b"\xc1" * 40, b"\xff\xfe garbage", msgspec.msgpack.encode([1, 2, 3]), msgspec.msgpack.encode({}),
    msgspec.msgpack.encode({"type": "NoSuchMessage"}), msgspec.msgpack.encode({"type": "GuiUpdateMessage"}),
    msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": 3, "updates": [1]}),
    msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": "nobody", "updates": {"value": 1}}),
    msgspec.msgpack.encode({"type": "SceneNodeDragMessage", "name": "/board/observer/grips"}),
    msgspec.msgpack.encode({"type": "ViewerCameraMessage", "position": "here"}), "text instead of bytes",
]


@pytest.mark.parametrize("data", GARBAGE, ids=lambda d: str(d)[:30])
@pytest.mark.filterwarnings("ignore:.*does not match annotation:UserWarning")  # said by viser of what is sent here
def test_garbage_costs_at_most_the_tab_that_sent_it(enter: Enter, server: LabServer, data: bytes | str) -> None:
    good = enter()
    session = server.sessions[max(server.sessions)]
    bad = WireTab(server.url)
    bad.send_raw(data)
    with contextlib.suppress(ConnectionClosed):
        bad.answered()
    bad.close()
    still_works(good, session)
    good.until(lambda: len(server.sessions) == 1, "the end of the other session")


def test_a_camera_of_nonsense_does_not_hurt_dragging(enter: Enter, newest: Newest) -> None:
    """s_at divides by what the camera gives: NaN must not become a pole."""
    tab = enter()
    tab.press("skip")  # the poles can be dragged from now on
    tab.settle()
    nan = float("nan")
    tab.send("ViewerCameraMessage", wxyz=(nan, 0.0, 0.0, 0.0), position=(nan, nan, nan), fov=nan, near=0.0, far=0.0,
             image_height=0, image_width=0, look_at=(nan, nan, nan), up_direction=(0.0, 0.0, 0.0))
    for phase in ("start", "update", "end"):
        tab.send("SceneNodeDragMessage", phase=phase, name="/board/observer/grips", instance_index=None,
                 start_position=(0.0, 0.0, 0.0), start_screen_pos=(0.0, 0.0), end_position=(nan, 1e9, -1e9),
                 end_screen_pos=(0.0, 0.0), button="left", modifier=None,
                 owner=tab.nodes["/board/observer/grips"].get("owner", ""))
    tab.answered()
    assert newest().picture.design["observer_poles"] == START["observer_poles"]  # type: ignore[union-attr]
    still_works(tab, newest())


def test_a_dragged_cross_moves_its_pole_and_its_twin(enter: Enter, newest: Newest) -> None:
    tab = enter()
    tab.press("skip")  # the poles can be dragged from now on
    tab.settle()
    for phase, dx in (("start", 0.0), ("update", 0.2), ("update", 0.4), ("end", 0.5)):
        tab.drag("/board/observer/grips", phase, dx)
        tab.answered()
    tab.until(lambda: newest().picture.design["observer_poles"] != START["observer_poles"], "a moved pole")  # type: ignore[union-attr]
    poles = newest().picture.design["observer_poles"]  # type: ignore[union-attr]
    assert sorted(p.conjugate().imag for p in poles) == pytest.approx(sorted(p.imag for p in poles))
    assert newest().picture.design["controller_poles"] == START["controller_poles"]  # type: ignore[union-attr]
