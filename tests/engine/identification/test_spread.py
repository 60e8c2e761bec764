"""The spread of poles that simulated records give, beside the windows of the fit and the spread over seeds."""

from __future__ import annotations

import numpy as np
import pytest
from record_laws import PLANTS

from observer_lab.engine.identification import Record, identify, subspace
from observer_lab.engine.identification.spread import models_of, window_grams


@pytest.mark.parametrize("m, p", [(1, 1), (0, 1), (2, 3)])
def test_gram_matrices_are_those_of_the_windows(m: int, p: int) -> None:
    rng, horizon = np.random.default_rng(3), 4
    u, y = rng.standard_normal((300, m)), rng.standard_normal((300, p, 2))
    found = window_grams(u, y, horizon)
    for j in range(2):
        own = y[:, :, j]
        rows = np.hstack([windows(u, horizon, horizon), windows(own, 0, horizon), windows(u, 0, horizon), windows(own, horizon, horizon)])
        np.testing.assert_allclose(found[j], rows.T @ rows, atol=1e-9)


def windows(columns: np.ndarray, first: int, steps: int) -> np.ndarray:
    """Rows k + first … k + first + steps − 1 side by side, for every window of 2·steps rows."""
    count = len(columns) - 2 * steps + 1
    return np.hstack([columns[first + i:first + i + count] for i in range(steps)])


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.name)
def test_many_records_are_fitted_as_one_is(plant) -> None:
    n = len(plant.A)
    records = [plant.record(seed) for seed in range(3)]
    found = [subspace(record.u, record.y, order=n) for record in records]
    for record, its in zip(records, found, strict=True):
        size = np.sqrt((record.y**2).mean(axis=0))
        A = models_of(window_grams(record.u, (record.y / size)[:, :, None], its.horizon), its.horizon, record.u.shape[1], n)[0]
        np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(A)), its.poles, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("plant", [PLANTS[0], PLANTS[3]], ids=lambda plant: plant.name)
def test_the_stated_spread_is_that_over_seeds(plant) -> None:
    """By `python tests/engine/records_of_faults.py --whole` the share of poles in their 95 % bands over many more seeds."""
    true = np.sort_complex(np.linalg.eigvals(plant.sampled()[0]))
    found = [identify(plant.record(seed), order=len(true), delay=0).subspace for seed in range(30)]
    actual = np.mean([np.abs(its.poles - true) ** 2 for its in found], axis=0)
    np.testing.assert_allclose(np.mean([its.deviations**2 for its in found], axis=0), actual, rtol=0.6)


def test_a_record_from_an_unstable_plant_has_a_spread_too() -> None:
    rng = np.random.default_rng(0)
    x, y = 0.0, np.zeros(400)
    for k in range(400):
        y[k] = x + 0.1 * rng.standard_normal()
        x = 1.003 * x + 0.1 * rng.standard_normal()
    found = identify(Record(np.arange(400), np.zeros((400, 0)), y), order=1, share=0.5)
    assert np.isfinite(found.subspace.deviations).all() and (found.subspace.deviations > 0).all()
