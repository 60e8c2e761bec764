"""A plant beside the model: lines are read or refused, nothing of them breaks the estimate, and the simulated device is followed."""

import json
import os
import pty
import socket
import threading
import tracemalloc
import tty

import numpy as np
import pytest
from laws import each

from observer_lab.cli import main
from observer_lab.devices import Device, DeviceError, watching
from observer_lab.engine.systems import discretise
from observer_lab.export.devices.c_project import simulator_files
from observer_lab.export.devices.folders import device_design
from observer_lab.lessons import LESSONS
from observer_lab.live.lines import LONGEST_LINE, LineError, LineReader, with_checksum
from observer_lab.live.observer import MOST_BRIDGED, LiveObserver
from observer_lab.live.simulated import simulated
from observer_lab.live.sources import SourceError, from_descriptor, from_serial, from_udp


def designed(name: str):
    lesson = LESSONS[name]
    outcome = lesson.compute(lesson.start())
    return outcome, device_design(lesson, outcome)


def reader(checked: bool = False) -> LineReader:
    return LineReader(("a",), ("b", "c"), checked)


@each("line, values", [(b"1.5,2,3,4", [1.5, 2, 3, 4]),
                       (b" 1e0 , -2.0,,nan\r", [1, -2, np.nan, np.nan]), (b".5,0,1.e3,1e13", [0.5, 0, 1000, np.nan])])
def test_line_is_read(line: bytes, values: list[float]) -> None:
    sample = reader().read(line)
    assert sample is not None and np.array_equal([sample.t, *sample.u, *sample.y], values, equal_nan=True)


@each("line, why", [(b"1,2,3", "wrong number of values"), (b"1,2,3,4,5", "wrong number of values"), (b"nan,1,2,3", "no time"),
                    (b"1,nan,2,3", "an input is missing"), (b"1,2,3,0x10", "not a number"), (b"1,2,3,inf", "not a number"),
                    (b"1,2,3,1_0", "not a number"), (b"\xff,1,2,3", "not ASCII"), (b"1,2,3,4*00", "wrong checksum"),
                    (b"1" * (LONGEST_LINE + 1), "too long"), (b"# t,u:x,y:b,y:c", "header names other signals"),
                    (b"1e999,1,2,3", "no time"), (b"1,2,3,__import__('os')", "not a number")])
def test_line_is_refused_in_words(line: bytes, why: str) -> None:
    with pytest.raises(LineError, match=why):
        reader().read(line)


def test_header_gives_the_order_and_checksum_is_asked_for() -> None:
    other = reader(checked=True)
    line = with_checksum("1,10,20,30")
    assert next(other.feed(f"# t,y:c,u:a,y:b\n1,10,20,30\n{line}\n".encode())).y.tolist() == [30.0, 10.0]
    assert other.refused == {"no checksum": 1} and other.taken == 1


def test_endless_line_costs_a_bounded_memory_and_ends_at_the_next_line() -> None:
    other = reader()
    tracemalloc.start()
    for _ in range(2000):
        assert [*other.feed(b"9" * 10_000)] == []
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1_000_000 and other.refused == {"too long": 1}
    assert len([*other.feed(b"\n1,2,3,4\n")]) == 1


def test_ten_thousand_hostile_lines_leave_the_estimate_as_it_is() -> None:
    _, design = designed("separation")
    random, names = np.random.default_rng(1), (design.routine.u_names, ("VL", "HL", "VR", "HR"))
    alone, beset = LiveObserver(design.routine), LiveObserver(design.routine)
    clean, dirty = LineReader(*names), LineReader(*names)
    for k in range(200):
        good = ",".join(repr(float(v)) for v in (k * design.routine.period, *design.u[k], *design.y[k])).encode() + b"\n"
        bad = b"".join(random.bytes(int(random.integers(1, 60))).replace(b"\n", b"") + b"\n" for _ in range(50))
        (first,), (second,) = clean.feed(good), dirty.feed(bad + good)
        a, b = alone.take(first), beset.take(second)
        assert a is not None and b is not None and np.array_equal(a.xhat, b.xhat)
    assert sum(dirty.refused.values()) > 9_000 and dirty.taken == 200


def test_lies_in_good_form_never_raise_and_the_estimate_stays_finite() -> None:
    random = np.random.default_rng(2)
    for name in ("separation", "kalman", "fault-diagnosis"):
        _, design = designed(name)
        p, m = len(design.routine.y_names), len(design.routine.u_names)
        observer, lines = LiveObserver(design.routine), LineReader(("u",) * m, ("y",) * p)
        for _ in range(600):
            values = random.choice([0.0, 1e12, -1e12, 1e-300, 1.0], m + p)
            t = random.choice([random.random() * 1e3, -5.0, 1e11])
            for sample in lines.feed((",".join(map(repr, map(float, (t, *values)))) + "\n").encode()):
                step = observer.take(sample)
                assert step is None or np.isfinite(step.xhat).all()


