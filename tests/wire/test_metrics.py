"""What a server says of itself: memory, latency, the store of its room, and all of it in the form of Prometheus."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable
from pathlib import Path
from urllib.request import urlopen

import pytest
from client import WireTab, eventually
from lecture import counts, opened

from observer_lab.classroom.room_store import RoomStore
from observer_lab.course.handin.course_file import read_course
from observer_lab.course.handin.ledger import Ledger
from observer_lab.course.handin.served_course import ServedCourse
from observer_lab.lessons import LESSONS
from observer_lab.page.access.metrics import metrics_text
from observer_lab.page.access.shared_counters import SharedCounters, WorkerSlot
from observer_lab.page.screen.server import LabServer

LABEL = r'[a-z_]+="(?:[^"\\\n]|\\.)*"'
SAMPLE = re.compile(rf"([a-z_:][a-z0-9_:]*)(\{{{LABEL}(?:,{LABEL})*\}})? (-?[0-9.e+-]+|NaN|[+-]Inf)")
COMMENT = re.compile(r"# (HELP [a-z_:]+ [^\n]+|TYPE [a-z_:]+ (gauge|counter))")


def samples(text: str) -> dict[str, float]:
    """The samples of an exposition, each line of which is one or a comment about one."""
    found = {}
    for line in text.strip().split("\n"):
        sample = SAMPLE.fullmatch(line)
        assert sample is not None or COMMENT.fullmatch(line), line
        if sample is not None:
            found[sample[1] + (sample[2] or "")] = float(sample[3])
            assert f"# TYPE {sample[1]} gauge" in text
    return found


def health(server: LabServer) -> dict[str, object]:
    with urlopen(f"{server.url}/health", timeout=20) as answer:
        return json.loads(answer.read())


def test_metrics_say_what_health_says(server: LabServer, enter: Callable[..., WireTab]) -> None:
    enter()
    with urlopen(f"{server.url}/metrics", timeout=20) as answer:
        assert answer.headers["Content-Type"].startswith("text/plain; version=0.0.4")
        found = samples(answer.read().decode())
    said = health(server)
    assert found["observer_lab_tabs"] == said["tabs"] == 1 and found["observer_lab_up"] == 1
    assert 2e7 < found["observer_lab_resident_bytes"] < 4e9
    assert {f"observer_lab_{name}" for name, value in said.items() if isinstance(value, (int, float))} <= set(found)


def test_each_worker_has_its_figures_and_an_odd_version_is_escaped() -> None:
    slot = WorkerSlot(SharedCounters(3), 1)
    slot.note(2, 1000, 0.25)
    found = samples(metrics_text({"status": "degraded", "version": 'a"b\\c\nd', "store": "failing", **slot.health()}))
    assert found['observer_lab_worker_stuck{worker="2"}'] == 2 and found['observer_lab_worker_lag_s{worker="2"}'] == 0.25
    assert found["observer_lab_up"] == found["observer_lab_store_up"] == 0 and found["observer_lab_resident_bytes"] == 1000


def test_a_room_whose_store_fails_says_so_to_health_and_presenter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    server = opened(tmp_path)
    word = RoomStore(tmp_path).secret
    try:
        with WireTab(server.url, word=word) as presenter:
            presenter.settle()
            assert health(server)["store"] == health(server)["status"] == "ok"

            def fails(*_: object) -> None:
                raise OSError("No space left on device")
            for name in ("report", "presence", "cast"):
                monkeypatch.setattr(RoomStore, name, fails)
            eventually(lambda: health(server)["store"] == "failing", "what health says")
            assert health(server)["status"] == "degraded"
            presenter.until(lambda: "ol-failing" in counts(presenter), "what the presenter sees")
            monkeypatch.undo()
            eventually(lambda: health(server)["status"] == "ok", "that it is well again")
            presenter.until(lambda: "ol-failing" not in counts(presenter), "that the presenter sees no more of it")
    finally:
        server.stop()


def test_a_course_whose_store_fails_says_so_to_health(tmp_path: Path) -> None:
    ledger, file = Ledger(tmp_path), tmp_path / "course.sqlite"
    course = read_course('course = "c"\nsecret = "a secret of a course, for tests alone"\n[[lessons]]\nlesson = "kalman"\nexams = "all"\n',
                         LESSONS, str)
    server, kept = LabServer(LESSONS, port=0, course=ServedCourse(course, time.time, ledger)), file.read_bytes()
    try:
        assert health(server)["store"] == health(server)["status"] == "ok"
        file.write_bytes(b"no database at all" * 100)
        with pytest.raises(OSError):
            ledger.use_nonce("a login")
        assert health(server)["store"] == "failing" and health(server)["status"] == "degraded"
        file.write_bytes(kept)
        assert ledger.use_nonce("a login") and health(server)["status"] == "ok"
    finally:
        server.stop()
