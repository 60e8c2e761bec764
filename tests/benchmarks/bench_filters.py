"""Filters beside filterpy and textbook loops, with ten states and four sensors; packets that are lost; many runs at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from stopwatch import Row, median

from observer_lab.engine import Belief, ExtendedKalmanFilter, KalmanFilter, SquareRootFilter, UnscentedKalmanFilter
from observer_lab.engine.filters import Beliefs, Experiment, simulate_filters
from observer_lab.engine.network import intermittent_covariances
from observer_lab.plants.platform import model, nonlinear

STEPS, SHORT = 10_000, 300


def textbook(filter_: KalmanFilter, start: Belief, y: np.ndarray, kind: type = np.float64) -> tuple[np.ndarray, np.ndarray]:
    """Predict and update one step after another, Joseph's form, nothing saved but the means; the last P[k|k−1]."""
    A, C, Q, R = (matrix.astype(kind) for matrix in (filter_.A, filter_.C, filter_.Q, filter_.R))
    x, P, one, means = start.mean.astype(kind), start.covariance.astype(kind), np.eye(len(A), dtype=kind), []
    for measured in y.astype(kind):
        S = C @ P @ C.T + R
        M = P @ C.T @ (np.linalg.inv(S) if kind is np.float64 else inverse(S))
        x = x + M @ (measured - C @ x)
        P = (one - M @ C) @ P @ (one - M @ C).T + M @ R @ M.T
        means.append(x)
        x, P = A @ x, A @ P @ A.T + Q
    return np.array(means), P


def inverse(S: np.ndarray) -> np.ndarray:
    """By elimination, in the precision of S."""
    wide = np.hstack([S, np.eye(len(S), dtype=S.dtype)])
    for i in range(len(S)):
        wide[i] /= wide[i, i]
        for j in range(len(S)):
            if j != i:
                wide[j] -= wide[j, i] * wide[i]
    return wide[:, len(S):]


def packaged(filter_: KalmanFilter, start: Belief, y: np.ndarray) -> Callable[[], np.ndarray] | None:
    """The same by filterpy, None where it is not installed."""
    try:
        from filterpy.kalman import KalmanFilter as Peer
    except ImportError:
        return None

    def work() -> np.ndarray:
        peer = Peer(dim_x=filter_.n, dim_z=len(filter_.C))
        peer.x, peer.P, peer.F, peer.H, peer.Q, peer.R = (
            start.mean[:, None].copy(), start.covariance.copy(), filter_.A, filter_.C, filter_.Q, filter_.R)
        means = []
        for measured in y:
            peer.update(measured[:, None])
            means.append(peer.x[:, 0])
            peer.predict()
        return np.array(means)

    return work


def linear() -> Iterator[Row]:
    """10,000 steps of the platform's filter from far and from its steady state."""
    plant = model.plant()
    plain, roots = (kind.from_plant(plant, 1e-12, 1e-12, dt=1e-3, G=plant.B[:, 3:]) for kind in (KalmanFilter, SquareRootFilter))
    y = 1e-6 * np.random.default_rng(0).standard_normal((STEPS, 4))
    start, settled = Belief(np.zeros(10), 1e-6 * np.eye(10)), Belief(np.zeros(10), plain.steady.solution)
    loop, exact = median(lambda: textbook(plain, start, y), 0, 3), textbook(plain, start, y[:SHORT], np.longdouble)[0]

    def error(means: np.ndarray) -> float:
        return float(np.abs(means[:SHORT] - exact).max() / np.abs(exact).max())

    by_hand = error(textbook(plain, start, y[:SHORT])[0])
    peers = {"textbook loop": (loop, by_hand)}
    if (work := packaged(plain, start, y)) is not None:
        peers["filterpy"] = median(work, 0, 3), error(work())
    for peer, (seconds, off) in peers.items():
        said = f"means off {error(plain.run(start, y).means):.1e}, peer {off:.1e}"
        yield Row("Kalman, 10,000 steps, gain changing", median(lambda: plain.run(start, y)), peer, seconds, 10, said=said,
                  limit="five products of 10×10 a step, 0.2 µs each, and 20 MB of covariances to be kept")
    yield Row("Kalman, settled", median(lambda: plain.run(settled, y)), "textbook loop", loop, 200,
              limit="the scan and the means write more than the cache holds")
    said = f"means off {error(roots.run(start, y).means):.1e}, peer {by_hand:.1e}"
    yield Row("square-root filter, gain changing", median(lambda: roots.run(start, y)), "textbook loop", loop, 3, said=said)


