"""Draw the floor of the stage and the shadow on it, cheaply without a graphics card."""

from __future__ import annotations

import numpy as np


def floor_lines(half: int = 8) -> np.ndarray:
    """The lines of the floor. viser's own grid is a shader over half the screen: too dear without a graphics card."""
    lines = [((x, -3.6, 0.0), (x, 2.0 * half, 0.0)) for x in range(-half, half + 1)]
    lines += [((-half, y - 0.6, 0.0), (half, y - 0.6, 0.0)) for y in range(-3, 2 * half + 1)]
    return np.array(lines, dtype=np.float32)


def floor_ground(half: float = 9.0) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (4, 3) and faces (2, 3) of the square on which a shadow is cast."""
    corners = [(-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)]
    return np.array(corners, np.float32), np.array([(0, 1, 2), (0, 2, 3)], np.uint32)


def floor_shadow() -> np.ndarray:
    """A soft shadow to lay under the plant: a picture costs a slow machine far less than cast shadows."""
    y, x = np.mgrid[-1:1:96j, -1:1:128j]
    alpha = 95 * np.clip(1 - np.sqrt((np.abs(x) / 0.95) ** 2.6 + (np.abs(y) / 0.9) ** 2.6), 0.0, 1.0) ** 1.3
    return np.dstack([np.full((96, 128, 3), 40), alpha]).astype(np.uint8)
