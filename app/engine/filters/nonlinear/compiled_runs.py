"""Simulate many nonlinear runs and three filters by a compiled kernel, where one is ready."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ...kernels import as_kernel_array, compiled_kernel
from ...kernels.filter_bank import filter_bank_steps
from ...systems.flow import Flow, NonlinearPlant
from ...systems.records import record
from ..belief import Beliefs, Corrections
from .experiment import Experiment, Sample, State
from .extended import ExtendedKalmanFilter, LinearisedFilter
from .nonlinear_filter import NonlinearFilter
from .slopes import Tapes, tapes_of
from .unscented import PrintedUnscentedFilter, UnscentedKalmanFilter

__all__ = ["CompiledBank", "compiled_bank_of"]



def _flows(flow: object, plant: NonlinearPlant) -> bool:
    return isinstance(flow, Flow) and flow.rhs is plant.rhs and flow.slope is plant.slope


def compiled_bank_of(e: Experiment) -> CompiledBank | None:
    """The kernel at an experiment: one filter of each kind on the plant's own flow and output; None where it is another."""
    plant, flow = e.plant, e.flow
    if compiled_kernel(filter_bank_steps) is None or plant is None or not isinstance(flow, Flow) or not _flows(flow, plant):
        return None
    if e.output is not plant.output or any(each.f is not flow or each.h is not plant.output for each in e.filters.values()):
        return None
    kinds = [(LinearisedFilter,), (ExtendedKalmanFilter,), (UnscentedKalmanFilter, PrintedUnscentedFilter)]
    found = [[name for name, each in e.filters.items() if type(each) in kind] for kind in kinds]
    if len(e.filters) != 3 or any(len(names) != 1 for names in found):
        return None
    extended = e.filters[found[1][0]]
    assert isinstance(extended, ExtendedKalmanFilter)
    if extended.iterations > 1 or any(each.y_minus or each.x_minus or each.x_plus for each in e.filters.values()):
        return None
    if extended.f_expand != flow.expand or extended.h_expand not in (None, plant.observe):
        return None
    tapes = tapes_of(plant)
    return None if tapes is None else CompiledBank(e, flow, tapes, (found[0][0], found[1][0], found[2][0]))


