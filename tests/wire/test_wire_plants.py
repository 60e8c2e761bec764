"""A plant uploaded over the real protocol: it changes the page, stays in its tab, and nothing hostile gets through."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from client import WireTab

from observer_lab.page.column.plant_picker import MOST_BYTES
from observer_lab.page.screen.server import LabServer
from observer_lab.plants.examples import DATA, example
from observer_lab.session.session import Session

UPLOAD, MISMATCH = "Upload a plant (.json, .mat)", "the plant is faster than its model by [%]"
STIFFNESS = "stiffness error in the model [%]"
Enter = Callable[..., WireTab]
Newest = Callable[[], Session]
MOTOR = (DATA / "motor.json").read_bytes()


def send_file(tab: WireTab, name: str, data: bytes, uuid: str | None = None, size: int | None = None, parts: int = 1) -> None:
    """What the page sends when a file is chosen."""
    target, step = uuid or tab.find(UPLOAD), -(-len(data) // parts) if data else 1
    tab.send("FileTransferStartUpload", source_component_uuid=target, transfer_uuid=f"transfer-{name}-{len(data)}-{parts}", filename=name,
             mime_type="application/json", part_count=parts if data else 0, size_bytes=len(data) if size is None else size)
    for i in range(parts if data else 0):
        tab.send("FileTransferPart", source_component_uuid=target, transfer_uuid=f"transfer-{name}-{len(data)}-{parts}", part_index=i,
                 content=data[i * step:(i + 1) * step])


def told_over(tab: WireTab) -> int:
    """How many uploads the page was told to be over: their notices are gone, and their button can be pressed again."""
    closed = [m["uuid"] for m in tab.messages if m["type"] == "RemoveNotificationMessage"]
    gone = [name.removeprefix("upload-") for name in closed if name.startswith("upload-")]
    acks = {m["transfer_uuid"] for m in tab.messages if m["type"] == "FileTransferPartAck" and m["transferred_bytes"] == m["total_bytes"]}
    assert acks == set(gone)
    return len(gone)


def shows(session: Session, plant: str) -> bool:
    return session.picture is not None and session.picture.design.plant == plant


@pytest.mark.parametrize("parts", [1, 3])
def test_an_uploaded_plant_changes_knobs_curves_and_stage(enter: Enter, newest: Newest, parts: int) -> None:
    tab = enter()
    assert tab.has(UPLOAD) and not tab.has(MISMATCH)
    send_file(tab, "motor.json", MOTOR, parts=parts)
    tab.until(lambda: shows(newest(), example("motor")), "the plant")
    tab.until(lambda: tab.has(MISMATCH) and not tab.has(STIFFNESS), "its knobs")
    tab.settle()
    assert any(name.startswith("/plant/tube") for name in tab.nodes) and not tab.notes
    assert told_over(tab) == 1
    tab.command("Undo")
    tab.until(lambda: shows(newest(), "") and tab.has(STIFFNESS), "the way back")


def test_a_mat_file_is_taken_too_and_the_dropdown_leads_back(enter: Enter, newest: Newest) -> None:
    tab = enter()
    send_file(tab, "beam.mat", (DATA / "beam.mat").read_bytes())
    tab.until(lambda: shows(newest(), example("beam")) and tab.has(MISMATCH), "the beam")
    tab.settle()
    tab.update("plant", value="the lesson's own")
    tab.until(lambda: shows(newest(), "") and tab.has(STIFFNESS), "the lesson's own plant")


def test_an_upload_is_seen_by_its_own_tab_alone_and_survives_a_reload(enter: Enter, newest: Newest, server: LabServer) -> None:
    other = enter()
    tab = enter()
    first, second = (server.sessions[i] for i in sorted(server.sessions))
    send_file(tab, "motor.json", MOTOR)
    tab.until(lambda: shows(second, example("motor")), "the plant")
    tab.settle()
    assert shows(first, "")
    assert other.unasked() == []
    tab.close()
    again = WireTab(server.url, kept=tab.kept)
    try:
        again.until(lambda: again.has(MISMATCH), "the plant of before")
    finally:
        again.close()


def test_a_malformed_file_gets_one_sentence_and_the_page_stays(enter: Enter, newest: Newest) -> None:
    tab = enter()
    send_file(tab, "torn.json", b"{")
    tab.until(lambda: len(tab.notes) == 1, "the sentence")
    send_file(tab, "empty.json", b"")
    tab.until(lambda: len(tab.notes) == 2, "another sentence")
    assert told_over(tab) == 2
    assert shows(newest(), "") and tab.has(STIFFNESS)


def test_what_is_too_large_is_refused_before_it_is_gathered(enter: Enter, newest: Newest) -> None:
    tab = enter()
    send_file(tab, "huge.json", b"x", size=MOST_BYTES + 1)
    tab.until(lambda: any("1 MB" in note for note in tab.notes), "the sentence")
    send_file(tab, "liar.json", b"x" * 5000, size=10)  # announces less than it sends
    tab.until(lambda: sum("1 MB" in note for note in tab.notes) == 2, "a second sentence")
    send_file(tab, "slider.json", MOTOR, uuid=tab.find(STIFFNESS))  # no upload button
    tab.until(lambda: sum("1 MB" in note for note in tab.notes) == 3, "a third sentence")
    assert shows(newest(), "")
    tab.update(STIFFNESS, value=5.0)
    tab.until(lambda: newest().picture.design["stiffness_error"] == 5.0, "the slider still works")  # type: ignore[union-attr]
    send_file(tab, "motor.json", MOTOR)
    tab.until(lambda: shows(newest(), example("motor")), "a good file after all")
    tab.settle()
    assert told_over(tab) == 4
