"""Random plants and poles for placement, and the check of what was reached."""

import numpy as np

SPRING = np.array([[0.0, 1.0], [-1.0, -0.5]])
POSITION = np.array([[1.0, 0.0]])


def random_pair(seed, n, m):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, n)), rng.standard_normal((n, m))


def random_poles(seed, n, pairs):
    """Distinct poles between −6 and −1, the first 2·pairs of them complex."""
    rng = np.random.default_rng(seed)
    real = -1 - 5 * (np.arange(n - 2 * pairs) + rng.uniform(0.2, 0.8, n - 2 * pairs)) / max(1, n - 2 * pairs)
    upper = -rng.uniform(1, 4, pairs) + 1j * (1 + 1.5 * np.arange(pairs) + rng.uniform(0, 0.5, pairs))
    return np.concatenate([upper, upper.conj(), real])


def same_polynomial(closed, poles, tolerance):
    """det(sI − closed) = ∏(s − pole) on a circle round the spectrum, relative."""
    radius = 2 * np.abs(poles).max()
    for s in radius * np.exp(1j * np.pi * (np.arange(5) + 0.5) / 5):
        value = np.linalg.det(s * np.eye(len(poles)) - closed)
        assert abs(value / np.prod(s - np.asarray(poles)) - 1) < tolerance