@record()
class CompiledBank:
    """An experiment and the names of its filters: expanded once, along its estimate, by sigma points."""

    e: Experiment
    flow: Flow
    tapes: Tapes
    names: tuple[str, str, str]

    @property
    def filters(self) -> list[NonlinearFilter]:
        """In this order."""
        return [self.e.filters[name] for name in self.names]

    @cached_property
    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """The first beliefs: means (n, N), covariances (N, n, n)."""
        n, N = self.e.x0.shape
        return as_kernel_array(self.e.start.mean), as_kernel_array(np.broadcast_to(self.e.start.covariance, (N, n, n)))

    @cached_property
    def fixed(self) -> tuple[np.ndarray, ...]:
        """What does not change from sample to sample, in the kernel's order."""
        e, (linear, _, points) = self.e, self.filters
        assert isinstance(linear, LinearisedFilter) and isinstance(points, UnscentedKalmanFilter)
        f0, A, B, h0, C, D, rest, held = linear.expanded
        n, m = len(e.x0), e.inputs.shape[1]
        reach, means, covariances = points.weights
        weights = np.array([means, covariances, np.full(len(means), reach)])
        s = e.steering
        gain, limit = (np.zeros((m, n)), np.zeros(m)) if s is None else (s.gain, s.u_max)
        return tuple(
            map(
                as_kernel_array,
                (
                    f0[:, 0],
                    A,
                    B,
                    h0[:, 0],
                    C,
                    D,
                    rest[:, 0],
                    held[:, 0],
                    np.array([each.Q for each in self.filters]),
                    np.array([each.R for each in self.filters]),
                    weights,
                    gain,
                    limit,
                ),
            )
        )

    def ahead(self, k: int, now: State, v: np.ndarray, w: np.ndarray) -> tuple[list[Sample], State]:
        """As many samples from k on as there is noise v (steps, p, N), w (steps, n, N) for, or fewer, and where all stands then."""
        e, work = self.e, compiled_kernel(filter_bank_steps)
        n, N = e.x0.shape
        steps, (p, m) = len(v), (v.shape[1], e.inputs.shape[1])
        if work is None:
            return [], now
        known, jumps = as_kernel_array(e.inputs[k:k + steps]), np.zeros((steps, n))
        for at, jump in e.kicks:
            if k <= at < k + steps:
                jumps[at - k] = jump
        one, two, three = (now.priors[name] for name in self.names)
        kept, moves = type(self.filters[2]) is PrintedUnscentedFilter, min(steps, len(e.inputs) - 1 - k)
        plan = np.array([-1 if e.steering is None else self.names.index(e.steering.by), self.flow.parts, moves,
                         0 if not kept else 2 if three.points is None else 1])
        X, priors, lost = np.empty((steps + 1, n, N)), np.empty((steps + 1, 3, n, N)), np.empty((steps + 1, 3, N), dtype=bool)
        P_one, P = np.empty((steps + 1, n, n)), np.empty((steps + 1, 2, N, n, n))
        points = np.empty((steps + 1 if kept else 1, N, n, 2 * n + 1))
        X[0], P_one[0], P[0, 0], P[0, 1] = now.x, one.covariance[0], two.covariance, three.covariance
        for f, name in enumerate(self.names):
            priors[0, f], lost[0, f] = now.priors[name].mean, now.lost[name]
        if three.points is not None:
            points[0] = three.points.transpose(2, 0, 1)
        x, y, u, means = np.empty((steps, n, N)), np.empty((steps, p, N)), np.empty((steps, m, N)), np.empty((steps, 3, n, N))
        after_one, after, nu = np.empty((steps, n, n)), np.empty((steps, 2, N, n, n)), np.empty((steps, 3, p, N))
        S_one, S, M_one, M = (np.empty((steps, *shape)) for shape in ((p, p), (2, N, p, p), (n, p), (2, N, n, p)))
        with np.errstate(all="ignore"):
            done = int(
                work(
                    *self.tapes,
                    *self.fixed,
                    known,
                    jumps,
                    as_kernel_array(v),
                    as_kernel_array(w),
                    *self.start,
                    plan,
                    self.flow.step / self.flow.parts,
                    X,
                    priors,
                    P_one,
                    P,
                    points,
                    lost,
                    x,
                    y,
                    u,
                    means,
                    after_one,
                    after,
                    nu,
                    S_one,
                    S,
                    M_one,
                    M,
                )
            )

        def sample(i: int) -> Sample:
            shared, gone = after_one[i][None], lost[i + 1, 0]
            if gone.any():
                shared = np.repeat(shared, N, axis=0)
                shared[gone] = self.start[1][gone]
            found = {self.names[0]: Corrections(Beliefs(means[i, 0], shared), nu[i, 0], S_one[i][None], M_one[i][None])}
            for f, name in enumerate(self.names[1:]):
                found[name] = Corrections(Beliefs(means[i, f + 1], after[i, f]), nu[i, f + 1], S[i, f], M[i, f])
            return Sample(k + i, x[i], y[i], known[i][:, None] if e.steering is None else u[i], {name: found[name] for name in e.filters},
                          self._by_name(lost[i + 1]))

        carried = points[done].transpose(1, 2, 0) if kept and (done or plan[3] == 1) else None
        then = State(X[done], {
            self.names[0]: Beliefs(priors[done, 0], P_one[done][None]), self.names[1]: Beliefs(priors[done, 1], P[done, 0]),
            self.names[2]: Beliefs(priors[done, 2], P[done, 1], carried),
        }, self._by_name(lost[done]))
        return [sample(i) for i in range(done)], then

    def _by_name(self, lost: np.ndarray) -> dict[str, np.ndarray]:
        found: Iterator[tuple[str, np.ndarray]] = zip(self.names, lost, strict=True)
        return dict(found)