def test_gaps_are_stepped_through_and_long_ones_begin_anew() -> None:
    _, design = designed("noise")
    observer, lines, T = LiveObserver(design.routine), LineReader(("u",), ("y",)), design.routine.period
    times = [0.0, T, 4 * T, 3 * T, 5.3 * T, 6 * T + (MOST_BRIDGED + 5) * T]
    steps = [observer.take(sample) for t in times for sample in lines.feed(f"{t!r},0.0,0.1\n".encode())]
    assert [None if step is None else step.lost for step in steps] == [0, 0, 2, None, 0, 0]
    assert (observer.lost, observer.disordered, observer.jittered, observer.restarts) == (2, 1, 1, 1)


def test_simulated_device_is_followed_bit_for_bit_with_lines_lost_and_late() -> None:
    """What a device makes of the recorded lines, lost ones as missing readings, is what stood on the screen."""
    outcome, design = designed("separation")
    T, s = design.routine.period, outcome.run.scenario
    files = simulator_files(design, discretise(s.plant, T), s.x0)
    observer, lines = LiveObserver(design.routine), LineReader(("u1", "u2", "u3"), ("VL", "HL", "VR", "HR"))
    count, held = 0, np.zeros(3)
    recorded = Device(watching(design.routine))
    with simulated(files, 5000, lost=0.01, jitter=0.05, paced=False) as read:
        while (data := read(5.0)) is not None:
            for sample in lines.feed(data):
                step = observer.take(sample)
                assert step is not None
                for _ in range(step.lost):
                    recorded.step([np.nan] * 4, held)
                recorded.step(sample.y, sample.u)
                held = sample.u
                assert np.array_equal(step.xhat, recorded.read("xhat"))
                count += 1
    assert lines.refused == {} and 20 < observer.lost < 90 and count + observer.lost in (4999, 5000)


def test_datagrams_and_a_serial_line_bring_the_same_lines(capfd) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with from_udp(port) as read, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"1,2,3,4", ("127.0.0.1", port))
        assert len([*reader().feed(read(10.0) or b"")]) == 1
        with pytest.raises(SourceError, match="choose another"), from_udp(port):
            pass
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    with from_serial(os.ttyname(theirs), 115200) as read:
        os.write(ours, b"1,2,3,4\n")
        lines, found = reader(), 0
        while not found:
            found = len([*lines.feed(read(10.0) or b"")])
    os.close(ours)
    os.close(theirs)
    with pytest.raises(SourceError, match="cannot be opened as a serial port"), from_serial("/dev/no-such-port", 9600):
        pass


def test_command_prints_estimates_and_writes_a_record_that_the_lesson_reads(tmp_path, capsys, monkeypatch) -> None:
    _, design = designed("noise")
    ours, theirs = os.pipe()
    random, model = np.random.default_rng(4), Device(design.routine)
    u, y = random.choice([-1.0, 1.0], 300), 0.01 * random.normal(size=300).cumsum()
    words = "".join(f"{k * design.routine.period!r},{float(u[k])!r},{float(y[k])!r}\n" for k in range(300))
    told = model.run(y[:, None], u[:, None])["xhat"]
    threading.Thread(target=lambda: (os.write(theirs, words.encode()), os.close(theirs))).start()
    monkeypatch.setattr("sys.stdin", os.fdopen(ours))
    table = tmp_path / "record.csv"
    assert main(["live", "noise", "--stdin", "--json", "--record", str(table)]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert len(rows) == 300 and np.array_equal([row["xhat"] for row in rows], told)
    head = table.read_text().splitlines()[0].split(",")
    assert head[1].startswith("u_") and head[2].startswith("y_")
    assert main(["run", "record", "--data", str(table), "--columns", f"t=t u={head[1]} y={head[2]}", "--json"]) in (0, 1)


def test_controller_without_an_estimate_is_refused(capsys) -> None:
    _, design = designed("showdown")
    with pytest.raises(DeviceError, match="controller without an estimate"):
        watching(design.routine)
    assert main(["live", "showdown", "--stdin"]) == 2 and "nothing to compare" in capsys.readouterr().err
    with from_descriptor(os.open(os.devnull, os.O_RDONLY)) as read:
        assert read(0.0) is None


@each("every, said", [(0.5, "every 0.5 times"), (1.0, ""), (1000.0, "every 1000 times")])
def test_lines_at_another_pace_than_the_observers_are_named(every: float, said: str, capsys, monkeypatch) -> None:
    _, design = designed("noise")
    period = design.routine.period
    lines = "".join(f"{k * every * period:.9g},0,0\n" for k in range(50))
    there, here = os.pipe()
    os.write(here, lines.encode())
    os.close(here)
    with os.fdopen(there) as source:
        monkeypatch.setattr("sys.stdin", source)
        assert main(["live", "noise", "--stdin"]) == 0
    told = capsys.readouterr().err
    assert ("the lines come every" in told) == bool(said)
    assert not said or f"every {every * period:.4g} s" in told
