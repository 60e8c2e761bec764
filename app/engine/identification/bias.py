"""Give a sensor's bias a state of its own where the data say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..systems.errors import EngineError, phrase
from ..systems.gates.argument_checks import choice, instance, number, optional, takes
from ..systems.plant import Plant
from .evidence import padded, whitened
from .identified import FilteredRecord, FittedFilter, RecordFit, SensorBias, filter_record

__all__ = ["KINDS", "sensor_bias"]

KINDS = ("constant", "drift", "data")
RATES = tuple(10.0**k for k in range(-6, 1))  # of a drift, in units of R: variance that it gains in one row
NEAR = 2.0  # standard deviations of a pole: within them of 1 it may be an integrator
RANK = 1e-6  # of the largest singular value


@takes(found=instance(RecordFit), kind=choice(*KINDS), factor=number(0, 1e9), gate=optional(number(0.5, 1)))
def sensor_bias(found: RecordFit, *, kind: str = "data", factor: float = 1.0, gate: float | None = None) -> RecordFit:
    """The fit whose filter has the bias b of one sensor as a further state, b⁺ = b + w, y = C x + D u + b + v.

    kind: "constant" (w = 0), "drift" (a random walk, its variance by likelihood), or "data". The data decide by −2 log L of the unused
    rows. For each fitted number it must fall by (1 + N/M) log N, with N unused readings and M fitted rows. The part N/M is for the error
    of the level that was taken out. Of several sensors the likeliest has the bias. `factor` and `gate` as in `filter_record`.
    Raises EngineError where the bias is not observable by the rank test; "data" then adds none and says why.
    Source: Friedland, IEEE Transactions on Automatic Control 14 (1969) 359–367; Schwarz, Annals of Statistics 6 (1978) 461–464.

    >>> y = np.random.default_rng(0).standard_normal(400)
    >>> fit = identify(Record(np.arange(400), np.zeros((400, 0)), y + 3 * (np.arange(400) > 300)), order=1, robust=False)
    >>> sensor_bias(fit).bias.kind
    'drift'
    """
    first, plain, names = found.judged.first, found.fitted, found.record.output_names
    hidden = [_hidden_by(found, j) for j in range(plain.plant.p)]
    open_to = [j for j, pole in enumerate(hidden) if pole is None]
    if not open_to:
        n = plain.plant.n
        said = phrase("A bias of {name} and the plant's pole {pole:.3g} give the same readings: the rank is {rank}, and {count} is "
                      "needed.", name=names[0], pole=float(hidden[0] or 1.0), rank=n, count=n + 1)
        if kind != "data":
            raise EngineError("{said} Leave the bias out, or add a sensor.", said=said)
        return replace(found, bias=SensorBias("none", 0, 0.0, 0.0, 0.0, 0.0, said))
    before = _level(filter_record(plain, found.record, first, factor=factor, gate=gate), first)
    readings = int(np.isfinite(found.record.y[first:]).sum())
    each = (1 + readings / plain.rows) * float(np.log(readings))
    tried: list[tuple[float, float, str, int, FittedFilter, FilteredRecord]] = []
    for j in open_to:
        for rate in ((0.0,) if kind == "constant" else RATES if kind == "drift" else (0.0, *RATES)):
            fitted = _with_bias(plain, j, rate * float(plain.R[j, j]), factor)
            judged = filter_record(fitted, found.record, first, gate=gate)
            tried.append((before - _level(judged, first), each * (2 if rate else 1), "drift" if rate else "constant", j, fitted, judged))
    gain, cost, chosen, j, fitted, judged = max(tried, key=lambda trial: trial[0] - trial[1])
    if kind == "data" and gain < cost:
        said = phrase("No sensor needs a bias as a state: one lowers −2 log L of the unused rows by {gain:.3g}, and {cost:.3g} are needed.",
                      gain=max(gain, 0.0), cost=cost)
        return replace(found, bias=SensorBias("none", j, 0.0, 0.0, gain, cost, said))
    value, deviation = float(judged.track.means[-1, -1]), float(np.sqrt(judged.track.covariances[-1, -1, -1]))
    words = {"name": names[j], "value": value, "deviation": deviation, "gain": gain, "cost": cost}
    said = (phrase("{name} has a bias that drifts, at the end {value:.3g} ± {deviation:.2g}: its state lowers −2 log L by {gain:.3g}; "
                   "{cost:.3g} are needed.", **words) if chosen == "drift" else
            phrase("{name} has a constant bias, at the end {value:.3g} ± {deviation:.2g}: its state lowers −2 log L by {gain:.3g}; "
                   "{cost:.3g} are needed.", **words))
    return replace(found, fitted=fitted, judged=judged, bias=SensorBias(chosen, j, value, deviation, gain, cost, said))


def _hidden_by(found: RecordFit, output: int) -> float | None:
    """The pole that gives the same readings as a bias of this output, None where the bias is observable.

    Rank of [A − z I; C, e_j] with the bias as a column, at z = 1 and at each pole that may be 1 by its standard deviation.
    """
    plant, s = found.fitted.plant, found.subspace
    n, p = plant.n, plant.p
    near = [float(pole.real) for pole, deviation in zip(s.poles, s.deviations, strict=True)
            if abs(pole - 1) <= NEAR * deviation and abs(pole.imag) <= deviation]
    for z in (1.0, *near):
        test = np.block([[plant.A - z * np.eye(n), np.zeros((n, 1))], [plant.C, np.eye(p)[:, [output]]]])
        size = np.linalg.norm(test, axis=0)
        values = np.linalg.svd(test / np.where(size > 0, size, 1.0), compute_uv=False)
        if values[-1] <= RANK * values[0]:
            return z
    return None


def _with_bias(plain: FittedFilter, output: int, variance: float, factor: float) -> FittedFilter:
    """The filter with one more state, the bias of that output, which gains this variance in a row; its Q is `factor` times the fitted."""
    plant, n = plain.plant, plain.plant.n
    A, Q = np.eye(n + 1), np.zeros((n + 1, n + 1))
    A[:n, :n], Q[:n, :n], Q[n, n] = plant.A, factor * plain.Q, variance
    B = np.vstack([plant.B, np.zeros((1, plant.m))])
    C = np.hstack([plant.C, np.eye(plant.p)[:, [output]]])
    wide = Plant(A, B, C, plant.D, plant.dt, (), plant.input_names, plant.output_names, plant.units, plant.name)
    return replace(plain, plant=wide, Q=Q, biases=1, tuned=factor != 1)


def _level(judged: FilteredRecord, first: int) -> float:
    """−2 log L of the unused rows, without its constant part."""
    nu, S = judged.track.innovations[first:], judged.track.S[first:]
    sizes = np.linalg.slogdet(padded(S, np.isfinite(nu)))[1]
    return float(sizes.sum() + np.nansum(whitened(nu, S) ** 2))
