"""The platform: published modes and Hankel values, energy, what its channels do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from observer_lab.plants import MODELS
from observer_lab.plants.platform import model

PUBLISHED_HANKEL = [572.7760, 572.7760, 360.3035, 360.2847, 43.0561, 43.0313, 0.053902, 0.053898, 8.85e-5, 8.85e-5]
PUBLISHED_MODES = [(0.995, 0.59), (1.193, 0.47), (1.494, 0.58), (30.21, 2.53), (30.32, 2.54)]


def modes(plant) -> list[tuple[float, float]]:
    """(Hz, damping in %) of the complex pairs, slowest first."""
    return sorted((abs(p) / (2 * math.pi), -100 * p.real / abs(p)) for p in plant.poles if p.imag > 0)


def test_platform_has_the_published_hankel_singular_values():
    p = model.plant()
    reach = solve_continuous_lyapunov(p.A, -p.B @ p.B.T)
    see = solve_continuous_lyapunov(p.A.T, -p.C.T @ p.C)
    values = np.sqrt(np.sort(np.abs(np.linalg.eigvals(reach @ see)))[::-1])
    np.testing.assert_allclose(values, PUBLISHED_HANKEL, rtol=2e-3)
    np.testing.assert_allclose(values[:6], PUBLISHED_HANKEL[:6], rtol=2e-6)


def test_platform_has_the_published_frequencies_and_dampings():
    np.testing.assert_allclose(modes(model.plant()), PUBLISHED_MODES, rtol=5e-3, atol=5e-3)


def test_platform_first_hankel_value_is_the_closed_form_of_its_vertical_mode():
    frequency, damping = modes(model.plant())[2]
    assert math.sqrt(2) * (2 * math.pi * frequency) / (4 * damping / 100) == pytest.approx(572.776, rel=1e-3)


def test_deck_keeps_the_three_slow_modes_of_the_platform():
    np.testing.assert_allclose(modes(model.deck()), modes(model.plant())[:3], rtol=5e-5)  # (ω/ω_p)² 2μ/m


def test_deck_is_the_limit_of_stiff_sensor_springs():
    p, d = model.plant(model.Parameters(kp=1.8e7, cp=480.0)), model.deck()
    s = 1j * 2 * math.pi * np.array([0.3, 1.1, 2.0, 5.0])
    for point in s:
        full = p.C @ np.linalg.solve(point * np.eye(10) - p.A, p.B)
        rigid_B = np.hstack([d.B, model.deck_disturbance()])
        reduced = d.C @ np.linalg.solve(point * np.eye(6) - d.A, rigid_B)
        np.testing.assert_allclose(full, reduced, rtol=1e-3, atol=1e-6 * np.abs(reduced).max())


def test_platform_outputs_are_in_the_order_VL_HL_VR_HR():
    k, p, d = model.Parameters(), model.plant(), model.deck()
    rates = np.array([0.3, -0.2, 0.7])  # of x, z and θ
    expected = [-0.2 - k.s * 0.7, 0.3 + k.h * 0.7, -0.2 + k.s * 0.7, -(0.3 + k.h * 0.7)]
    np.testing.assert_allclose(d.C @ [0, 0, 0, *rates], expected)
    np.testing.assert_allclose(p.C @ [0, 0, 0, 0, 0, *rates, 0, 0], expected)
    assert p.output_names == d.output_names == ("VL", "HL", "VR", "HR")


def test_platform_loses_energy_only_in_its_dampers():
    mech, p = model.mechanics(), model.plant()
    rng = np.random.default_rng(1)
    for x in rng.normal(size=(5, 10)) * 1e-3:
        q, v = x[:5], x[5:]
        xdot = p.A @ x
        power = v @ mech.M @ xdot[5:] + q @ mech.K @ xdot[:5]
        np.testing.assert_allclose(power, -v @ mech.D @ v, rtol=1e-9, atol=1e-18)


def test_platform_potential_energy_is_the_sum_over_its_springs():
    k, K = model.Parameters(), model.mechanics().K
    x, z, angle, left, right = q = np.random.default_rng(2).normal(size=5)
    stretched = (k.kz * (z - k.a * angle) ** 2 + k.kz * (z + k.a * angle) ** 2 + k.kx * (x + k.h * angle) ** 2
                 + k.kp * (z - k.s * angle - left) ** 2 + k.kp * (z + k.s * angle - right) ** 2)
    assert q @ K @ q == pytest.approx(stretched, rel=1e-12)


def test_ground_motion_carries_the_deck_with_it():
    p = model.plant()
    settled = np.linalg.solve(-p.A, p.B[:, 3:])
    np.testing.assert_allclose(settled[:, 0], [0, 1, 0, 1, 1, 0, 0, 0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(settled[0, 1] + model.Parameters().h * settled[2, 1], 1, rtol=1e-9)


def test_platform_controller_drives_the_coils_and_not_the_ground():
    m = MODELS["platform"]
    assert m.controlled.input_names == ("u1", "u2", "u3")
    disturbed = m.disturbed
    assert disturbed is not None
    np.testing.assert_array_equal(np.hstack([m.controlled.B, disturbed]), m.plant.B)
    assert MODELS["deck"].controlled is MODELS["deck"].plant and MODELS["deck"].disturbed is None
