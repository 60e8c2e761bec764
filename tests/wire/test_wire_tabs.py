"""Tabs over the real protocol: a picture arrives, nobody sees another's state, silence costs nothing, leaving cleans up."""

from __future__ import annotations

import threading
from collections.abc import Callable
from urllib.request import urlopen

import pytest
from client import WireTab, empty, eventually

from observer_lab.lessons import LESSONS
from observer_lab.page.screen.screen import Screen
from observer_lab.page.screen.server import LabServer
from observer_lab.session.session import Session

STIFFNESS, DELAY = "stiffness error in the model [%]", "input delay [ms]"
Enter = Callable[..., WireTab]
Newest = Callable[[], Session]


def test_the_page_and_its_address(server: LabServer) -> None:
    assert server.url.startswith("http://127.0.0.1:") and not server.url.endswith(":0")
    with urlopen(server.url, timeout=10) as page:
        text = page.read()
        assert page.status == 200 and b"<html" in text.lower()
    assert b"<title>Observer Lab</title>" in text and b"Viser</title>" not in text
    assert b"antialias: false" in text, "what must run before the view opens stands in the page"


def test_a_tab_gets_a_complete_picture(enter: Enter, newest: Newest) -> None:
    tab = enter()
    assert {"GuiUplotMessage", "GuiSliderMessage", "GuiDropdownMessage", "GuiMarkdownMessage", "GuiHtmlMessage",
            "GuiButtonGroupMessage", "GuiCheckboxMessage", "GuiPanelMessage"} <= tab.kinds()
    assert {"/forces", "/errors", "/board/controller", "/board/observer", "/floor"} <= set(tab.nodes)
    assert sum(name.startswith("/plant/") for name in tab.nodes) > 2
    assert sum(name.startswith("/board/controller/pole") for name in tab.nodes) == 6
    assert tab.value(STIFFNESS) == 0.0
    assert len(tab.commands) >= 15
    titles = {w["props"]["label"] for w in tab.widgets.values() if w["type"] == "GuiFolderMessage"}
    assert {heading for heading, _ in LESSONS["separation"].words["en"].steps} <= titles
    picture = newest().picture
    assert picture is not None and picture.design == LESSONS["separation"].start()


def test_a_moved_slider_changes_the_design_and_the_curves(enter: Enter, newest: Newest) -> None:
    tab = enter()
    before = len(tab.messages)
    tab.update(STIFFNESS, value=12.0)
    tab.until(lambda: newest().picture.design["stiffness_error"] == 12.0, "the new design")  # type: ignore[union-attr]
    tab.settle()
    redrawn = [m for m in tab.messages[before:] if (m["type"] == "GuiUpdateMessage" and "_data" in str(m["updates"].keys()))
               or (m["type"] == "GuiUpdateMessage" and "data" in m["updates"])]
    assert redrawn
    assert not tab.notes


def test_of_fifty_quick_values_the_last_one_stays(enter: Enter, newest: Newest) -> None:
    tab = enter()
    uuid = tab.find(STIFFNESS)
    for i in range(50):
        tab.send("GuiUpdateMessage", uuid=uuid, updates={"value": i / 2})
    tab.until(lambda: newest().picture.design["stiffness_error"] == 24.5, "the last value")  # type: ignore[union-attr]
    tab.settle()
    assert newest().picture.design["stiffness_error"] == 24.5  # type: ignore[union-attr]


def test_two_tabs_do_not_see_each_other(enter: Enter, server: LabServer) -> None:
    a = enter()
    b = enter()
    first, second = (server.sessions[i] for i in sorted(server.sessions))
    a.update(STIFFNESS, value=10.0)
    a.command("Chinese / English")
    a.until(lambda: a.has("模型刚度误差 [%]"), "the Chinese page")
    assert first.picture.design["stiffness_error"] == 10.0  # type: ignore[union-attr]
    assert b.unasked() == []
    assert b.value(STIFFNESS) == 0.0
    assert second.picture.design == LESSONS["separation"].start()  # type: ignore[union-attr]
    assert second.picture.state.language == "en"  # type: ignore[union-attr]
    b.update(DELAY, value=6.0)
    b.until(lambda: second.picture.design["delay"] == 6.0, "the other design")  # type: ignore[union-attr]
    assert first.picture.design["delay"] == 0.0  # type: ignore[union-attr]


