"""Chapter 4 of the platform report: a filter with eight states watching ten, judged over many seeds."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy.signal import welch
from scipy.stats import binom, chi2

from observer_lab.engine import KalmanFilter, nis
from observer_lab.plants.platform import model
from observer_lab.plants.platform.lqg_weights import GROUND_UNIT, coils, ground
from observer_lab.published.platform_filter import ADC, DT, FORCE, RECORDS, SENSOR_SIGMA, SINE_HZ, innovation_over_R, record, tuned
from observer_lab.published.record import verify_one

SEEDS = range(10, 22)


def test_published_lines_of_chapter_four_hold():
    for line in RECORDS:
        assert verify_one(line).holds, line.item


def test_means_of_1000_nis_lie_in_their_band_as_often_as_they_should():
    """Twelve records of 20 blocks: 240 means against [3.827, 4.177], and 240 000 values against [0.484, 11.143]."""
    means, single = [], []
    for seed in SEEDS:
        r = record("white", 0.0, seed)
        values = nis(r.innovations, r.S).values
        single.append(values)
        means += [values[i:i + 1000].mean() for i in range(0, 20_000, 1000)]
    outside = sum(not 3.827 <= m <= 4.177 for m in means)
    assert binom.ppf(5e-4, len(means), 0.05) <= outside <= binom.ppf(1 - 5e-4, len(means), 0.05)
    every = np.concatenate(single)
    assert np.mean((every < 0.484) | (every > 11.143)) == pytest.approx(0.05, abs=0.003)
    assert abs(np.mean(every) - 4) < 4 * np.sqrt(8 / len(every))
    assert chi2.ppf([0.025, 0.975], 4000) / 1000 == pytest.approx([3.827, 4.177], abs=6e-4)


def test_the_right_filter_is_flagged_about_as_often_as_its_level_says():
    flagged = sum(bool(record("white", 0.0, seed).test.failures) for seed in SEEDS)
    assert flagged <= binom.ppf(1 - 1e-3, len(SEEDS), 0.05)


def test_the_two_states_cut_away_do_not_show():
    """S of the filter with eight states is that of one with ten, and so is the size of its innovations."""
    full = model.plant()
    ten = KalmanFilter.from_plant(coils(full), GROUND_UNIT * np.eye(2), SENSOR_SIGMA**2 * DT * np.eye(4), dt=DT, G=ground(full))
    S = {kf.n: kf.C @ kf.steady.solution @ kf.C.T + kf.R for kf in (ten, tuned())}
    assert np.allclose(S[8], S[10], rtol=1e-3, atol=1e-6 * S[10].max())


@pytest.mark.slow
def test_a_converter_taken_for_white_colours_the_innovations_and_carried_it_does_not():
    """Welch by scipy as the judge of the colours."""
    for noise, least, most in (("taken", 1.25, 1.7), ("carried", 0.85, 1.15)):
        found = []
        for seed in list(SEEDS)[:4]:
            f, density = welch(record(noise, 0.0, seed).innovations, 1 / DT, nperseg=4000, axis=0)
            found.append(density[(f > 0) & (f < 2)].mean() / density[f > 50].mean())
        assert least < np.mean(found) < most, noise
    assert "coloured" in record("taken").test.failures and not record("carried").test.failures
    assert ADC.density(0.2) > 5 * ADC.density(400.0)  # what the report expects to see in figure 9


def test_a_known_sine_is_in_the_output_and_not_in_its_error():
    for seed in list(SEEDS)[:3]:
        loud, quiet = record("white", FORCE, seed), record("white", 0.0, seed)
        errors = [r.clean - r.filtered for r in (loud, quiet)]
        assert np.abs(errors[0] - errors[1]).max() < 2e-3 * np.abs(errors[1]).max()  # the cut states' share of the force
        t = DT * np.arange(len(loud.clean))
        tone = np.exp(-2j * np.pi * SINE_HZ * t) * 2 / len(t)
        assert abs(tone @ loud.clean[:, 0]) > 1000 * abs(tone @ errors[0][:, 0])


def test_the_gain_is_python_controls_once_the_noise_is_of_size_one():
    """At R = 1e-12 python-control itself has lost four digits; the gain hangs on Q/R alone."""
    kf = tuned()
    scale = kf.R[0, 0]
    L, P, _ = control.dlqe(kf.A, np.eye(8), kf.C, kf.Q / scale, kf.R / scale)
    assert np.allclose(kf.A @ kf.steady.filter_gain, L, atol=1e-6 * np.abs(L).max())
    assert np.allclose(kf.steady.solution / scale, P, atol=1e-6 * np.abs(P).max())


def test_innovations_are_near_R_only_where_the_sensors_drown_the_ground():
    assert min(innovation_over_R(1e-18)) > 1e6 and max(innovation_over_R(1e-6)) < 1.003
    steps = [innovation_over_R(v)[0] for v in (1e-18, 1e-15, 1e-12, 1e-9, 1e-6)]
    assert steps == sorted(steps, reverse=True)
