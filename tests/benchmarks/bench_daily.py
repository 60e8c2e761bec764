"""What a notebook feels: gains, sampling, responses, truncation, smoothing, extended filters, beside the peers that people come from."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator

import control
import numpy as np
from stopwatch import Row, median

from observer_lab.engine import (
    ExtendedKalmanFilter,
    KalmanFilter,
    Plant,
    Scenario,
    balanced_truncation,
    c2d,
    lqr,
    observability,
    simulate,
    smooth,
)

REDUCED = 4
LQR_LIMITS = {
    4: "finding the units of the states takes 0.5 of the time, by_hamiltonian 0.1, the rest are small arrays, call by call",
    20: "finding the units of the states, by A and then with B and Q, takes 0.4 of the time, by_hamiltonian 0.26",
    60: "by_hamiltonian, the Schur form of the Hamiltonian matrix, takes 0.72 of the time, lyapunov 0.16, dgeev 0.06",
    120: "by_hamiltonian, the Schur form of the Hamiltonian matrix, takes 0.68 of the time, lyapunov 0.19, dgeev 0.09",
}


def stable(n: int, seed: int = 0, m: int = 2, p: int = 2) -> Plant:
    """A random stable plant of n states."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) / np.sqrt(n)
    return Plant(A - (np.linalg.eigvals(A).real.max() + 0.2) * np.eye(n), rng.standard_normal((n, m)), rng.standard_normal((p, n)))


def varied(plant: Plant) -> Callable[[int], Plant]:
    """Plant k of a row of plants that differ in their twelfth digit."""
    return lambda k: Plant(plant.A * (1 + 1e-12 * k), plant.B, plant.C)


def varied_system(plant: Plant) -> Callable[[int], control.StateSpace]:
    """The same for the peer."""
    return lambda k: control.ss(plant.A * (1 + 1e-12 * k), plant.B, plant.C, 0)


def with_slycot() -> bool:
    """Whether the Fortran library that python-control takes where it finds it is there."""
    try:
        import slycot  # noqa: F401
    except ImportError:
        return False
    return True


def gains() -> Iterator[Row]:
    """lqr beside python-control with SciPy and with slycot."""
    for n in (4, 20, 60, 120):
        plant = stable(n)
        Q, R = np.eye(n), np.eye(2)
        new = varied(plant)
        ours = median(lambda plant, Q=Q, R=R: lqr(plant.A, plant.B, Q, R), each=new)
        for method, goal in (("scipy", 1.4), ("slycot", 0.5 if n < 60 else 0.8)):
            if method == "scipy" or with_slycot():
                theirs = median(lambda plant, Q=Q, R=R, method=method: control.lqr(plant.A, plant.B, Q, R, method=method), each=new)
                yield Row(f"lqr, n = {n}", ours, f"control.lqr, {method}", theirs, goal,
                          limit=LQR_LIMITS[n])


def conversions() -> Iterator[Row]:
    """c2d, an initial response of 1000 samples, and truncation."""
    for n in (20, 60, 200):
        plant = stable(n)
        system = control.ss(plant.A, plant.B, plant.C, 0)
        off = np.abs(c2d(plant, 0.1).A - system.sample(0.1).A).max()
        yield Row(f"c2d, n = {n}", median(lambda plant: c2d(plant, 0.1), each=varied(plant)), "control.c2d",
                  median(lambda system: control.c2d(system, 0.1, "zoh"), each=varied_system(plant)), 0.8, said=f"differ by {off:.1e}",
                  limit="finding the units of states and inputs takes 0.65 of the time, the Plant made 0.13, expm 0.1; from 48 states on "
                        "step_by_doubling takes 0.9")
        x0, t = np.ones(n), np.linspace(0, 10, 1001)
        run = Scenario(plant, x0=x0, horizon=10.0, dt=0.01)
        off = np.abs(simulate(run).x[:1001] - control.initial_response(system, t, x0).states.T).max()
        yield Row(f"initial response, n = {n}, 1000 steps", median(lambda run=run: simulate(run)), "control.initial_response",
                  median(lambda system=system, t=t, x0=x0: control.initial_response(system, t, x0)), 0.8, said=f"differ by {off:.1e}",
                  limit="a Scenario has an observer beside the plant: 2n states are stepped where the peer has n")
    if with_slycot():
        for n in (20, 60, 200):
            plant = stable(n)
            yield Row(f"truncation, n = {n}", median(lambda plant: balanced_truncation(plant, REDUCED), each=varied(plant)),
                      "control.balred, slycot", median(lambda system: control.balred(system, REDUCED), each=varied_system(plant)), 0.5,
                      limit="of 20 states finding units, of A, with B, with C and of the dual, takes 0.5 of the time; slycot proves "
                            "nothing and makes one pass")


def observed() -> Iterator[Row]:
    """The rank of observability."""
    for n in (4, 20):
        plant = stable(n)
        yield Row(f"observability rank, n = {n}", median(lambda plant: observability(plant).rank, each=varied(plant)),
                  "matrix_rank of control.obsv",
                  median(lambda plant: np.linalg.matrix_rank(control.obsv(plant.A, plant.C)), each=varied(plant)), 0.5,
                  limit="finding the units of the states, without which a rank depends on them, takes 0.75 of the time")


