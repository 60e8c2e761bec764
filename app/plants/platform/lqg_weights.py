"""Design the report's LQG on the platform, on ten states or on fewer.

Platform report (003), equations (75)–(89). Two readings of its sensor noise are kept: σ_v = 10⁻⁹ taken literally is the
intensity V = 10⁻¹⁸, while its figures say V = 10⁻⁹ and 10⁻⁶; its 20 to 40 dB come out for V = 10⁻⁹ … 10⁻¹⁰.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...engine import Plant
from ...engine import lqg as _lqg
from ...engine.feedback import Lqg

COIL_COUNT = 3  # the first inputs of the platform; those after them are the ground
V_MAG, H_MAG = 1e-4, 1e-5  # m/s, equation (80)
GROUND_UNIT = 1e-12  # m² s: σ_w² of each ground motion, equation (76)
LITERAL_V, FIGURE_V, LOOSE_V = 1e-18, 1e-9, 1e-6  # (m/s)² s: σ_v² of equation (77); the two values in the figures
S_Y = (1 / V_MAG, 1 / H_MAG, 1 / V_MAG, 1 / H_MAG)  # equation (81)


@dataclass(frozen=True)
class Weights:
    """The four factors of the report and the two units that they multiply.

    Q = α_Q CᵀS_yᵀS_y C, R = α_R I₃, W = β_Q · 10⁻¹² I₂ (m² s), V = β_R v0 I₄ with v0 in (m/s)² s.
    """

    alpha_q: float = 100.0
    alpha_r: float = 0.1
    beta_q: float = 1.0
    beta_r: float = 1.0
    v0: float = FIGURE_V

    def Q(self, plant: Plant) -> np.ndarray:
        """α_Q Cᵀ W_y C, n×n, equations (83), (84), (86)."""
        scaled = np.diag(S_Y) @ plant.C
        return self.alpha_q * (scaled.T @ scaled)

    @property
    def R(self) -> np.ndarray:
        """α_R I₃, equations (85), (86)."""
        return self.alpha_r * np.eye(COIL_COUNT)

    @property
    def W(self) -> np.ndarray:
        """β_Q · 10⁻¹² I₂, equations (76), (78)."""
        return self.beta_q * GROUND_UNIT * np.eye(2)

    @property
    def V(self) -> np.ndarray:
        """β_R v0 I₄, equations (77), (78)."""
        return self.beta_r * self.v0 * np.eye(4)


LITERAL = Weights(v0=LITERAL_V)
FIGURE_WEIGHTS = Weights(v0=FIGURE_V)


def coils(plant: Plant) -> Plant:
    """The plant with its coils alone as inputs, from one with coils and ground."""
    return Plant(plant.A, plant.B[:, :COIL_COUNT], plant.C, np.asarray(plant.D)[:, :COIL_COUNT], plant.dt, plant.state_names,
                 plant.input_names[:COIL_COUNT], plant.output_names, plant.units, plant.name)


def ground(plant: Plant) -> np.ndarray:
    """G (n×2): how ground motion in m enters the states of a plant with coils and ground."""
    return plant.B[:, COIL_COUNT:]


def lqg(plant: Plant, weights: Weights = FIGURE_WEIGHTS) -> Lqg:
    """The report's LQG for a platform with inputs (u1, u2, u3, z_g, x_g): ten states, or a truncation of them.

    Answers with K, L, the controller y → u (sign included), both Riccati solutions and the least cost. Equations (79),
    (87)–(89).
    """
    return _lqg(coils(plant), weights.Q(plant), weights.R, weights.W, weights.V, G=ground(plant))
