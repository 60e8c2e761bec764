"""What ends and begins again around `live`: a cable that is pulled, a plant that is killed, and `live` itself, whose children end too."""

import os
import pty
import signal
import subprocess
import sys
import time
import tty
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from live_endurance import LIVE, endure

from observer_lab.engine.systems import discretise
from observer_lab.export.devices.c_project import simulator_files
from observer_lab.export.devices.folders import device_design
from observer_lab.lessons import LESSONS
from observer_lab.live.lines import LineReader
from observer_lab.live.observer import LiveObserver
from observer_lab.live.simulated import simulated
from observer_lab.live.sources import from_serial

PATIENCE_S = 90.0


def plugged(link: Path) -> int:
    """A pseudo-terminal behind a name, as a board behind its port; the end of the board."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    link.unlink(missing_ok=True)
    link.symlink_to(os.ttyname(theirs))
    os.close(theirs)
    return ours


def test_serial_line_goes_on_after_the_cable_was_pulled_and_no_line_is_made_of_two(tmp_path) -> None:
    lesson = LESSONS["noise"]
    routine = device_design(lesson, lesson.compute(lesson.start())).routine
    link, T = tmp_path / "board", routine.period
    reader, observer = LineReader(("u",), ("y",)), LiveObserver(routine)
    theirs, held = pty.openpty()  # so that the port is there while nobody has opened it
    tty.setraw(held)
    link.symlink_to(os.ttyname(held))
    sent = {round(k * T, 9): (0.5 * k, -0.25 * k) for k in range(60)}
    line = [f"{t!r},{u!r},{y!r}\n".encode() for t, (u, y) in sent.items()]
    taken = []

    def read_until(count: int) -> None:
        end = time.monotonic() + PATIENCE_S
        while len(taken) < count:
            assert time.monotonic() < end
            taken.extend(reader.feed(read(0.05) or b""))

    with from_serial(str(link), 115200) as read:
        os.write(theirs, b"".join(line[:20]) + line[20][:-3])
        read_until(20)
        os.close(theirs)
        os.close(held)
        link.unlink()
        for _ in range(4):
            assert read(0.02) == b""
        theirs = plugged(link)
        end = time.monotonic() + PATIENCE_S
        while True:  # a board says its lines from when it has current; it is heard from when its port is open
            os.write(theirs, b"7,7\n" + b"".join(line[30:]))
            found = read(0.2)
            if found:
                break
            assert time.monotonic() < end
        taken.extend(reader.feed(found))
        read_until(50)
    os.close(theirs)
    assert all(sent[round(each.t, 9)] == (each.u[0], each.y[0]) for each in taken)
    assert reader.refused == {"not ASCII": 1}
    steps = [observer.take(sample) for sample in taken[:50]]
    assert all(step is not None and np.isfinite(step.xhat).all() for step in steps) and (observer.lost, observer.restarts) == (10, 0)


def session_of(leader: int) -> set[int]:
    """The processes of a session."""
    found = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, session = stat.read_text().rpartition(")")[2].split()[:4]
        except OSError:  # it has just ended
            continue
        if int(session) == leader and state != "Z":
            found.add(int(stat.parent.name))
    return found


def eventually(true, what: str) -> None:
    end = time.monotonic() + PATIENCE_S
    while not true():
        assert time.monotonic() < end, what
        time.sleep(0.05)


def started(folder: Path, *options: str) -> subprocess.Popen:
    """`live --simulate` with a record, once it records, in a session of its own and with a folder of its own for what is temporary."""
    (folder / "temporary").mkdir()
    env = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "TMPDIR": str(folder / "temporary")}
    process = subprocess.Popen([sys.executable, "-c", LIVE, "live", "noise", "--simulate", "--record", "run.csv", *options], cwd=folder,
                               env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)
    record = folder / "run.csv"
    eventually(lambda: (record.exists() and record.read_text().count("\n") > 5) or process.poll() is not None, "lines of the plant")
    assert process.poll() is None, process.stderr.read()
    return process


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are found in /proc")
@pytest.mark.parametrize("how, options", [(signal.SIGTERM, ["--page", "0"]), (signal.SIGKILL, ["--page", "0"]), (signal.SIGINT, ["--json"]),
                                          (signal.SIGHUP, [])])
def test_no_child_outlives_live(how: int, options: list[str], tmp_path) -> None:
    process = started(tmp_path, *options)
    assert len(session_of(process.pid)) > 1
    process.send_signal(how)
    process.communicate(timeout=PATIENCE_S)
    eventually(lambda: not session_of(process.pid), "no process of its session")
    left = [path.name for path in (tmp_path / "temporary").glob("observer-lab-*")]
    assert left == [] or how == signal.SIGKILL
    rows = (tmp_path / "run.csv").read_text().splitlines()
    assert {len(row.split(",")) for row in rows[:-1]} == {3}


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are found in /proc")
def test_live_ends_with_its_counts_where_its_plant_is_killed(tmp_path) -> None:
    process = started(tmp_path)
    (plant,) = session_of(process.pid) - {process.pid}
    os.kill(plant, signal.SIGKILL)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and b"lines " in said and b"refused: none" in said
    assert np.isfinite(np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)).all()
    assert list((tmp_path / "temporary").iterdir()) == []


def test_plant_that_falls_over_is_put_back_and_goes_on() -> None:
    """Nobody feeds an unstable plant anything back: it must not run off until all its readings are missing."""
    lesson = LESSONS["saturation"]
    outcome = lesson.compute(lesson.start())
    design, s = device_design(lesson, outcome), outcome.run.scenario
    files = simulator_files(design, discretise(s.plant, design.routine.period), s.x0)
    reader, fallen = LineReader(("force",), ("position",)), []
    with simulated(files, 3000, paced=False, driven=True, knocks=250) as source:
        while (data := source(5.0)) is not None:
            fallen += [float(np.abs(sample.y).max()) for sample in reader.feed(data)]
    assert reader.refused == {} and np.isfinite(fallen).all() and max(fallen) < 200 * 20 * np.abs(s.x0).max()
    assert sum(after < before / 10 for before, after in pairwise(fallen)) > 2


@pytest.mark.slow
def test_ten_seconds_at_100_hz_lose_nothing_but_what_the_plant_leaves_out(tmp_path) -> None:
    """`python tests/live_endurance.py` does it for ten minutes."""
    found = endure("arm", 10.0, tmp_path)
    assert found.period <= 0.01 and found.wrong_rows == found.differing == 0
    assert found.rows == found.lines < found.periods
    last = found.periods - 1 - found.lines  # lost periods, less those after the last line, which nobody can count
    assert f"lines {found.lines}; " in found.said and "out of order 0; jittered 0; refused: none; restarts 0" in found.said
    assert int(found.said.partition("lost periods ")[2].partition(";")[0]) in (last, last + 1)
    assert found.growth < 2.0