def test_a_paused_tab_gets_no_messages_and_a_playing_one_does(enter: Enter) -> None:
    tab = enter()
    assert tab.unasked() == []
    tab.press("B")
    before = len(tab.messages)
    tab.until(lambda: len(tab.messages) > before + 30, "the run's poses")
    tab.press("‖ pause")
    tab.settle()
    assert tab.unasked() == []


def test_a_prediction_frees_the_poles(enter: Enter) -> None:
    tab = enter()
    grips = {f"/board/{board}/grips" for board in ("controller", "observer")}
    assert not grips & set(tab.nodes)
    tab.press("skip")
    tab.settle()
    assert grips <= set(tab.nodes)


@pytest.mark.parametrize("choice", ["A", "B", "C", "skip"])
def test_a_prediction_is_judged_by_sign_and_colour(enter: Enter, choice: str) -> None:
    tab = enter()
    tab.press(choice)
    tab.press("reveal")
    tab.settle()
    said = " ".join(str(w["props"].get("_markdown")) for w in tab.widgets.values())
    right = "ABC"[LESSONS["separation"].answer]
    assert ('class="ol-note ol-right">✓' in said) == (choice == right)
    assert ('class="ol-note ol-wrong">✗' in said) == (choice not in (right, "skip"))


def test_keys_do_what_buttons_do(enter: Enter, newest: Newest) -> None:
    tab = enter()
    tab.update(STIFFNESS, value=10.0)
    tab.until(lambda: newest().picture.design["stiffness_error"] == 10.0)  # type: ignore[union-attr]
    tab.command("Undo")
    tab.until(lambda: newest().picture.design["stiffness_error"] == 0.0, "undo")  # type: ignore[union-attr]
    tab.until(lambda: tab.value(STIFFNESS) == 0.0, "the slider's return")
    tab.command("Redo")
    tab.until(lambda: newest().picture.design["stiffness_error"] == 10.0, "redo")  # type: ignore[union-attr]


def test_the_run_is_locked_until_a_prediction(enter: Enter, newest: Newest) -> None:
    tab = enter()
    tab.command("Play or pause")
    tab.until(lambda: any("prediction first" in note for note in tab.notes), "the sentence")
    assert not newest().picture.state.playing  # type: ignore[union-attr]


@pytest.mark.parametrize("lesson", LESSONS)
def test_every_lesson_opens_over_the_wire(enter: Enter, newest: Newest, lesson: str) -> None:
    tab = enter()
    tab.update("lesson", value=LESSONS[lesson].words["en"].title)
    tab.until(lambda: newest().picture.lesson.id == lesson, "the lesson")  # type: ignore[union-attr]
    tab.settle()
    knobs = [k for k in LESSONS[lesson].knobs if not k.hidden]
    tab.until(lambda: all(any((w["props"].get("label") or "").startswith(k.label("en")) for w in tab.widgets.values()) for k in knobs),
              "a widget for every knob")
    assert not tab.notes


def test_the_line_beside_the_clock_follows_the_plant_on_the_stage(enter: Enter, newest: Newest) -> None:
    tab = enter()
    tab.update("lesson", value=LESSONS["network"].words["en"].title)
    tab.until(lambda: newest().picture.lesson.id == "network", "the lesson")  # type: ignore[union-attr]

    def lines() -> str:
        return " ".join(str(w["props"].get("content")) for w in tab.widgets.values() if w["type"] == "GuiHtmlMessage")
    tab.until(lambda: "A ball on a ridge rolls away" in lines(), "the first caption")
    tab.update("case", value="Pole on a cart")
    tab.until(lambda: "A pole balanced on a cart" in lines(), "the new caption")
    assert "A ball on a ridge rolls away" not in lines()


