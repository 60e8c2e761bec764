"""Witnesses for what a sensor sees: modes that leave a trace in it or nearly none, by the pencils of Hautus."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from witnesses import Shown, Witness

from app.text import Text


def _flat(shown: Shown, _: Text) -> None:
    y = shown.run.y[:, 0]
    assert float(np.max(np.abs(y[-len(y) // 8:]))) <= 0.0201 * float(np.max(np.abs(y))), "the sensor still reads"


def _none_hidden(shown: Shown, _: Text) -> None:
    plant = shown.run.scenario.plant
    for pole in np.linalg.eigvals(plant.A):
        pencil = plant.A - pole * np.eye(plant.n)
        for stacked in (np.vstack([pencil, plant.C]), np.hstack([pencil, plant.B])):
            assert np.linalg.svd(stacked, compute_uv=False)[-1] > 1e-4 * np.linalg.norm(plant.A, 2), f"{pole:.3g} is nearly hidden"


def _leaves_a_trace(all_of_them: bool) -> Witness:
    """Hautus by hand, on A balanced by its own states' typical sizes: a hidden mode is one whose pencil loses rank."""
    def witness(shown: Shown, _: Text) -> None:
        plant = shown.outcome.study.sensed.plant
        least = []
        for pole in np.linalg.eigvals(plant.A):
            pencil = np.vstack([plant.A - pole * np.eye(plant.n), plant.C])
            least.append(float(np.linalg.svd(pencil, compute_uv=False)[-1]) / float(np.linalg.norm(plant.A, 2)))
        assert (min(least) > 1e-13) == all_of_them, f"the least of the pencils' singular values is {min(least):.2g} of the size of A"
    return witness


WITNESSES: Mapping[str, Witness] = {
    "The trace has gone flat: as far as the sensor can tell, all is at rest.": _flat,
    "No mode is hidden: every distance is well above zero.": _none_hidden,
    "Not observable: {poles} leave no trace in y. Known to a tenth: {known} of {n} directions.": _leaves_a_trace(False),
    "No mode is hidden (nearest: {d}), yet this run fixes only {known} of {n} directions to a tenth; rank(O) = {rank}.":
        _leaves_a_trace(True),
    "Observable: the nearest mode is {d} from being hidden, and all {n} directions are known to a tenth.": _leaves_a_trace(True),
}
