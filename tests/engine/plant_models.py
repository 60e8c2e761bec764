"""Every model that a lesson may show, and the PBH tests of one mode."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.plants import MODELS
from observer_lab.plants.two_mass import HIDDEN

EVERY = [*MODELS.values(), *(h.model for h in HIDDEN.values())]
every_model = pytest.mark.parametrize("m", EVERY, ids=lambda m: m.id)


def rank(matrix) -> int:
    return int(np.linalg.matrix_rank(matrix))


def pbh_seen(plant, pole) -> bool:
    return rank(np.vstack([plant.A - pole * np.eye(plant.n), plant.C])) == plant.n


def pbh_moved(plant, pole) -> bool:
    return rank(np.hstack([plant.A - pole * np.eye(plant.n), plant.B])) == plant.n
