"""Check Chen and Patton's unknown-input observer and printed quantiles of χ²."""

from __future__ import annotations

import numpy as np

from ..engine import Plant, unknown_input_observer
from ..engine.observers import decoupling, residual_threshold
from .record import Published

BOOK, CHI2_TABLE = "Chen & Patton 1999", "χ² table"
EXAMPLE_PLANT = Plant(np.array([[-1, 1, 0], [-1, 0, 0], [0, -1, -1]]), np.array([[-1], [0], [0]]),
                np.array([[1, 0, 0], [0, 0, 1]]))
UNKNOWN_INPUT = np.array([[-1.0], [0.0], [0.0]])


def worst_residual() -> float:
    """The largest relative residual of the three conditions of the observer with poles −2, −5, −10."""
    return max(unknown_input_observer(EXAMPLE_PLANT, UNKNOWN_INPUT, [-2, -5, -10]).residuals(EXAMPLE_PLANT, UNKNOWN_INPUT))


RECORDS = (
    Published(BOOK, "H of the example", "1 0; 0 0; 0 0", lambda: decoupling(EXAMPLE_PLANT, UNKNOWN_INPUT).H),
    Published(BOOK, "T A of the example", "0 0 0; -1 0 0; 0 -1 -1", lambda: decoupling(EXAMPLE_PLANT, UNKNOWN_INPUT).A1),
    Published(BOOK, "conditions of the observer with poles −2, −5, −10", "hold", worst_residual, right="0",
              tolerance=1e-9),
    Published(CHI2_TABLE, "upper 1 % of χ² with 3 degrees of freedom", "11.345", lambda: residual_threshold(3, 0.01)),
    Published(CHI2_TABLE, "upper 0.1 % of χ² with 10 degrees of freedom", "29.588", lambda: residual_threshold(10, 0.001)),
    Published(CHI2_TABLE, "upper 5 % of χ² with 30 degrees of freedom", "43.773", lambda: residual_threshold(30, 0.05)),
)
