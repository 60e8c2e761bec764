"""What the conditions of the robust observer leave free: ranks order by order, and example 1 with one observer state more."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space

from observer_lab.engine.observers import existence, vertices, worst_error_gain
from observer_lab.lessons.robust_observer.criterion import criterion_3, steering_3
from observer_lab.lessons.robust_observer.lesson import LESSON
from observer_lab.lessons.robust_observer.study import observer_of
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2

PAIRS = ((-4.0, -2.5), (-0.7, -9.0), (-3 - 2j, -3 + 2j))


def design(**changes):
    return LESSON.apply(LESSON.start(), {"example": "3", **changes})


def rows_of(example, poles):
    """[T; C] of one output by hand: t = C (sI − A)⁻¹ up to a factor, Re and Im of a pair."""
    A, C = example.plant.A, example.plant.C
    t = [C @ np.linalg.inv(s * np.eye(len(A)) - A) for s in poles if complex(s).imag >= 0]
    return np.vstack([*(part for row in t for part in ((row.real, row.imag) if np.iscomplexobj(row) else (row,))), C])


@pytest.mark.parametrize("example", [EXAMPLE_1, EXAMPLE_2], ids=["1", "2"])
@pytest.mark.parametrize("poles", [(), (-5.0,), (-4.0, -2.5), (-3 - 2j, -3 + 2j), (-4.0, -2.5, -6.0)])
def test_ranks_are_those_of_the_rows_written_out(example, poles):
    found, rows = existence(example.plant, example.K, poles), rows_of(example, poles)
    assert (found.rank, found.with_K) == (np.linalg.matrix_rank(rows), np.linalg.matrix_rank(np.vstack([rows, example.K])))
    assert found.free == null_space(rows.T).shape[1] and found.rows == len(rows)
    assert found.missed == pytest.approx(np.linalg.norm(example.K @ null_space(rows)) / np.linalg.norm(example.K), abs=1e-12)


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("free", [0.0, -42.0, 77.5])
def test_every_free_number_gives_an_observer(pair, free):
    """M is M′; both conditions hold, by hand; J and N are the drawn ones."""
    d = design(pair=pair, free=free, norm="inf", beta=0.4)
    o, plant = observer_of(d), EXAMPLE_1.plant
    assert o.M[0, 0] == pytest.approx(free, abs=1e-11)
    np.testing.assert_allclose(o.T @ plant.A - o.F @ o.T, o.L @ plant.C, atol=1e-12)
    np.testing.assert_allclose(o.N @ o.T + o.M @ plant.C, EXAMPLE_1.K, atol=1e-11)
    upper, lower = (complex(p) if np.iscomplexobj(np.array(pair)) else p for p in sorted(pair, key=lambda p: -np.imag(p)))
    assert criterion_3(np.array([upper]), np.array([lower]), d).sum() == pytest.approx(o.J, rel=1e-10)
    if not np.iscomplexobj(np.array(pair)):
        assert steering_3(np.array(pair[0]), np.array(pair[1]), free) == pytest.approx(np.abs(o.N).max(), rel=1e-9)


def test_on_the_model_no_free_number_is_seen_but_in_how_the_start_is_forgotten():
    """ε decays by F alone; û errs by N ε, and by nothing that v does."""
    for free in (0.0, 60.0):
        o = LESSON.compute(design(free=free))
        e = o.study.observer
        start = np.array([-0.3, -0.3]) - e.T @ [1.0, 1.0]
        eps = start * np.exp(np.outer(o.study.model.t, [-4.0, -2.5]))
        np.testing.assert_allclose(o.study.model.e, -(eps @ e.N.T)[:, 0], atol=1e-9)


def test_J_asks_for_no_direct_path_and_the_worst_case_for_another():
    """As the step says: with poles −4, −2.5 the worst case is least near M′ = −42."""
    errors, axis = vertices(EXAMPLE_1.wrong, (0.1, 0.4), (0.05,)), np.arange(-54.0, 13.0, 6.0)
    worst = [worst_error_gain(observer_of(design(free=m)), errors) for m in axis]
    J = [observer_of(design(free=m)).J for m in axis]
    assert axis[np.argmin(worst)] == -42 and axis[np.argmin(J)] == 0


@pytest.mark.parametrize(("pair", "free", "left"), [((-4, -2.5), 25.0, -2.5), ((-4, -2.5), 70.0, -4.0), ((-1.3, -6), -11.0, -1.3)])
def test_where_a_state_falls_silent_the_first_order_observer_is_left(pair, free, left):
    """The same e_u from v as the observer of example 1 with that pole, on the true plant, started alike."""
    task = next(t for t in LESSON.tasks if t.id == "no-say")
    o, one = LESSON.compute(design(pair=pair, free=free)), LESSON.compute(design(example="1", pole=(left,)))
    assert task.check(o).solved and not task.check(LESSON.compute(design(pair=pair, free=free + 2))).solved
    np.testing.assert_allclose(o.study.now, one.study.now, rtol=1e-6)
    assert o.gains["M"][0, 0] == pytest.approx(one.gains["M"][0, 0])