def smoothing() -> Iterator[Row]:
    """A smoother of 2,000 samples of two states beside statsmodels."""
    try:
        from statsmodels.tsa.statespace.mlemodel import MLEModel
    except ImportError:
        return
    rng = np.random.default_rng(0)
    A, C, Q, R, y = np.array([[1.0, 0.1], [0.0, 0.95]]), np.array([[1.0, 0.0]]), np.diag([1e-3, 1e-2]), np.eye(1), np.cumsum(
        rng.standard_normal(2000))
    kf, start = KalmanFilter(A, np.zeros((2, 1)), C, Q, R), (np.zeros(2), np.eye(2))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        peer = MLEModel(y, k_states=2, initialization="known", initial_state=np.zeros(2), initial_state_cov=np.eye(2))
    for name, value in (("design", C), ("transition", A), ("selection", np.eye(2)), ("state_cov", Q), ("obs_cov", R)):
        peer[name] = value
    off = np.abs(smooth(kf, kf.run(start, y)).means - peer.ssm.smooth().smoothed_state.T).max()
    yield Row("smoother, 2,000 samples", median(lambda: smooth(kf, kf.run(start, y))), "statsmodels", median(lambda: peer.ssm.smooth()), 1,
              said=f"differ by {off:.1e}")


def extended() -> Iterator[Row]:
    """An extended filter of a pendulum, 400 samples, and 100 irregular fixes of a vehicle, beside FilterPy."""
    from filterpy.kalman import ExtendedKalmanFilter as Peer
    from filterpy.kalman import KalmanFilter as Plain

    Q, R, y = np.diag([1e-6, 1e-4]), np.eye(1) * 0.01, np.sin(np.arange(400) / 30)[:, None]

    def f(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.stack([x[0] + 0.01 * x[1], x[1] - 0.1 * np.sin(x[0])])

    def F(x: np.ndarray) -> np.ndarray:
        return np.array([[1.0, 0.01], [-0.1 * np.cos(x[0]), 1.0]])

    def theirs() -> np.ndarray:
        peer = Peer(2, 1)
        peer.x, peer.P, peer.Q, peer.R, means = np.zeros((2, 1)), np.eye(2), Q, R, []
        for seen in y:
            peer.update(seen[:, None], lambda x: np.array([[1.0, 0.0]]), lambda x: x[:1])
            means.append(peer.x[:, 0])
            peer.F = F(peer.x[:, 0])
            peer.x = f(peer.x, None)
            peer.P = peer.F @ peer.P @ peer.F.T + Q
        return np.array(means)

    given = {"f_expand": lambda x, u: (f(x, u), F(x[:, 0])[None]), "h_expand": lambda x, u: (x[:1], np.array([[[1.0, 0.0]]]))}
    for name, ekf in (("slopes given", ExtendedKalmanFilter(f, lambda x, u: x[:1], Q, R, **given)),
                      ("slopes by complex step", ExtendedKalmanFilter(f, lambda x, u: x[:1], Q, R))):
        off = np.abs(ekf.run((np.zeros(2), np.eye(2)), y).means - theirs()).max()
        yield Row(f"extended filter, 400 samples, {name}", median(lambda ekf=ekf: ekf.run((np.zeros(2), np.eye(2)), y)),
                  "filterpy, slopes given", median(theirs), 1, said=f"differ by {off:.1e}",
                  limit="the maps given take 0.25 of the time, joseph 0.13, what `filtered` stores 0.12: gains, S, covariances are kept")
    yield _irregular(Plain)


def _irregular(peer: Callable[..., object]) -> Row:
    rng = np.random.default_rng(0)
    t, fixes = np.cumsum(rng.exponential(1.0, 100)), rng.standard_normal((100, 2))
    A, B, C = np.kron(np.eye(2), [[0, 1], [0, 0]]), np.kron(np.eye(2), [[0], [1]]), np.kron(np.eye(2), [[1, 0]])
    kf = KalmanFilter.from_plant(Plant(A, B, C), 0.1, 1.0, dt=1.0)

    def theirs() -> np.ndarray:
        one = peer(4, 2)
        one.x, one.P, one.H, one.R, means = np.zeros((4, 1)), np.eye(4), C, np.eye(2), []  # type: ignore[attr-defined]
        for k in range(100):
            if k:
                h = t[k] - t[k - 1]
                one.F = np.kron(np.eye(2), [[1, h], [0, 1]])  # type: ignore[attr-defined]
                one.predict(Q=np.kron(0.1 * np.eye(2), [[h**3 / 3, h**2 / 2], [h**2 / 2, h]]))  # type: ignore[attr-defined]
            one.update(fixes[k][:, None])  # type: ignore[attr-defined]
            means.append(one.x[:, 0])  # type: ignore[attr-defined]
        return np.array(means)

    off = np.abs(kf.run((np.zeros(4), np.eye(4)), fixes, t=t).means - theirs()).max()
    return Row("100 irregular fixes, four states", median(lambda: kf.run((np.zeros(4), np.eye(4)), fixes, t=t)), "filterpy", median(theirs),
               0.5, said=f"differ by {off:.1e}")


def rows() -> Iterator[Row]:
    """All rows about daily work."""
    yield from gains()
    yield from conversions()
    yield from observed()
    yield from smoothing()
    yield from extended()
