"""Beside the report: levels, leads, its two values of V; and the transmissibility, which needs no noise."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from witnesses_of_effort import moved

from observer_lab.course.lesson import Outcome
from observer_lab.engine import noisy_loop
from observer_lab.lessons.showdown.controllers import DECOUPLED, LQE, ORDER, RECURSIVE, SISO, decoupled, full, siso_pair
from observer_lab.lessons.showdown.lesson import LESSON
from observer_lab.lessons.showdown.report_levels import LEADS, LEVELS, above, lead, lowered, peak, said_of_figure_24
from observer_lab.lessons.showdown.suppression import LAST_HZ, transmissibility
from observer_lab.plants.platform import model
from observer_lab.plants.platform.channels import T_y
from observer_lab.plants.platform.lqg_weights import coils, ground


@lru_cache(maxsize=16)
def _outcome(changes: tuple[tuple[str, Any], ...]) -> Outcome:
    return LESSON.compute(LESSON.apply(LESSON.start(), dict(changes)))


def outcome(**changes: Any) -> Outcome:
    return _outcome(tuple(changes.items()))


def table(found: Outcome, id: str) -> list[list[str]]:
    figure = next(f for f in LESSON.figures(found) if f.id == id)
    return [[cell if isinstance(cell, str) else cell("en") for cell in row] for row in figure.rows]  # type: ignore[union-attr]


# --- levels and leads --------------------------------------------------------------------------------------------------
def test_the_peaks_without_control_are_those_of_the_ground_through_a_resonance() -> None:
    """At ω_z the springs multiply the ground by k/(c ω), and velocity is ω times that; ground of 2e-12 m²/Hz, one-sided."""
    k = model.Parameters()
    stiffness, damping, mass = 2 * k.kz, 2 * k.cz, k.m + 2 * k.mu
    omega = np.sqrt(stiffness / mass)
    white = 2e-12 * (stiffness / damping) ** 2
    assert peak(outcome().study, "open", (3,)) == pytest.approx(white, rel=0.03)
    falling = (2.5e-7 / (omega / 2 / np.pi) ** 2 * stiffness / damping) ** 2
    assert peak(outcome(ground="shaped").study, "open", (3,)) == pytest.approx(falling, rel=0.03)


@pytest.mark.parametrize("changes", [{}, {"v": 1e-9}, {"ground": "shaped", "sensor": 1e-12}])
def test_the_leads_are_those_of_each_loop_written_as_one_matrix(changes: dict[str, Any]) -> None:
    found = outcome(**changes)
    m, d = found.study, found.design
    bands = {id: moved(m.world, id, 1.0, d["v"], d["pair"]) for id in ORDER}
    for one in LEADS:
        if one.column < 3:
            ours = 20 * np.log10(bands[one.beside].band[one.column] / bands[one.player].band[one.column])  # type: ignore[union-attr]
            assert lead(m, one) == pytest.approx(ours, abs=0.1), one


def test_figure_24_has_the_order_and_not_the_size() -> None:
    m = outcome().study
    rotation = next(one for one in LEADS if one.figure == 24)
    assert lead(m, rotation) == pytest.approx(3.6, abs=0.05) and rotation.low == 30.0
    assert "leads the SISO loops by 3.6 dB, in the report by 30 dB" in said_of_figure_24(m)("en")
    assert "does not come out" in said_of_figure_24(outcome(sensor=1e-14).study)("en")
    assert "Not all loops" in said_of_figure_24(outcome(pair="published").study)("en")


def test_a_level_is_compared_with_the_nearest_that_is_printed() -> None:
    assert above(1e-9, 1e-12, 1e-10) == pytest.approx(10) and above(1e-11, 1e-12, 1e-10) == 0
    assert above(1e-15, 1e-12, 1e-10) == pytest.approx(-30)
    rows = table(outcome(), "report_levels")
    assert len(rows) == len(LEVELS) and [row[0] for row in rows] == ["14", "14", "19", "20", "21", "23", "24", "24"]
    assert rows[0][3:] == ["10⁻¹⁰", "1.3·10⁻⁶", "+41"]
    assert [row[-1] for row in table(outcome(pair="published"), "report_levels") if row[2] == "SISO"] == ["–"]


def test_the_report_calls_two_loops_equal_whose_levels_differ() -> None:
    """Figure 14: 1e-12 to 1e-13 with LQE; figure 19: 1e-15 to 1e-17 with the recursive filter; here the two coincide."""
    steady, recursive = (next(one for one in LEVELS if one.player == id and 3 in one.columns) for id in (LQE, RECURSIVE))
    assert steady.low / recursive.high == pytest.approx(100)
    m = outcome().study
    ours = [peak(m, id, (3,)) for id in (LQE, RECURSIVE)]
    assert ours[0] == pytest.approx(ours[1], rel=0.02)


def test_the_two_values_of_v_are_far_apart() -> None:
    """With sensors that do not count, as found in fifty digits: 31.2, 11.0, 27.2 dB and 3.6, 0.0, 1.8 dB."""
    quiet = outcome(sensor=1e-18)
    assert lowered(quiet.study, 1e-9) == pytest.approx([31.2, 11.0, 27.2], abs=0.15)
    assert lowered(quiet.study, 1e-6) == pytest.approx([3.6, 0.0, 1.8], abs=0.1)
    assert lowered(quiet.study, 1e-18) is None
    rows = table(outcome(), "report_noise")
    assert [row[0] for row in rows] == ["10⁻⁶", "10⁻⁹", "10⁻¹⁸", "1.0·10⁻¹⁰"] and rows[2][2:] == ["unstable"] * 3
    assert [float(cell) for cell in rows[3][2:]] == pytest.approx(outcome().study.peak_db[ORDER.index(LQE)], abs=0.06)


# --- transmissibility --------------------------------------------------------------------------------------------------
def test_without_control_it_is_that_of_a_mass_on_springs() -> None:
    m, k = outcome(ground="shaped", sensor=1e-9).study, model.Parameters()
    f = m.f[m.f <= LAST_HZ]
    omega, away = 2 * np.pi * f, (f < 5) & (np.abs(f - 1.494) > 0.02)
    expected = np.abs(2 * k.kz / (2 * k.kz - (k.m + 2 * k.mu) * omega**2 + 2j * k.cz * omega))
    found = transmissibility(m, 0)
    assert found is not None
    np.testing.assert_allclose(found[away, 0], expected[away], rtol=0.02)


@pytest.mark.parametrize("player", [SISO, LQE, DECOUPLED])
def test_a_sampled_loop_passes_as_much_of_the_ground_on_as_its_continuous_model(player: str) -> None:
    """From each ground motion to its own channel by the transfer function of the continuous loop, up to 10 Hz."""
    m = outcome().study
    controller = {SISO: siso_pair("own"), LQE: full(1e-10), DECOUPLED: decoupled(1e-10)}[player]
    plant = model.plant()
    loop = noisy_loop(coils(plant), controller, ground(plant), 1.0)
    f = m.f[m.f <= LAST_HZ]
    low = f <= 10
    H = np.abs(loop.response(f[low], loop.outputs(T_y[[0, 2]])))
    continuous = H[:, [0, 1], [0, 1]] / (2 * np.pi * f[low, None])
    found = transmissibility(m, ORDER.index(player))
    assert found is not None
    np.testing.assert_allclose(found[low], continuous, rtol=0.03)


def test_noise_limits_and_rounding_do_not_enter_it_and_an_unstable_loop_has_none() -> None:
    one, two = (transmissibility(outcome(**c).study, 2) for c in ({}, {"sensor": 1e-8, "limited": True, "adc": 500.0, "drift": 3.0}))
    assert one is not None and two is not None
    np.testing.assert_allclose([one.max(), np.median(one)], [two.max(), np.median(two)], rtol=0.02)
    assert transmissibility(outcome(pair="published").study, 1) is None


def test_what_the_step_says_of_the_largest() -> None:
    largest = [transmissibility(outcome().study, i) for i in (0, ORDER.index(LQE), ORDER.index(SISO))]
    assert [float(T[:, 0].max()) for T in largest if T is not None] == pytest.approx([86.3, 1.01, 0.274], rel=0.01)
    drawn = next(f for f in LESSON.figures(outcome()) if f.id == "transmissibility_vertical")
    assert drawn.caption("en").startswith("Largest: none 86.3, SISO 0.274, LQE 1.01")
