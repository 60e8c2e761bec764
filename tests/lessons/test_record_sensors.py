"""Lesson 21: a faulty sensor behind a gate, and a second sensor with another clock."""

from __future__ import annotations

import runpy
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from observer_lab.cli.entry import main
from observer_lab.engine import KalmanFilter
from observer_lab.engine.identification import Record, read_record
from observer_lab.lessons import LESSONS
from observer_lab.lessons.record.data import record_of
from observer_lab.lessons.record.estimates import estimates
from observer_lab.lessons.record.fusion import BEFORE, DELAY, EVERY, SHOWN, fused
from observer_lab.lessons.record.own import with_record

LESSON = LESSONS["record"]
COLUMNS = "t=t[s] u=u y=a,b"


def outcome(**changes: object):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def test_a_gate_sets_the_jumps_aside_and_lets_the_bias_pass() -> None:
    given = record_of("faulty", 1)
    plain, gated, sound = outcome(data="faulty"), outcome(data="faulty", gate="0.999"), outcome()
    aside = gated.study.judged.set_aside
    jumped = np.abs(given.jumps[:, 0]) > 0
    assert jumped.sum() >= 5 and aside[jumped].all() and not aside[~jumped].any()
    assert plain.metrics["mean_nis"] > plain.metrics["nis_high"] and gated.metrics["mean_nis"] < gated.metrics["nis_high"]
    assert f"The gate set {aside.sum()} of 800 rows aside" in gated.live("en")
    away = (gated.study.estimate(False) - gated.study.clean)[:, 0]
    right = (sound.study.estimate(False) - sound.study.clean)[:, 0]
    biased = given.bias[gated.study.first:, 0] > 0
    assert np.abs(away - right)[~biased].max() < 0.07 and np.mean((away - right)[biased]) > 0.5 * given.bias.max()
    assert gated.metrics["white_p"] < 1e-3 < plain.metrics["white_p"]


def test_exports_mark_the_rows_that_a_gate_set_aside_as_missing() -> None:
    gated = outcome(data="faulty", gate="0.999")
    aside = gated.study.judged.set_aside
    names, rows = estimates(gated)
    table = np.array(rows)
    np.testing.assert_array_equal(np.isnan(table[:, names.index("y")]), aside)
    assert np.isfinite(np.delete(table, names.index("y"), axis=1)).all()
    assert LESSON.code is not None and LESSON.device is not None
    written = {value.name: value.value for value in LESSON.code(gated).given}
    np.testing.assert_array_equal(written["y"], gated.study.found.record.y)  # a script and a device have the gate themselves
    design = LESSON.device(gated)
    assert design.gap() < 1e-9
    np.testing.assert_array_equal(np.diff(design.expected()["rejected"][:, 0], prepend=0.0) > 0, aside)


@pytest.mark.parametrize("second", ["slow", "late"])
def test_the_spread_with_two_sensors_is_that_of_all_readings_at_once(second: str) -> None:
    """Beside the conditional variance of one Gaussian vector of all outputs and readings, without a filter."""
    study = outcome(second=second).study
    kf, P = study.found.fitted.kalman(), study.judged.track.schedule.prior[-1]
    found, count = fused(kf, P, second), BEFORE + SHOWN
    n = kf.n
    G = np.zeros((count, n, (count + 1) * n))  # x_k = G_k (x_0, w_0, w_1, …)
    G[0, :, :n] = np.eye(n)
    for k in range(1, count):
        G[k] = kf.A @ G[k - 1]
        G[k, :, k * n:(k + 1) * n] += np.eye(n)
    source = np.zeros(((count + 1) * n, (count + 1) * n))
    source[:n, :n] = P
    for k in range(1, count + 1):
        source[k * n:(k + 1) * n, k * n:(k + 1) * n] = kf.Q
    z = np.einsum("i,kij->kj", kf.C[0], G)
    cov, late = z @ source @ z.T, DELAY if second == "late" else 0
    for k in (BEFORE, BEFORE + EVERY, BEFORE + EVERY + 3, BEFORE + EVERY + DELAY, count - 1):
        rows = np.arange(k + 1)
        arrives = [j for j in rows - BEFORE if (j + late) > 0 and j % EVERY == 0 and j + late <= k - BEFORE]
        at = np.concatenate([rows, np.array(arrives, dtype=int) + BEFORE])
        noise = np.diag([kf.R[0, 0]] * len(rows) + [found.exact**2] * len(arrives))
        left = cov[k, k] - cov[k, at] @ np.linalg.solve(cov[np.ix_(at, at)] + noise, cov[at, k])
        assert found.both[k - BEFORE] == pytest.approx(np.sqrt(left), rel=1e-4)


def test_an_exact_reading_gains_much_at_once_and_little_when_it_is_late() -> None:
    now, late = outcome(second="slow").metrics, outcome(second="late").metrics
    assert now["sigma_least"] < 0.25 * now["sigma"] and now["sigma_most"] > 0.95 * now["sigma"]
    assert late["sigma_least"] > 0.9 * late["sigma"]


def two_outputs() -> Record:
    """The spring's position and velocity, each reading missing by chance in a tenth of the rows."""
    given, rng = record_of("spring", 3), np.random.default_rng(3)
    truth, record = given.truth, given.record
    x, rows = np.zeros(2), []
    for now in record.u:
        rows.append(x)
        x = truth.plant.A @ x + truth.plant.B @ (now + truth.q * rng.standard_normal(1))
    y = np.array(rows) + (0.05, 0.1) * rng.standard_normal((record.rows, 2))
    y[rng.random(y.shape) < 0.1] = np.nan
    return Record(record.t, record.u, y, ("u",), ("a", "b"))


