"""Canonisation: divisors of zero and of one on both sides of any matrix."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine.structure import canonise, canonise_right


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 6), st.integers(0, 6))
def test_divisors_of_zero_and_of_one(seed, p, q, rank):
    rng = np.random.default_rng(seed)
    rank = min(rank, p, q)
    M = rng.standard_normal((p, rank)) @ rng.standard_normal((rank, q)) * 10.0 ** rng.integers(-6, 6)
    for c in (canonise(M), canonise_right(M)):
        assert c.rank == rank == np.linalg.matrix_rank(M)
        left, right = np.vstack([c.unit_left, c.zero_left]), np.hstack([c.unit_right, c.zero_right])
        shape = np.zeros((p, q))
        shape[:rank, :rank] = np.eye(rank)
        np.testing.assert_allclose(left @ M @ right, shape, atol=1e-7)
        assert np.linalg.matrix_rank(left) == p and np.linalg.matrix_rank(right) == q
        np.testing.assert_allclose(M @ c.summary @ M, M, atol=1e-7 * np.abs(M).max(initial=1e-300))
