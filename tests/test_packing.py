"""A folder's files hold what was recorded: runs to what a pixel shows, values once for all looks of a language."""

from __future__ import annotations

import base64
import gzip
import json
import re
from typing import Any

import numpy as np
import pytest

from observer_lab.page.record.recorded_screen import RecordedRun
from observer_lab.page.viser_private.stage_frames import PROPERTY_KINDS, Frame, letters_of, viser_value
from observer_lab.static_pages.packing import STEPS, Arrays, Runs, Tables, data_file

PIXEL = 6e-3  # stage units: of the whole stage in a window of 929 × 768 pixels
COUNT = 60


def opened(words: str) -> tuple[Any, list[np.ndarray]]:
    """What a script file holds."""
    found = re.fullmatch(r'observerLabData\("[^"]*","([^"]*)"\)\n', words)
    assert found is not None
    plain = gzip.decompress(base64.b64decode(found[1]))
    head = int.from_bytes(plain[:8], "little")
    content, rest = json.loads(plain[8:8 + head]), plain[8 + head:]
    return content["content"], [np.frombuffer(rest, kind, size, place) for kind, size, place in content["arrays"]]


def unpacked(run: dict[str, Any], arrays: list[np.ndarray]) -> dict[tuple[str, str], np.ndarray]:
    """The numbers of a run, one row for each time, summed in 16 bits."""
    out = {}
    for name, kind, wide, step, deltas, other in run["channels"]:
        total = arrays[deltas].reshape(wide, run["count"]).astype(np.int64)
        if other >= 0:
            total = total + arrays[other].reshape(wide, run["count"])
        out[run["names"][name], PROPERTY_KINDS[kind]] = np.cumsum(total, axis=1).astype(np.int16).T * step
    return out


def frames(change: float, phase: float = 0.0) -> tuple[Frame, ...]:
    """A body that moves and turns, a colour, and lines of which there are more and fewer."""
    out = []
    for k in range(COUNT):
        t = 0.1 * k + phase
        lines = tuple(np.sin(t + np.arange(6.0 * (k % 3))).tolist())
        out.append({("/body", "position"): (np.sin(t) * (1 + change), np.cos(3 * t), 0.02 * t), ("/fixed", "position"): (1.0, 2.0, 3.0),
                    ("/body", "wxyz"): (np.cos(t / 2), 0.0, np.sin(t / 2), 0.0), ("/body", "scale"): (1.0, 1.0, 1.0 + 0.1 * t),
                    ("/body", "color"): (float(k), 0.0, 255.0 - k), ("/lines", "points"): lines})
    return tuple(out)


def recorded(change: float, phase: float = 0.0) -> RecordedRun:
    return RecordedRun(tuple(0.1 * k for k in range(COUNT)), frames(change, phase), 0.1 * (COUNT - 1), 1.0)


@pytest.mark.parametrize("changes", [(0.0, 1e-3), (0.0, 0.5, 0.51), (0.0, 25.0), (30.0, 0.0, 29.0)])
def test_a_run_is_read_back_to_half_a_step_that_no_pixel_shows(changes: tuple[float, ...]) -> None:
    runs, given = Runs(Arrays()), [recorded(change, change) for change in changes]
    numbers = [runs.add(run) for run in given]
    content, arrays = opened(data_file("a name", {"runs": runs.kept}, runs.arrays.kept))
    for run, number in zip(given, numbers, strict=True):
        found = unpacked(content["runs"][number], arrays)
        assert ("/fixed", "position") not in found, "what does not move is in the state, not in its run"
        for (name, kind), rows in found.items():
            for frame, row in zip(run.frames, rows, strict=True):
                wanted = np.array(frame[name, kind])
                step = max(STEPS[kind], 31 * 1.1 / 32767)
                assert np.abs(row[:len(wanted)] - wanted).max(initial=0.0) <= step / 2 + 1e-12
                assert np.all(row[len(wanted):].reshape(-1, 3)[:, 2] < -8.9), "a line that a frame lacks is out of sight"


def test_words_that_change_in_a_run_are_read_back_letter_for_letter() -> None:
    words = [f"e₁ = {'−' if k % 3 else ''}{1.7 ** k / 100:.2f} m" for k in range(COUNT)]
    runs = Runs(Arrays())
    number = runs.add(RecordedRun(tuple(0.1 * k for k in range(COUNT)), tuple({("/words", "text"): letters_of(each)} for each in words),
                                  6.0, 1.0))
    content, arrays = opened(data_file("a name", {"runs": runs.kept}, runs.arrays.kept))
    rows = unpacked(content["runs"][number], arrays)["/words", "text"]
    assert [viser_value("text", tuple(row)).rstrip() for row in rows] == words


def test_the_steps_of_a_run_are_finer_than_a_tenth_of_a_pixel() -> None:
    assert set(STEPS) == set(PROPERTY_KINDS)
    assert max(STEPS[kind] for kind in ("position", "scale", "points")) <= PIXEL / 10
    assert 2 * STEPS["wxyz"] * 2.0 <= PIXEL / 10, "the end of an arm of two units"


def test_equal_runs_and_near_runs_take_little() -> None:
    runs = Runs(Arrays())
    first = runs.add(recorded(0.0))
    alone = len(data_file("a", {"runs": runs.kept}, runs.arrays.kept))
    assert runs.add(recorded(0.0)) == first and len(runs.kept) == 1
    for k in range(10):
        assert runs.add(recorded(1e-3 * (k + 1))) == k + 1
    assert len(data_file("a", {"runs": runs.kept}, runs.arrays.kept)) < 4 * alone


def test_the_looks_of_a_language_share_values_and_each_keeps_its_own() -> None:
    tables, long = Tables(), "<p>" + "a long text " * 50
    array = np.linspace(0.0, 1.0, 9)
    looks = [{("gui:1", "content"): long, ("gui:2", "value"): k, ("chart", "data"): (array.copy(), array + k)} for k in range(4)]
    patches = [tables.difference({("gui:0", "content"): "gone"}, look) for look in looks]
    content, arrays = opened(data_file("a", {**tables.content, "patches": patches}, tables.arrays.kept))
    assert sum(value == long for value in content["values"]) == 1 and len(arrays) == 4
    for look, patch in zip(looks, content["patches"], strict=True):
        found = {tuple(content["places"][place]): content["values"][value] if value >= 0 else None for place, value in patch}
        assert found[("gui:0", "content")] is None and found[("gui:1", "content")] == long
        assert found[("gui:2", "value")] == look[("gui:2", "value")]
        assert [arrays[each["$"]].tolist() for each in found[("chart", "data")]] == [each.tolist() for each in look[("chart", "data")]]
