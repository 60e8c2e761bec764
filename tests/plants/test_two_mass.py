"""The two-mass chain: energy, and motions that are hidden by design."""

from __future__ import annotations

import numpy as np
import pytest
from plant_models import pbh_moved, pbh_seen
from scipy.linalg import expm

from observer_lab.engine import EngineError, observer_gain, place
from observer_lab.plants import cart_pendulum as cart
from observer_lab.plants import two_mass
from observer_lab.plants.two_mass import HIDDEN, Parameters, hidden


def test_chain_loses_energy_only_in_its_dampers():
    k = Parameters(m1=1.5, m2=0.7, left=3.0, between=5.0, right=2.0, left_damping=0.2, between_damping=0.4,
                   right_damping=0.1)
    p = two_mass.plant(k)
    for q1, q2, v1, v2 in np.random.default_rng(5).normal(size=(5, 4)):
        a = p.A @ [q1, q2, v1, v2]
        power = (k.m1 * v1 * a[2] + k.m2 * v2 * a[3]
                 + k.left * q1 * v1 + k.right * q2 * v2 + k.between * (q2 - q1) * (v2 - v1))
        lost = k.left_damping * v1**2 + k.right_damping * v2**2 + k.between_damping * (v2 - v1) ** 2
        assert power == pytest.approx(-lost, rel=1e-10)


def test_default_chain_is_seen_and_moved_as_a_whole():
    p = two_mass.plant()
    assert all(pbh_seen(p, pole) and pbh_moved(p, pole) for pole in p.poles)


@pytest.mark.parametrize("h", HIDDEN.values(), ids=lambda h: h.case)
def test_hidden_motion_is_hidden_by_pbh_and_nothing_else_is(h):
    p = h.model.plant
    lost = [pole for pole in p.poles if not (pbh_seen if h.unseen else pbh_moved)(p, pole)]
    np.testing.assert_allclose(lost, h.poles, atol=1e-12)
    assert all((pbh_moved if h.unseen else pbh_seen)(p, pole) for pole in p.poles)
    assert h.stable == (max(pole.real for pole in h.poles) < 0)
    wanted = h.model.observer_poles if h.unseen else h.model.controller_poles
    assert set(h.poles) <= set(wanted)


@pytest.mark.parametrize("h", HIDDEN.values(), ids=lambda h: h.case)
def test_hidden_motion_leaves_no_trace_and_takes_no_push(h):
    p, start = h.model.plant, np.array(h.direction)
    for t in (0.5, 2.0, 5.0):
        moved = expm(p.A * t)
        if h.unseen:
            assert np.abs(p.C @ moved @ start).max() < 1e-10
        else:  # the force changes neither the common position nor the common velocity
            assert np.abs(np.array([[1, 1, 0, 0], [0, 0, 1, 1]]) @ moved @ p.B).max() < 1e-10


@pytest.mark.parametrize("h", HIDDEN.values(), ids=lambda h: h.case)
def test_hidden_motion_decides_the_fate_of_the_run_from_the_model_start(h):
    m, p = h.model, h.model.plant
    if h.unseen:
        fate, start = p.A - observer_gain(p.A, p.C, m.observer_poles).gain @ p.C, np.subtract(m.x0, m.guess)
    else:
        fate, start = p.A - p.B @ place(p.A, p.B, m.controller_poles).gain, np.array(m.x0)
    growth = np.linalg.norm(expm(fate * m.horizon) @ start) / np.linalg.norm(start)
    assert (growth < 0.3) if h.stable else (growth > 5)


def test_unmoved_chain_is_dual_to_the_unseen_one_in_the_pushed_and_measured_direction():
    for kind in ("stable", "unstable"):
        unseen, unmoved = HIDDEN[f"unseen-{kind}"].model.plant, HIDDEN[f"unmoved-{kind}"].model.plant
        np.testing.assert_array_equal(unseen.A, unmoved.A)
        for s in (0.3 + 1j, 2.0 - 0.7j):  # reciprocity: the transfer function is the same from either side
            resolvent = np.linalg.inv(s * np.eye(4) - unseen.A)
            np.testing.assert_allclose(unseen.C @ resolvent @ unseen.B, unmoved.C @ resolvent @ unmoved.B, rtol=1e-10)


def test_chain_that_does_not_fit_its_case_is_refused_in_one_sentence():
    with pytest.raises(EngineError, match="identical"):
        hidden("unseen-stable", Parameters())
    with pytest.raises(EngineError, match="do not fit the case"):
        hidden("unseen-stable", two_mass.DEPARTS)
    with pytest.raises(EngineError, match="no case"):
        hidden("unseen")  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="no sensor"):
        two_mass.plant(sensor="third")  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="no actuator"):
        two_mass.plant(actuator="third")  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="no sensor"):
        cart.plant(sensor="smell")  # type: ignore[arg-type]
