"""Spectra are calibrated, and responses agree with closed forms and with control."""

import control
import numpy as np
import pytest

from observer_lab.engine import EngineError, ShapeError, frequency_response, psd
from observer_lab.engine.systems import amplitude_response
from observer_lab.engine.systems.spectrum import modal_coordinates

RNG = np.random.default_rng(1)


def test_white_noise_lies_at_two_sigma_squared_over_fs() -> None:
    spectrum = psd(3.0 * RNG.standard_normal(200_000), 50.0, segment=256)
    assert np.mean(spectrum.density[2:-2]) == pytest.approx(2 * 9 / 50, rel=0.02)
    assert spectrum.frequency[-1] == 25.0


def test_area_is_the_variance() -> None:
    t = np.arange(4096) / 64
    sine = 5 * np.sin(2 * np.pi * 4 * t) + 100
    assert psd(sine, 64.0).variance() == pytest.approx(12.5, rel=1e-3)  # a²/2, the mean removed
    noise = RNG.standard_normal((100_000, 2)) * [1.0, 1e-6]
    assert np.allclose(psd(noise, 10.0).variance(), np.var(noise, axis=0), rtol=0.02)
    assert psd(noise[:, 0], 10.0, segment=100_000, window="boxcar").variance() == pytest.approx(np.var(noise[:, 0]))


def test_decibels_are_ten_logarithms_and_zero_is_not_minus_infinity() -> None:
    spectrum = psd(np.r_[np.zeros(512)], 1.0)
    assert np.isfinite(spectrum.decibel).all()


@pytest.mark.parametrize("series, more", [([1.0] * 7, {}), ([np.nan] * 20, {}), (np.zeros((9, 2, 2)), {}),
                                          (np.zeros(20), {"fs": 0.0}), (np.zeros(20), {"segment": 21})])
def test_hopeless_series_are_refused(series: object, more: dict) -> None:
    with pytest.raises(EngineError):
        psd(series, **{"fs": 1.0, **more})


def test_response_agrees_with_control() -> None:
    n, p, m = 6, 3, 2
    A = RNG.standard_normal((n, n)) - 4 * np.eye(n)
    B, C, D = RNG.standard_normal((n, m)), RNG.standard_normal((p, n)), RNG.standard_normal((p, m))
    omega = np.logspace(-2, 3, 50)
    peer = control.ss(A, B, C, D)(1j * omega)
    assert np.allclose(frequency_response(A, B, C, D, omega), np.moveaxis(peer, -1, 0), atol=1e-11)
    sampled = control.ss(A / 20, B, C, D, 0.1)(np.exp(0.1j * omega[:30]))
    assert np.allclose(frequency_response(A / 20, B, C, D, omega[:30], dt=0.1), np.moveaxis(sampled, -1, 0), atol=1e-11)


def test_defective_matrix_falls_back_to_solving() -> None:
    A = -np.eye(4) + np.diag(np.ones(3), 1)
    omega = np.array([0.0, 0.5, 3.0])
    gain = amplitude_response(A, [[0], [0], [0], [1]], [[1, 0, 0, 0]], [[0]], omega)
    assert np.allclose(gain[:, 0, 0], (1 + omega**2) ** -2.0, rtol=1e-12)


def test_modes_are_kept_by_what_a_matrix_holds() -> None:
    """A matrix that is changed in place has a response of its own; what is kept cannot be written."""
    A, B, C = np.diag([-1.0, -2.0]), np.ones((2, 1)), np.ones((1, 2))
    first = frequency_response(A, B, C, [[0]], [0.0])
    A[0, 0] = -4.0
    assert first[0, 0, 0] == pytest.approx(1.5) and frequency_response(A, B, C, [[0]], [0.0])[0, 0, 0] == pytest.approx(0.75)
    assert not any(part.flags.writeable for part in modal_coordinates(A, B, C) or ())


@pytest.mark.parametrize("A", [[[0, 1], [-4, 0]], [[0, 1, 0, 0], [-4, 0, 1, 0], [0, 0, 0, 1], [0, 0, -4, 0]]])
def test_response_on_a_pole_is_large_not_an_exception(A: list) -> None:
    n = len(A)
    gain = amplitude_response(A, np.eye(n)[:, -1:], np.eye(n)[:1], [[0]], [1.0, 2.0])
    assert gain[0, 0, 0] < 1.0
    assert not gain[1, 0, 0] < 1e6


def test_matrices_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ShapeError):
        frequency_response(np.eye(2), [[1]], [[1, 0]], [[0]], [1.0])
