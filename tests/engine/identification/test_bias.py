"""A sensor's bias as a state: found where there is one, refused where it is not observable."""

from __future__ import annotations

import numpy as np
import pytest
from record_laws import PLANTS

from observer_lab.engine import EngineError, Plant
from observer_lab.engine.identification import FittedFilter, Record, RecordFit, filter_record, identify, sensor_bias, trend_of
from observer_lab.engine.identification.known_plant import filter_plant


def fit(plant: Plant, record: Record) -> RecordFit:
    """The filter of a plant whose noises are known too, on a record without a level."""
    found = filter_plant(plant, record, robust=False, delay=0)
    return found


def two(a: float, rows: int = 600, seed: int = 0) -> tuple[Plant, Record]:
    """Two states, each with a sensor of its own, the first pole at a."""
    plant = Plant([[a, 0.1], [0, 0.6]], [[0.0], [1.0]], [[1, 0], [0, 1]], None, 1.0)
    rng, x, rows_y = np.random.default_rng(seed), np.zeros(2), []
    u = np.repeat(rng.choice([-1.0, 1.0], rows // 5), 5)[:, None]
    for now in u:
        rows_y.append(x)
        x = plant.A @ x + plant.B @ now + (0.05, 0.1) * rng.standard_normal(2)
    return plant, Record(np.arange(rows), u, np.array(rows_y) + 0.1 * rng.standard_normal((rows, 2)))


@pytest.mark.slow
@pytest.mark.parametrize("plant", [PLANTS[0], PLANTS[3]], ids=lambda plant: plant.name)
def test_a_sound_sensor_gets_no_state_and_a_biased_one_does(plant) -> None:
    for seed in range(3):
        record = plant.record(seed)
        half, rng = record.rows // 2, np.random.default_rng(seed)
        for kind in ("sound", "jump", "walk"):
            y = np.array(record.y)
            if kind == "jump":
                y[half + half // 2:, -1] += 3 * plant.r
            elif kind == "walk":
                y[:, -1] += np.cumsum(0.2 * plant.r * rng.standard_normal(len(y)))
            found = identify(Record(record.t, record.u, y), order=2, robust=False, degree=0, delay=0)
            biased = sensor_bias(found)
            assert (biased.bias.kind == "none") == (kind == "sound"), (kind, biased.bias)
            if kind != "sound":
                assert biased.bias.output == plant.sampled()[2].shape[0] - 1 and biased.fitted.plant.n == 3
                assert biased.judged.mean_nis < found.judged.mean_nis
            else:
                assert biased.fitted is found.fitted and biased.judged is found.judged


def test_the_bias_is_that_of_least_squares_over_all_rows() -> None:
    """A constant bias of a plant whose numbers are known: the last estimate is the generalised least-squares one of the whole record."""
    plant, record = two(0.9, 200)
    y = np.array(record.y)
    y[:, 0] += 0.5
    given = fit(plant, Record(record.t, record.u, y))
    found = sensor_bias(given, kind="constant")
    flat, kf = found.record, found.fitted.kalman()
    P = found.judged.track.schedule.prior[0]
    n, count = kf.n, flat.rows
    size = n * count
    T = np.eye(size) - np.kron(np.eye(count, k=-1), kf.A)  # T x = (x₀, w₀ + B u₀, …)
    weights = [np.linalg.inv(kf.Q + 1e-12 * np.eye(n))] * (count - 1)
    W = np.zeros((size, size))
    for k, block in enumerate([np.linalg.inv(P), *weights]):
        W[k * n:(k + 1) * n, k * n:(k + 1) * n] = block
    drive = np.concatenate([np.zeros(n), *(kf.B @ now for now in flat.u[:-1])])
    H, Ri = np.kron(np.eye(count), kf.C), np.kron(np.eye(count), np.linalg.inv(kf.R))
    x = np.linalg.solve(T.T @ W @ T + H.T @ Ri @ H, T.T @ W @ drive + H.T @ Ri @ flat.y.ravel())
    assert found.bias.kind == "constant" and x[-1] == pytest.approx(found.bias.value, abs=0.02 * found.bias.deviation + 1e-6)


def test_a_bias_that_is_not_observable_is_refused() -> None:
    """An integrator that its only sensor reads; with a second sensor, or behind it, the bias is seen."""
    plant, record = two(1.0)
    alone = Plant(plant.A, plant.B, [[1, 0]], None, 1.0)
    found = fit(alone, Record(record.t, record.u, record.y[:, 0]))
    with pytest.raises(EngineError, match="and the plant's pole 1 give the same readings: the rank is 2, and 3 is needed"):
        sensor_bias(found, kind="constant")
    kept = sensor_bias(found)
    assert kept.bias.kind == "none" and "give the same readings" in kept.bias.said and kept.fitted is found.fitted
    twice = Plant(plant.A, plant.B, [[1, 0], [1, 0]], None, 1.0)
    both = fit(twice, Record(record.t, record.u, np.column_stack([record.y[:, 0], record.y[:, 0] + 0.1 * record.y[::-1, 1]])))
    assert sensor_bias(both, kind="drift").bias.kind == "drift"
    stable = fit(Plant([[0.9]], [[0.1]], [[1]], None, 1.0), Record(record.t, record.u, record.y[:, 0]))
    assert sensor_bias(stable, kind="constant").bias.kind == "constant"


def test_a_fitted_pole_that_may_be_an_integrator_hides_the_bias() -> None:
    rng = np.random.default_rng(3)
    walk = np.cumsum(rng.standard_normal(600))
    found = identify(Record(np.arange(600), np.zeros((600, 0)), walk + 0.3 * rng.standard_normal(600)), order=1, robust=False, degree=0)
    assert abs(found.subspace.poles[0] - 1) < 2 * found.subspace.deviations[0]
    assert "give the same readings" in sensor_bias(found).bias.said


def test_the_bias_is_in_no_output_of_the_plant() -> None:
    plant, record = two(0.8)
    found = sensor_bias(fit(plant, record), kind="constant")
    assert isinstance(found.fitted, FittedFilter) and found.fitted.biases == 1
    np.testing.assert_array_equal(found.fitted.outputs[:, :2], plant.C)
    np.testing.assert_array_equal(found.fitted.outputs[:, 2], 0)
    assert np.asarray(found.fitted.plant.C)[:, 2].sum() == 1 and trend_of(record).y_level.shape == (2,)
    again = filter_record(found.fitted, found.record, found.judged.first)
    np.testing.assert_array_equal(again.track.means, found.judged.track.means)
