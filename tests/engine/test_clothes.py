"""An argument in other clothes (sparse, single precision, read-only, a table of pandas, …) is answered as the plain array or refused."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse
from clothes import CLOTHES, cases, findings

from observer_lab import engine

SHARE = 12  # one (call, argument) of so many; `python tests/engine/clothes.py` tries them all


@pytest.mark.slow
@pytest.mark.parametrize("part", range(2))
def test_clothes_do_not_change_an_answer(part: int) -> None:
    assert not list(findings(cases()[part * SHARE // 2::SHARE]))


def test_what_everyone_calls_takes_all_clothes() -> None:
    """Answered, not refused."""
    A, B, C, one = np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.eye(1)
    wanted = engine.lqr(A, B, np.eye(2), one).gain, engine.lqe(A, B, C, one, one).gain, engine.place(A, B, [-3, -4]).gain
    for name, (_, put_on) in CLOTHES.items():
        a, b, c, q, r = map(put_on, (A, B, C, np.eye(2), one))
        found = engine.lqr(a, b, q, r).gain, engine.lqe(a, b, c, r, r).gain, engine.place(a, b, [-3, -4]).gain
        for K, right in zip(found, wanted, strict=True):
            assert type(K) is np.ndarray and np.allclose(K, right, rtol=1e-12), name


def test_a_huge_sparse_matrix_is_refused_before_it_is_filled() -> None:
    with pytest.raises(engine.ShapeError, match="smaller matrix"):
        engine.Plant(scipy.sparse.csr_array((10**6, 10**6)), [[1]], [[1]])
