"""Witnesses for what a sensor sees: modes that leave a trace in it or nearly none, by the pencils of Hautus."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import numpy as np
from witnesses import Shown, Witness, near, value

from observer_lab.text import Text


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


def _smallest(shown: Shown, words: Text) -> None:
    """The least singular value of O over its largest, by the eigenvalues of OᵀO or OOᵀ in ninety digits."""
    plant, rows = shown.outcome.study.sensed.plant, shown.outcome.study.rebuilt.rows
    with mpmath.workdps(90):
        A, C = mpmath.matrix(plant.A), mpmath.matrix(plant.C)
        blocks = [C]
        for _ in range(rows - 1):
            blocks.append(blocks[-1] * A)
        O = mpmath.matrix([[b[i, j] for j in range(plant.n)] for b in blocks for i in range(plant.p)])
        sizes = mpmath.eigsy(O.T * O if O.rows >= O.cols else O * O.T, eigvals_only=True)
        near(value(words, "levels"), float(mpmath.sqrt(abs(sizes[0]) / sizes[len(sizes) - 1])), 0.2)


WITNESSES: Mapping[str, Witness] = {
    "{lost} of {count} count as zero; the smallest is {levels:.1g} times the largest.": _smallest,
    "The trace is flat: in the reading all seems at rest.": _flat,
    "No mode is hidden: every distance is well above zero.": _none_hidden,
    "Not observable: {poles} leave no trace in y. Known to a tenth: {known} of {n} directions.": _leaves_a_trace(False),
    "No mode is hidden (nearest: {d}), yet this run fixes only {known} of {n} directions to a tenth; rank(O) = {rank}.":
        _leaves_a_trace(True),
    "Observable: the nearest mode is {d} from being hidden, and each of the {n} directions is known to a tenth.": _leaves_a_trace(True),
}