def textbook_unscented(f: Callable[[np.ndarray], np.ndarray], h: Callable[[np.ndarray], np.ndarray], x: np.ndarray, P: np.ndarray,
                       Q: np.ndarray, R: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One prediction and one update of an unscented filter (α = 1, β = 2, κ = 0), every sigma point on its own."""
    n = len(x)
    weight = np.full(2 * n + 1, 0.5 / n)
    weight[0] = 0.0
    spreads = weight.copy()
    spreads[0] = 2.0

    def spread(mean: np.ndarray, P: np.ndarray) -> list[np.ndarray]:
        root = np.linalg.cholesky(n * P)
        return [mean] + [mean + root[:, i] for i in range(n)] + [mean - root[:, i] for i in range(n)]

    points = [f(point) for point in spread(x, P)]
    mean = sum(w * point for w, point in zip(weight, points, strict=True))
    P = sum(w * np.outer(p - mean, p - mean) for w, p in zip(spreads, points, strict=True)) + Q
    points = spread(mean, P)
    seen = [h(point) for point in points]
    expected = sum(w * z for w, z in zip(weight, seen, strict=True))
    S = sum(w * np.outer(z - expected, z - expected) for w, z in zip(spreads, seen, strict=True)) + R
    across = sum(w * np.outer(p - mean, z - expected) for w, p, z in zip(spreads, points, seen, strict=True))
    M = across @ np.linalg.inv(S)
    return mean + M @ (y - expected), P - M @ S @ M.T


def unscented() -> Iterator[Row]:
    """One step on a plant of ten states; extended beside it."""
    A, C, y = 0.9 * np.eye(10), np.eye(4, 10), np.ones(4)
    arguments = (lambda x, u: A @ x, lambda x, u: C @ x, np.eye(10), np.eye(4))
    start, x0, P0 = Belief(np.zeros(10), np.eye(10)), np.zeros(10), np.eye(10)
    single = median(lambda: textbook_unscented(A.dot, C.dot, x0, P0, P0, np.eye(4), y))
    theirs = textbook_unscented(A.dot, C.dot, x0, P0, P0, np.eye(4), y)[0]
    for kind, goal in ((UnscentedKalmanFilter, 20), (ExtendedKalmanFilter, None)):
        filter_ = kind(*arguments)
        off = np.abs(filter_.update(filter_.predict(start), y).mean - theirs).max()
        yield Row(f"{kind.__name__}, one step", median(lambda f=filter_: f.update(f.predict(start), y)), "textbook, point by point",
                  single, goal, said=f"differ by {off:.1e}",
                  limit="about forty calls of NumPy on small arrays, and a fifth for the checks of two beliefs; many runs at once are fast")


def many() -> Row:
    """200 unscented runs of 100 samples on the deck with hardening springs, beside one run after another."""
    runs, steps, few = 200, 100, 2
    plant = nonlinear.plant()
    flow, no_force = plant.flow(0.025), np.zeros((3, 1))
    Q, R, P0 = np.diag([1e-9, 1e-9, 1e-8, 1e-8, 1e-8, 1e-5]), 1e-6 * np.eye(4), np.diag([1.5e-3, 2e-3, 9e-3, 1e-2, 1.4e-2, 7e-2])**2
    x0, C = np.sqrt(P0) @ np.random.default_rng(0).standard_normal((6, runs)), plant.output_slope(np.zeros((6, 1)), no_force)[0]

    def batched(filters: dict) -> list:
        start = Beliefs.alike(np.zeros(6), P0, runs)
        work = Experiment(flow, plant.output, Q, R, x0, start, np.zeros((steps, 3)), filters)
        return list(simulate_filters(work, np.random.default_rng(1)))

    filters = {"unscented": UnscentedKalmanFilter(flow, plant.output, Q, R)}
    samples = batched(filters)
    priors = [samples[k].corrections["unscented"].beliefs for k in range(steps)]

    def alone() -> None:
        for k in range(few, few + 10):
            textbook_unscented(lambda x: flow(x[:, None], no_force)[:, 0], C.dot, priors[k].mean[:, 0], priors[k].covariance[0], Q, R,
                               samples[k + 1].y[:, 0])

    found = textbook_unscented(lambda x: flow(x[:, None], no_force)[:, 0], C.dot, priors[few].mean[:, 0], priors[few].covariance[0], Q, R,
                               samples[few + 1].y[:, 0])[0]
    off = np.abs(found - priors[few + 1].mean[:, 0]).max()
    ours = median(lambda: batched(filters)) - median(lambda: batched({}))
    return Row("200 unscented runs of 100 samples", ours, "textbook, run by run", runs * steps / 10 * median(alone), 50,
               said=f"differ by {off:.1e}")


def packets() -> Row:
    """P[k|k−1] of 1000 records of 200 packets, 30 % lost, three states."""
    rng = np.random.default_rng(0)
    A, C, Q, R = np.array([[1.1, 0.2, 0], [0, 1.02, 0.1], [0, 0, 0.8]]), np.array([[1.0, 0, 0], [0, 1, 1]]), np.eye(3), np.eye(2)
    heard = rng.random((1000, 200)) < 0.7

    def by_hand(records: np.ndarray) -> np.ndarray:
        found, one = [], np.eye(3)
        for record in records:
            P = np.eye(3)
            for arrived in record:
                if arrived:
                    M = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
                    P = (one - M @ C) @ P @ (one - M @ C).T + M @ R @ M.T
                P = A @ P @ A.T + Q
            found.append(P)
        return np.array(found)

    ours = intermittent_covariances(A, C, Q, R, np.eye(3), heard)[:20, -1]
    off = np.abs(ours / by_hand(heard[:20]) - 1).max()
    return Row("1000 records of 200 packets", median(lambda: intermittent_covariances(A, C, Q, R, np.eye(3), heard)),
               "textbook, one by one", 50 * median(lambda: by_hand(heard[:20])), said=f"differ by {off:.1e} relative")


def rows() -> Iterator[Row]:
    """All rows about filters."""
    yield from linear()
    yield from unscented()
    yield many()
    yield packets()