def test_the_clock_names_the_length_of_a_run_that_a_job_made_longer(enter: Enter, newest: Newest) -> None:
    tab = enter()
    lesson = LESSONS["nonlinear"]
    tab.update("lesson", value=lesson.words["en"].title)
    tab.update("case", value="pole in the fog")
    tab.settle()

    def length() -> float:
        shown = [str(w["props"].get("content")) for w in tab.widgets.values()]
        clocks = [words for words in shown if 'class="ol-note ol-clock"' in words]
        return float(clocks[0].split("/ ")[1].split(" s")[0]) if clocks else 0.0
    draft = length()
    assert draft == round(newest().picture.horizon, 5)  # type: ignore[union-attr]
    assert lesson.job is not None
    tab.press(lesson.job.label("en"))
    tab.settle()
    assert length() > 1.5 * draft


def test_the_title_of_a_chart_follows_what_it_shows(enter: Enter, newest: Newest) -> None:
    tab = enter()
    tab.update("lesson", value=LESSONS["network"].words["en"].title)

    def titles() -> set[str]:
        return {w["props"].get("title") for w in tab.widgets.values() if w["type"] == "GuiUplotMessage"}
    tab.until(lambda: "place of the ball x" in titles(), "the first title")
    tab.update("case", value="Pole on a cart")
    tab.until(lambda: "angle of the pole" in titles(), "the new title")
    assert "place of the ball x" not in titles()
    tab.settle()  # who leaves in the middle of a picture leaves viser a message that it warns of


def test_a_reload_brings_the_tab_back(enter: Enter, newest: Newest) -> None:
    tab = enter()
    tab.update(STIFFNESS, value=12.0)
    tab.until(lambda: newest().picture.design["stiffness_error"] == 12.0)  # type: ignore[union-attr]
    tab.settle()
    tab.close()
    again = enter(kept=tab.kept)
    again.until(lambda: again.value(STIFFNESS) == 12.0, "the value of before")


def test_a_tab_that_leaves_takes_its_session_and_thread_with_it(enter: Enter, server: LabServer) -> None:
    def workers() -> int:
        return sum(t.name == "observer-lab session" for t in threading.enumerate())
    before = workers()
    tabs = [enter() for _ in range(3)]
    assert len(server.sessions) == 3 and workers() >= 3  # a thread of an earlier test may still be ending
    tabs[0].press("B")  # one of them leaves in the middle of a run
    for tab in tabs:
        tab.close()
    empty(server)
    eventually(lambda: workers() <= before, "the end of the threads")  # one of an earlier test may end meanwhile


def test_what_is_written_to_a_tab_that_has_left_is_dropped_without_a_word(enter: Enter, newest: Newest, server: LabServer,
                                                                          recwarn: pytest.WarningsRecorder) -> None:
    tab = enter()
    client, picture = next(iter(server._server.get_clients().values())), newest().picture
    assert picture is not None
    screen = Screen(client)
    tab.close()
    empty(server)
    waiting = client._websock_connection.get_message_buffer().message_from_id
    before = len(waiting)
    screen.build(picture)
    screen.show(picture)
    screen.remember("nobody reads this")
    assert not recwarn.list and len(waiting) <= before


def test_a_connection_that_never_looks_costs_no_session(enter: Enter, server: LabServer) -> None:
    with WireTab(server.url, camera=False):
        enter()  # who came later has been served
        assert len(server.sessions) == 1


def test_connections_cut_in_the_middle_of_a_drag_leave_nothing_and_nobody_else_notices(enter: Enter, server: LabServer) -> None:
    other = enter()
    for _ in range(3):
        tab = enter()
        tab.press("skip")
        for phase in ("start", "update"):
            tab.drag("/board/observer/grips", phase, 0.2)
        tab.cut()
    eventually(lambda: len(server.sessions) == 1, "the end of the sessions that were cut")
    assert other.unasked() == [] and not other.notes
    other.update(DELAY, value=6.0)
    other.settle()