def csv_of(record: Record) -> str:
    rows = zip(record.t, record.u[:, 0], *record.y.T, strict=True)
    return "t [s],u,a,b\n" + "".join(f"{t:.3f},{u}," + ",".join("" if np.isnan(v) else f"{v:.9f}" for v in read) + "\n"
                                      for t, u, *read in rows)


def by_hand(kf: KalmanFilter, P: np.ndarray, u: np.ndarray, y: np.ndarray) -> np.ndarray:
    """States of a filter from zero with P: at each row the rows of C and R whose reading is missing are deleted."""
    x, found = np.zeros(kf.n), []
    for now, read in zip(u, y, strict=True):
        lost = np.flatnonzero(np.isnan(read))
        C, D, z = (np.delete(M, lost, axis=0) for M in (kf.C, kf.D, read))
        R = np.delete(np.delete(kf.R, lost, axis=0), lost, axis=1)
        M = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
        x, P = x + M @ (z - C @ x - D @ now), P - M @ C @ P
        found.append(x)
        x, P = kf.A @ x + kf.B @ now, kf.A @ P @ kf.A.T + kf.Q
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("gate", ["off", "0.99"])
def test_rows_with_a_part_of_their_outputs_are_used_in_page_fit_and_exports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                                             gate: str) -> None:
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    (tmp_path / "mine.csv").write_text(csv_of(two_outputs()), encoding="utf-8")
    for to, name in (("python", "own.py"), ("matlab", "own.m")):
        assert main(["export", "record", "--data", str(tmp_path / "mine.csv"), "--columns", COLUMNS, "--set", f"gate={gate}",
                     "--to", to, "-o", str(tmp_path / name)]) == 0
    record = read_record(csv_of(two_outputs()), time="t", inputs=("u",), outputs=("a", "b"))
    own = with_record(LESSON, record)
    found = own.compute(own.apply(own.start(), {"gate": gate}))
    study, used = found.study, found.study.used
    read = np.isfinite(study.found.record.y)
    assert 0.15 < (read.any(axis=1) & ~read.all(axis=1)).mean() < 0.25 and study.found.fitted.rows > 0.85 * study.first
    states = by_hand(study.found.fitted.kalman(), study.judged.track.schedule.prior[0], study.found.record.u, used)
    np.testing.assert_allclose(study.judged.track.means, states, atol=1e-9 * np.abs(states).max())
    names = runpy.run_path(str(tmp_path / "own.py"))
    means, _, _, aside = names["estimate"](record.t, record.u, record.y)
    np.testing.assert_array_equal(aside, study.judged.set_aside)
    assert aside.any() == (gate != "off")
    np.testing.assert_allclose(means, study.judged.track.means, rtol=0, atol=1e-11 * np.abs(means).max())
    design = own.device(found)
    assert design.gap() < 1e-9
    if shutil.which("octave-cli"):
        done = subprocess.run(["octave-cli", "--quiet", "--no-init-file", "--eval", "own(false)"], cwd=tmp_path, capture_output=True,
                              text=True)
        assert done.stdout.count("agree to 1e-06") == 1, done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize("data", ["faulty", "furnace"])
def test_a_script_has_the_gate_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: str) -> None:
    """From the measured rows it sets the same ones aside, and its states are those of the page to the last bit."""
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    file = tmp_path / "gated.py"
    assert main(["export", "record", "--set", f"data={data}", "--set", "gate=0.999", "--to", "python", "-o", str(file)]) == 0
    names, record = runpy.run_path(str(file)), record_of(data, 1).record
    judged = outcome(data=data, gate="0.999").study.judged
    means, _, _, aside = names["estimate"](record.t, record.u, record.y)
    np.testing.assert_array_equal(aside, judged.set_aside)
    assert aside.any()
    np.testing.assert_array_equal(means, judged.track.means)


def test_a_bias_becomes_a_state_where_the_data_say_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Behind the gate the estimate no longer follows the bias of the faulty sensor; a sound one gets no state; the script has it too."""
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    chosen = {"data": "faulty", "gate": "0.999"}
    plain, biased, sound = outcome(**chosen), outcome(**chosen, bias="data"), outcome(bias="data")
    assert sound.study.found.bias.kind == "none" and "No sensor needs a bias" in sound.live("en")
    np.testing.assert_array_equal(sound.study.judged.track.means, outcome().study.judged.track.means)
    found = biased.study.found.bias
    assert found.kind == "drift" and found.gain > 2 * found.cost and "has a bias that drifts" in biased.live("en")
    assert found.value == pytest.approx(0.1, abs=3 * found.deviation) and found.deviation < 0.05
    late = slice(-80, None)
    away = [(o.study.estimate(False) - o.study.clean)[late, 0].mean() for o in (plain, biased)]
    assert abs(away[1]) < 0.5 * abs(away[0])
    assert biased.metrics["white_p"] > plain.metrics["white_p"] and biased.study.judged.evidence.stable
    file = tmp_path / "biased.py"
    assert main(["export", "record", *(word for name, value in {**chosen, "bias": "data"}.items() for word in ("--set", f"{name}={value}")),
                 "--to", "python", "-o", str(file)]) == 0
    names, record = runpy.run_path(str(file)), record_of("faulty", 1).record
    means, outputs, _, aside = names["estimate"](record.t, record.u, record.y)
    np.testing.assert_array_equal(means, biased.study.judged.track.means)
    np.testing.assert_array_equal(aside, biased.study.judged.set_aside)
    np.testing.assert_allclose(outputs[biased.study.first:], biased.study.estimate(False), atol=1e-12)
    assert LESSON.device(biased).gap() < 1e-9
