"""Propagate driver, plant and ground filter from sample to sample."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..systems.arrays import frozen
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import matrix, takes
from ..systems.noise import step_covariance
from ..systems.plant import Plant
from ..systems.records import record
from ..systems.recursions import step_matrices
from .hardware import Hardware, coil_driver

__all__: list[str] = []

Packed = tuple[bytes, tuple[int, ...]] | None


def matrix_key(M: np.ndarray | None) -> Packed:
    """A matrix as a key of what is kept."""
    return None if M is None else (np.ascontiguousarray(M).tobytes(), M.shape)


def _unpacked(packed: Packed) -> np.ndarray | None:
    return None if packed is None else np.frombuffer(packed[0]).reshape(packed[1])


@record()
class HeldMechanics:
    """What is continuous, over one sample: Phi (a×a), what the newer and the older command do in it (a×m), the whole samples and the
    part of one by which they are late, roots of the ground's noise (a×r), what known disturbances do (a×d)."""

    Phi: np.ndarray
    soon: np.ndarray
    late: np.ndarray
    whole: int
    part: float
    jump: np.ndarray
    Gamma: np.ndarray
    C: np.ndarray
    x: slice


@lru_cache(maxsize=32)
def held_mechanics(plant: Plant, chosen: tuple[int, ...], others: tuple[int, ...], hardware: Hardware, shaping: Plant | None, W: Packed,
                   disturbances: Packed, dt: float) -> HeldMechanics:
    """Driver, plant and ground filter over a sample; the same for all controllers of one plant, so found once.

    W (q×q) and `disturbances` (n×d) packed. Raises ShapeError, EngineError where the parts do not fit.
    """
    mechanics = _Mechanics(plant, list(chosen), list(others), hardware, shaping, _unpacked(W), _unpacked(disturbances))
    steps = hardware.delay / dt
    whole = int(np.floor(steps + 1e-9))
    part = steps - whole if steps - whole > 1e-9 else 0.0
    Phi, Phi1 = step_matrices(mechanics.A, dt)
    late, soon = np.zeros((mechanics.N, len(chosen))), Phi1 @ mechanics.B
    if part > 0:
        tail, tail1 = step_matrices(mechanics.A, (1 - part) * dt)
        soon = tail1 @ mechanics.B
        late = tail @ step_matrices(mechanics.A, part * dt)[1] @ mechanics.B
    return HeldMechanics(frozen(Phi), frozen(soon), frozen(late), whole, part, frozen(mechanics.jump(dt)), frozen(Phi1 @ mechanics.known),
                         frozen(mechanics.C), mechanics.x)


class _Mechanics:
    """Driver, plant and ground filter as one continuous system, and its noise."""

    def __init__(self, plant: Plant, chosen: list[int], others: list[int], hardware: Hardware, shaping: Plant | None,
                 W: np.ndarray | None, disturbances: np.ndarray | None) -> None:
        n, m = plant.n, len(chosen)
        driver, ground = coil_driver(hardware, m), plant.B[:, others]
        first, last = driver.n if driver else 0, shaping.n if shaping else 0
        if shaping is not None and (shaping.p != ground.shape[1] or np.any(np.asarray(shaping.D))):
            raise ShapeError("The shaping filter must have {columns} outputs, one for each ground motion, and D = "
                             "0.",
                             columns=ground.shape[1])
        if shaping is not None and shaping.dt:
            raise EngineError("The shaping filter must be continuous, as the plant is.")
        N, self.x = first + n + last, slice(first, first + n)
        self.A, self.B = np.zeros((N, N)), np.zeros((N, m))
        self.A[self.x, self.x] = plant.A
        if driver is None:
            self.B[self.x] = plant.B[:, chosen]
        else:
            self.A[:first, :first], self.B[:first] = driver.A, driver.B
            self.A[self.x, :first] = plant.B[:, chosen] @ driver.C
        enter = np.zeros((N, shaping.m if shaping else ground.shape[1]))
        if shaping is None:
            enter[self.x] = ground
        else:
            self.A[first + n:, first + n:] = shaping.A
            self.A[self.x, first + n:] = ground @ shaping.C
            enter[first + n:] = shaping.B
        known = ground if disturbances is None else disturbances
        if known.shape[0] != n:
            raise ShapeError("The disturbances must enter {n} states; their matrix has {rows} rows.",
                             n=n, rows=known.shape[0])
        self.known = np.zeros((N, known.shape[1]))
        self.known[self.x] = known
        self.C = np.zeros((plant.p, N))
        self.C[:, self.x] = plant.C
        self.first, self.N = first, N
        self.intensity = None if W is None else enter @ W @ enter.T

    def jump(self, dt: float) -> np.ndarray:
        """A thin root (N×r) of the covariance that the ground's noise adds over a sample; the driver feels none of it."""
        if self.intensity is None:
            return np.zeros((self.N, 0))
        after = slice(self.first, None)
        Q = step_covariance(self.A[after, after], self.intensity[after, after], dt)
        thin = thin_root(Q)
        return np.vstack([np.zeros((self.first, thin.shape[1])), thin])


@lru_cache(maxsize=32)
def sensor_root(V: Packed, dt: float) -> np.ndarray:
    """A root (p×p) of the covariance V/dt of a sample's noise of intensity V (p×p), packed."""
    covariance = _unpacked(V)
    assert covariance is not None
    root = thin_root(covariance / dt)
    return frozen(np.hstack([root, np.zeros((len(root), len(root) - root.shape[1]))]))


@lru_cache(maxsize=32)
def without_converter(hardware: Hardware) -> Hardware:
    """What of the hardware is continuous: the driver and the delay."""
    return Hardware(bandwidth=hardware.bandwidth, order=hardware.order, delay=hardware.delay)


@takes(Q=matrix("n n"))
def thin_root(Q: np.ndarray) -> np.ndarray:
    """R (N×r) with R Rᵀ = Q to rounding and no more columns than it takes, for covariances of unequal units.

    By Cholesky's steps, each from the first state that keeps at least half of the largest variance left: eigenvectors would do,
    but their signs are another processor's own, and a seed is to mean the same noise everywhere.
    """
    spread = np.sqrt(np.maximum(np.diag(Q), 0.0))
    divisor = np.where(spread > 0, spread, 1.0)
    left = Q / np.outer(divisor, divisor)
    columns, least = list[np.ndarray](), 4e-16 * len(Q)
    while len(columns) < len(Q) and (most := np.diag(left).max()) > least:
        first = int(np.argmax(np.diag(left) > 0.5 * most))
        columns.append(left[:, first] / np.sqrt(left[first, first]))
        left = left - np.outer(columns[-1], columns[-1])
    return spread[:, None] * np.array(columns).reshape(len(columns), len(Q)).T
