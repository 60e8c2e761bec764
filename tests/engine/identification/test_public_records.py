"""Records that others measured: what is read, asked and found, beside least squares of our own. Sources: public/README.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from observer_lab.engine import EngineError
from observer_lab.engine.identification import Record, identify, read_record

PUBLIC = Path(__file__).parent / "public"
MARK = -200.0  # of a missing value in the air's record
CO, SENSOR = "CO(GT)", "PT08.S1(CO)"


def words(name: str) -> str:
    return (PUBLIC / name).read_text(encoding="utf-8")


def numbers(name: str, first: int = 0) -> np.ndarray:
    """The columns from `first` on, by a reader of our own."""
    mark = ";" if ";" in words(name) else ","
    rows = [line.split(mark)[first:] for line in words(name).splitlines()[1:]]
    return np.array([[float(cell.replace(",", ".")) for cell in row] for row in rows])


def regression(y: np.ndarray, u: np.ndarray, order: int, rows: int) -> tuple[np.ndarray, float]:
    """Poles of y_k = Σ a_i y_{k−i} + Σ b_j u_{k−j} + c by least squares of the first rows; rms error of the rest."""
    k = np.arange(order, len(y))
    columns = [y[k - i] for i in range(1, order + 1)] + [u[k - j, c] for j in range(order + 1) for c in range(u.shape[1])]
    table = np.column_stack([*columns, np.ones(len(k))])
    whole = np.isfinite(table).all(axis=1) & np.isfinite(y[k])
    early, late = whole & (k < rows), whole & (k >= rows)
    found = np.linalg.lstsq(table[early], y[k][early], rcond=None)[0]
    away = y[k][late] - table[late] @ found
    return np.roots(np.concatenate([[1.0], -found[:order]])), float(np.sqrt(np.mean(away**2)))


def test_two_heaters() -> None:
    """Poles and gains beside least squares of both temperatures over six rows, inputs at the dead time that was found."""
    record = read_record(words("tclab.csv"), inputs=("Q1", "Q2"), outputs=("T1", "T2"))
    assert (record.dt, record.rows, record.unit("T1"), record.unit("Q2")) == (5.0, 1020, "degC", "%")
    np.testing.assert_array_equal(np.column_stack([record.u, record.y]), numbers("tclab.csv", 1))
    found, stride, rows = identify(record), 6, record.rows // 2
    k = np.arange(20, rows - stride)
    given = np.array([record.u[i - found.delay:i - found.delay + stride].mean(axis=0) for i in k])
    both = np.linalg.lstsq(np.column_stack([record.y[k], given, np.ones(len(k))]), record.y[k + stride], rcond=None)[0]
    A, B = both[:2].T, both[2:4].T
    slow = np.sort(np.abs(np.linalg.eigvals(A))) ** (1 / stride)
    np.testing.assert_allclose(np.sort(np.abs(found.subspace.poles))[-2:], slow, atol=0.006)
    plant = found.fitted.plant
    gain = plant.C @ np.linalg.solve(np.eye(plant.n) - plant.A, plant.B) + plant.D
    np.testing.assert_allclose(gain, np.linalg.solve(np.eye(2) - A, B), atol=0.02)  # °C for 1 % of a heater
    assert 100 < -record.dt / np.log(np.abs(found.subspace.poles)).max() < 250  # s
    assert found.judged.fit.min() > 0.9 and found.judged.nis_holds and found.judged.evidence.stable


def test_a_flexible_robot_arm() -> None:
    """Two lightly damped resonances; the suggested order is also accepted, and nothing calls a noiseless sweep consistent in silence."""
    with pytest.raises(EngineError, match="No column is called t or time"):
        read_record(words("robot-arm.csv"), inputs=("torque",), outputs=("acceleration",))
    record = read_record(words("robot-arm.csv"), inputs=("torque",), outputs=("acceleration",), step=1)
    assert "The rows were counted: one for each 1 s." in record.notes and record.rows == 1024
    near, _ = regression(record.y[:, 0], record.u, 8, 512)
    sharp = near[(np.abs(near) > 0.99) & (near.imag > 0)]
    assert len(sharp) == 2
    for order in (4, 5, 6, None):
        found = identify(record, order=order)
        assert order is not None or len(found.subspace.A) == found.subspace.suggested == 7
        away = np.abs(sharp[:, None] - found.subspace.poles).min(axis=1)
        assert away.max() < 2e-3 and found.judged.fit[0] > 0.99, order
        assert found.judged.consistent == (not found.judged.evidence.failures)
        assert not found.judged.consistent and any("not white" in said for said in found.judged.evidence.failures)


def air(**given: object) -> Record:
    return read_record(words("air-quality.csv"), outputs=(CO,), step=3600, **given)  # type: ignore[arg-type]


def test_carbon_monoxide_with_gaps() -> None:
    """A mark that no list holds is asked about; gaps stay gaps; predictions are about as good as least squares with the same inputs."""
    table = numbers("air-quality.csv", 2)[:, :2]
    gaps = table == MARK
    assert gaps.sum(axis=0).tolist() == [467, 41]
    with pytest.raises(EngineError, match="CO holds -200 in 467 rows, the first is row 12"):
        air()
    with pytest.raises(EngineError, match="row 526; every input must be known"):
        air(inputs=(SENSOR,), missing=("-200",))
    record = air(inputs=(SENSOR,), missing=("-200",), hold=True)
    np.testing.assert_array_equal(np.isnan(record.y[:, 0]), gaps[:, 0])
    assert any("467" in note for note in record.notes) and any("held at its last value in 41 rows" in note for note in record.notes)
    found = identify(record)
    assert len(found.subspace.A) <= found.subspace.suggested
    table[gaps] = np.nan
    poles, error = regression(table[:, 0], record.u, 2, record.rows // 2)
    slow = float(np.abs(found.subspace.poles).max())
    assert slow == pytest.approx(np.abs(poles).max(), abs=3 * found.subspace.deviations[-1]) and slow < 1
    nu = found.judged.track.innovations[found.judged.first:, 0]
    assert np.isnan(nu).any() and np.sqrt(np.nanmean(nu**2)) < 1.1 * error


def test_outputs_without_any_input() -> None:
    record = read_record(words("air-quality.csv"), outputs=("T", "RH"), step=3600, missing=("-200",))
    assert record.u.shape == (2400, 0)
    found = identify(record, order=2)
    assert not found.judged.consistent and found.judged.fit.min() > 0.6
