"""Plot poles and signals in a notebook; matplotlib is loaded when a plot is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["PoleArray", "plot_estimates", "plot_poles", "plot_signals", "with_plot"]

MAX_LABELS = 8  # lines of one panel that are named


class PoleArray(np.ndarray):
    """Complex numbers with a `plot`; whatever is computed from them is a plain array."""

    def plot(self, *, axes: Axes | None = None, sampled: bool = False) -> Axes:
        """The poles in the plane, with the stability boundary; of a sampled plant that is the unit circle."""
        return plot_poles(self, axes=axes, sampled=sampled)

    def __repr__(self) -> str:
        return repr(np.asarray(self))

    def __array_wrap__(self, array: np.ndarray, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if plain.ndim == 0 else plain


def with_plot(poles: np.ndarray) -> PoleArray:
    """The same numbers, read-only as they were, as a `PoleArray`."""
    return poles.view(PoleArray)


def plot_poles(poles: np.ndarray, *, axes: Axes | None = None, sampled: bool = False) -> Axes:
    """Crosses in the complex plane beside the imaginary axis, or beside the unit circle."""
    axes = _one(axes)
    if sampled:
        turn = np.exp(1j * np.linspace(0, 2 * np.pi, 181))
        axes.plot(turn.real, turn.imag, linewidth=0.8, color="0.6")
        axes.set_aspect("equal")
    else:
        axes.axvline(0.0, linewidth=0.8, color="0.6")
    values = np.asarray(poles)
    axes.plot(values.real, values.imag, "x")
    axes.set_xlabel("Re")
    axes.set_ylabel("Im")
    return axes


def plot_signals(t: np.ndarray, panels: Mapping[str, Mapping[str, np.ndarray]], *, time: str = "t (s)") -> list[Axes]:
    """One panel under the other, by its label; the lines of a panel by theirs, each an array (n_t,)."""
    from matplotlib import pyplot

    rows = {label: lines for label, lines in panels.items() if lines}
    _, axes = pyplot.subplots(max(1, len(rows)), 1, sharex=True, squeeze=False)
    for place, (label, lines) in zip(axes[:, 0], rows.items(), strict=False):
        for name, values in lines.items():
            place.plot(t, values, label=name, linestyle="--" if name.endswith("estimate") else "-", linewidth=1.2)
        place.set_ylabel(label)
        if len(lines) <= MAX_LABELS:
            place.legend(loc="best", fontsize="small")
    axes[-1, 0].set_xlabel(time)
    return list(axes[:, 0])


def plot_estimates(means: np.ndarray, variances: np.ndarray, *, dt: float = 0.0) -> list[Axes]:
    """Estimates (n_t, n) with two standard deviations to either side, a panel each; over samples, or seconds if dt is given."""
    k, deviation = np.arange(len(means)), np.sqrt(np.maximum(variances, 0.0))
    panels = {f"x{i + 1}": {"estimate": mean, "+2σ": mean + 2 * spread, "−2σ": mean - 2 * spread}
              for i, (mean, spread) in enumerate(zip(means.T, deviation.T, strict=True))}
    return plot_signals(k * dt if dt else k, panels, time="t (s)" if dt else "sample")


def _one(axes: Axes | None) -> Axes:
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots()[1]
