"""Steps made regular, gaps left open, levels taken out, halves."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import EngineError
from observer_lab.engine.identification import Record, detrend, resample, split_record, trend_of


def test_a_regular_record_comes_back_as_it_is() -> None:
    record = Record(0.1 * np.arange(50), np.ones(50), np.ones(50))
    assert resample(record) is record


def test_inputs_are_held_and_outputs_interpolated() -> None:
    t = np.array([0, 1, 2, 2.5, 4, 5, 6, 7, 8, 9.0])
    found = resample(Record(t, np.floor(t), 3 * t))
    np.testing.assert_allclose(found.t, np.arange(10))
    np.testing.assert_allclose(found.y[:, 0], 3 * found.t)
    np.testing.assert_array_equal(found.u[:, 0], [0, 1, 2, 2, 4, 5, 6, 7, 8, 9])
    assert "irregular" in found.notes[0]


def test_a_gap_stays_missing_and_is_said() -> None:
    t = np.delete(np.arange(40.0), slice(10, 18))
    found = resample(Record(t, np.ones(len(t)), t))
    assert np.flatnonzero(np.isnan(found.y[:, 0])).tolist() == list(range(10, 18))
    assert "Rows that are missing: 8" in found.notes[0]


def test_a_coarser_step_keeps_slow_signals_and_takes_fast_ones_out() -> None:
    t = 0.01 * np.arange(4000)
    slow, fast = np.sin(0.5 * t), np.sin(2 * np.pi * 40 * t)
    found = resample(Record(t, slow, slow + fast), step=0.1)
    middle = slice(20, -20)
    assert found.dt == pytest.approx(0.1) and "10th row" in found.notes[0]
    np.testing.assert_allclose(found.y[middle, 0], np.sin(0.5 * found.t[middle]), atol=0.01)


def test_a_level_and_a_line_are_those_of_the_first_part() -> None:
    t = np.arange(100.0)
    record = Record(t, 3 + 0 * t, 5 + 0.25 * t)
    first, rest = split_record(record, share=0.4)
    assert (first.rows, rest.rows) == (40, 60)
    line = detrend(record, trend_of(first, degree=1))
    np.testing.assert_allclose(line.y, 0, atol=1e-10)
    np.testing.assert_allclose(line.u, 0, atol=1e-10)
    assert detrend(record, trend_of(first)).y[:40].mean() == pytest.approx(0)


@pytest.mark.parametrize("act, words", [
    (lambda r: resample(r, step=50.0), "fewer than 8 rows"), (lambda r: split_record(r, share=0.01), "fewer than 8 rows"),
    (lambda r: resample(r, step=1e-5), "more than 1000000 rows"),
])
def test_what_leaves_nothing_is_refused(act, words: str) -> None:
    with pytest.raises(EngineError, match=words):
        act(Record(np.arange(100.0), np.ones(100), np.ones(100)))


@pytest.mark.parametrize("step", [1.4, 2.0, 3.7, 0.6])
def test_a_record_comes_at_the_step_that_was_asked_for(step: float) -> None:
    t = np.arange(400.0)
    found = resample(Record(t, np.ones(400), np.sin(0.05 * t)), step=step)
    np.testing.assert_allclose(np.diff(found.t), step, rtol=1e-9)
    inside = slice(20, -20)
    np.testing.assert_allclose(found.y[inside, 0], np.sin(0.05 * found.t[inside]), atol=5e-3)


def test_a_step_that_is_a_little_too_large_keeps_the_last_row() -> None:
    t = 0.05 * np.arange(478)
    found = resample(Record(np.delete(t, 7), np.ones(477), np.arange(477.0)), step=float(np.float32(0.05)))
    assert len(found.t) == 478 and np.isfinite(found.y[-1]).all()
