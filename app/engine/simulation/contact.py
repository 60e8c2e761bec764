"""Simulate two bodies with a gap: one motion in contact, another between the flanks."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from ..systems.records import record
from ..systems.recursions import step_matrices

__all__: list[str] = []

CONTACT_HALVINGS = 8  # a change of contact is located to h / 2^CONTACT_HALVINGS
TURNS = 12  # changes of contact followed within one step
TORQUE_ROUNDING = 1e-12  # of the terms of a torque: what is smaller counts as none
Flow = tuple[tuple[np.ndarray, np.ndarray], ...]


@record()
class Contact:
    """ż = A z + g of two bodies, g held over steps of h seconds; A (N×N) is their motion without contact.

    `inner`, `outer`: where angle and speed of the driving and of the driven body stand in z; `inertias` (J₁, J₂) in kg m²,
    `half` the gap in rad. In contact both have one speed and exchange the torque λ = (ω̇₁ − ω̇₂) / (1/J₁ + 1/J₂), the rates those
    without contact; a flank only pushes, and they part where λ would pull. An impact is plastic: the common speed keeps
    J₁ω₁ + J₂ω₂. Without a gap they never part.
    """

    A: np.ndarray
    inner: tuple[int, int]
    outer: tuple[int, int]
    inertias: tuple[float, float]
    half: float
    h: float
    torque: np.ndarray = field(init=False)
    row: np.ndarray = field(init=False)
    together: Flow = field(init=False)
    apart: Flow = field(init=False)

    def __post_init__(self) -> None:
        (_, w1), (_, w2), (one, two) = self.inner, self.outer, self.inertias
        pick: np.ndarray = np.zeros(len(self.A))
        pick[w1], pick[w2] = 1.0, -1.0
        joined: np.ndarray = np.eye(len(self.A))
        joined[[w1, w2]] = 0.0
        joined[[w1, w2], w1], joined[[w1, w2], w2] = one / (one + two), two / (one + two)
        torque = pick / (1 / one + 1 / two)
        object.__setattr__(self, "torque", torque)
        object.__setattr__(self, "row", torque @ self.A)
        object.__setattr__(self, "together", _flow(joined @ self.A, joined, self.h))
        object.__setattr__(self, "apart", _flow(self.A, np.eye(len(self.A)), self.h))

    def advance(self, z: np.ndarray, g: np.ndarray, side: int) -> tuple[np.ndarray, int]:
        """The state (N,) one step later and the flank then in contact: 1 pushes forward, −1 back, 0 none."""
        Phi, Phi1 = (self.together if side or not self.half else self.apart)[0]
        after = Phi @ z + Phi1 @ g
        return (after, side) if not self.half or self.holds(after, g, side) else self._through(z, g, side)

    def holds(self, z: np.ndarray, g: np.ndarray, side: int) -> bool:
        """Whether a contact still pushes, or a body between the flanks has not yet met one."""
        if not side:
            return abs(float(z[self.inner[0]] - z[self.outer[0]])) <= self.half * (1 + TORQUE_ROUNDING)
        pushed = side * float(self.row @ z + self.torque @ g)
        return pushed >= 0 or pushed >= -TORQUE_ROUNDING * float(np.abs(self.torque) @ (np.abs(self.A) @ np.abs(z) + np.abs(g)))

    def _through(self, z: np.ndarray, g: np.ndarray, side: int) -> tuple[np.ndarray, int]:
        """Over a step in which the contact changes: the longest dyadic parts that hold, and across each change the smallest."""
        left, turns, after = 2**CONTACT_HALVINGS, 0, z
        while left:
            for level, (Phi, Phi1) in enumerate(self.together if side else self.apart):
                part = 2**(CONTACT_HALVINGS - level)
                if part > left:
                    continue
                after = Phi @ z + Phi1 @ g
                if turns >= TURNS or self.holds(after, g, side):
                    z, left = after, left - part
                    break
            else:
                z, side = self._turned(after, side)
                left, turns = left - 1, turns + 1
        return z, side

    def _turned(self, z: np.ndarray, side: int) -> tuple[np.ndarray, int]:
        """The state after a flank is left or met."""
        if side:
            return z, 0
        (q1, w1), (q2, w2), (one, two) = self.inner, self.outer, self.inertias
        z = z.copy()
        met = 1 if z[q1] >= z[q2] else -1
        z[q2] = z[q1] - met * self.half
        z[[w1, w2]] = (one * z[w1] + two * z[w2]) / (one + two)
        return z, met


def _flow(M: np.ndarray, enter: np.ndarray, h: float) -> Flow:
    """(Φ, Φ₁) of ż = M z + `enter` g over h, h/2 … h/2^CONTACT_HALVINGS."""
    Phi, Phi1 = step_matrices(M, h / 2**CONTACT_HALVINGS)
    flow = [(Phi, Phi1 @ enter)]
    for _ in range(CONTACT_HALVINGS):
        Phi, Phi1 = Phi @ Phi, Phi1 + Phi @ Phi1
        flow.append((Phi, Phi1 @ enter))
    return tuple(flow[::-1])
