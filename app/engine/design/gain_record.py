"""A gain record that acts as its gain in products, sums and NumPy's functions."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["ActsAsGain"]


class ActsAsGain:
    """What a record with a matrix `gain` does as that matrix: `A - B @ record`, `np.asarray(record)`, `record.T`."""

    gain: np.ndarray

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.gain, dtype=dtype) if copy else np.asarray(self.gain, dtype=dtype)

    @property
    def shape(self) -> tuple[int, ...]:
        """(rows, columns) of the gain."""
        return self.gain.shape

    @property
    def T(self) -> np.ndarray:
        """The gain transposed."""
        return self.gain.T

    def __matmul__(self, other: Any) -> np.ndarray:
        return self.gain @ np.asarray(other)

    def __rmatmul__(self, other: Any) -> np.ndarray:
        return np.asarray(other) @ self.gain

    def __neg__(self) -> np.ndarray:
        return -self.gain

    def __add__(self, other: Any) -> np.ndarray:
        return self.gain + np.asarray(other)

    def __sub__(self, other: Any) -> np.ndarray:
        return self.gain - np.asarray(other)

    def __rsub__(self, other: Any) -> np.ndarray:
        return np.asarray(other) - self.gain

    def __mul__(self, other: Any) -> np.ndarray:
        return self.gain * np.asarray(other)

    def __truediv__(self, other: Any) -> np.ndarray:
        return self.gain / np.asarray(other)

    __radd__, __rmul__ = __add__, __mul__