def test_a_heading_stands_over_its_knobs_and_goes_with_them(enter: Enter, newest: Newest) -> None:
    tab = enter()
    lesson = LESSONS["robust-observer"]
    tab.update("lesson", value=lesson.words["en"].title)
    tab.until(lambda: newest().picture.lesson is lesson, "the lesson")  # type: ignore[union-attr]
    tab.settle()

    def headings(visible: bool) -> set[str]:
        return {w["props"]["content"].split(">")[1].split("<")[0] for w in tab.widgets.values()
                if str(w["props"].get("content", "")).startswith('<div class="ol-group">') and w["props"]["visible"] == visible}
    start = lesson.start()
    wanted = {k.group("en") for k in lesson.knobs if k.group is not None and lesson.shown(k, start)}
    every = {k.group("en") for k in lesson.knobs if k.group is not None and not k.hidden}
    assert wanted and headings(True) == wanted and headings(True) | headings(False) == every


def test_a_reload_brings_back_the_lesson_that_was_open_and_the_one_before(enter: Enter, newest: Newest) -> None:
    tab, other = enter(), LESSONS["noise"]
    tab.update(STIFFNESS, value=12.0)
    tab.until(lambda: newest().picture.design["stiffness_error"] == 12.0)  # type: ignore[union-attr]
    tab.update("lesson", value=other.words["en"].title)
    tab.until(lambda: '"lesson": "noise"' in (tab.kept or ""), "the other lesson in the tab's memory")
    tab.close()
    again = WireTab(tab.url, kept=tab.kept)
    try:
        again.until(lambda: again.has("lesson") and again.value("lesson") == other.words["en"].title, "the lesson of before")
        again.update("lesson", value=LESSONS["separation"].words["en"].title)
        again.until(lambda: again.has(STIFFNESS) and again.value(STIFFNESS) == 12.0, "the design of before")
    finally:
        again.close()


def test_a_browser_that_answers_late_or_never_is_not_written_to(enter: Enter, newest: Newest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 42 reloads under load 23 lost their design."""
    first = enter()
    first.update(STIFFNESS, value=12.0)
    first.until(lambda: '"stiffness_error": "12' in (first.kept or ""), "the tab's memory")
    kept = first.kept
    first.close()
    monkeypatch.setattr("observer_lab.session.session.RECALL_TIMEOUT_S", 0.1)
    tab = enter(kept=kept, answers=False)
    assert tab.value(STIFFNESS) == 0.0
    tab.update(DELAY, value=6.0)
    tab.until(lambda: newest().picture.design["delay"] == 6.0, "the work goes on")  # type: ignore[union-attr]
    tab.until(lambda: newest().picture.resting, "rest")  # type: ignore[union-attr]
    assert tab.kept == kept
    tab.answers = True
    tab.until(lambda: tab.kept != kept, "the answer to a later question")
    assert newest().picture.design["delay"] == 6.0  # type: ignore[union-attr]
    tab.command("Undo")
    tab.until(lambda: tab.value(STIFFNESS) == 12.0, "what was kept, one step of undo away")


def test_boards_are_veiled_until_a_prediction(enter: Enter) -> None:
    """No cross, no name and no bolt of a board that the path does not show before its question; a word that says why stands there."""
    tab = enter()
    tab.update("lesson", value=LESSONS["virtual-sensor"].words["en"].title)
    tab.until(lambda: tab.has("sensor noise [K]"), "the lesson")
    tab.settle()

    def seen() -> set[str]:
        return {name for name, node in tab.nodes.items() if name.startswith("/board/observer/") and node.get("visible", True)}
    signs = {f"/board/observer/{kind}{i}" for kind in ("pole", "name") for i in range(2)}
    assert not signs & seen() and "/board/observer/asks" in seen()
    tab.press("skip")
    tab.settle()
    assert {"/board/observer/pole0", "/board/observer/pole1"} <= seen() and "/board/observer/asks" not in seen()


def test_no_hand_takes_a_pole_before_the_prediction_where_the_path_shows_its_board(enter: Enter) -> None:
    tab = enter()
    tab.settle()
    assert "/board/observer/pole5" in tab.nodes and "/board/observer/grips" not in tab.nodes
    tab.press("skip")
    tab.until(lambda: "/board/observer/grips" in tab.nodes, "the discs by which poles are dragged")
