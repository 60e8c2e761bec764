"""Judge a fitted filter by all evidence of unused rows; each test allows for the errors of the fit."""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr
from scipy.special import chdtr, chdtri, fdtrc

from ..filters import KalmanFilter, Track
from ..systems.errors import Phrase, phrase
from ..systems.records import record as a_record
from ..systems.recursions import affine_scan
from .predictor import responses
from .records import Record

__all__ = [
    "FEEDBACK",
    "INPUT",
    "LEAST_FIT",
    "MOST_FREE",
    "SAME_ROW",
    "WHITE",
    "Evidence",
    "evidence_of",
    "mean_below",
    "padded",
    "partly_seen",
    "whitened",
]

MAX_LAGS = 20
ROWS_PER_COLUMN = 8  # rows that pay for one column of a regression
PLAIN = 1000.0  # the test without the errors of the fit fails at that part of WHITE: it sees a fit whose errors are no longer small
MOST_ENTRIES = 20_000_000  # of a regression
OWN_GAINS = 20_000  # rows of a record with gaps in which each has the gain of its own
RANK = 1e-8
WHITE, INPUT, FEEDBACK, SAME_ROW = 0.02, 0.015, 0.003, 1e-4  # p-values below which a test fails; with the NIS at 1 % five in a hundred
MOST_FREE = 2.5  # times the free run's error that Q and R let expect; true orders of the lesson's records stay below 1.5
LEAST_FIT = 0.05  # of the output's variation, below which a prediction explains nothing


@a_record()
class Evidence:
    """What the unused rows say about a fitted filter, test by test.

    radius: largest |pole|. nis: whether the mean NIS lies in its band. white, input, feedback: p-values of the innovations being
    unrelated to earlier innovations, to earlier inputs and to later inputs, each beside all errors of the fitted parameters.
    same_row: p-value of the output being unrelated to the input of its own row. fit: share of the variation that one-step predictions
    give, the least over the outputs; free_run: the same for the model without measurements, free_size: how many times larger its error
    is than Q and R let expect, the most over the outputs; both NaN without inputs.
    Sources: Breusch, Australian Economic Papers 17 (1978) 334–355; Godfrey, Econometrica 46 (1978) 1293–1301.
    """

    radius: float
    nis: bool
    white: float
    input: float
    feedback: float
    same_row: float
    fit: float
    free_run: float
    free_size: float

    @property
    def stable(self) -> bool:
        """Whether every pole of the fit lies inside the unit circle."""
        return self.radius < 1

    @property
    def open_loop(self) -> bool:
        """Whether no input follows an innovation, nor stands beside the output of its own row."""
        return self.feedback >= FEEDBACK and self.same_row >= SAME_ROW

    @property
    def failures(self) -> tuple[Phrase, ...]:
        """A sentence for each check that fails, the gravest first; none for a consistent filter."""
        said = []
        if not self.stable:
            said.append(phrase("The fitted model is unstable: its largest pole has the modulus {radius:.3g}.", radius=self.radius))
        if self.feedback < FEEDBACK:
            said.append(phrase("Later inputs are related to the innovations (p = {p:.2g}): the record comes from a running loop, or the "
                               "dead time is too long. Record with the loop open.", p=self.feedback))
        elif self.same_row < SAME_ROW:
            said.append(phrase("The output is related to the input of its own row (p = {p:.2g}): the input may be computed from it. "
                               "Record with the loop open.", p=self.same_row))
        if self.input < INPUT:
            said.append(phrase("The innovations depend on earlier inputs (p = {p:.2g}): order or dead time is wrong.", p=self.input))
        if self.white < WHITE:
            said.append(phrase("The innovations are not white (p = {p:.2g}): a better model could predict a part of them.", p=self.white))
        if self.fit < LEAST_FIT:
            said.append(phrase("Predictions explain {fit:.2g} % of the output's variation: the record does not show the plant.",
                               fit=100 * self.fit))
        if self.stable and self.free_size > MOST_FREE:
            said.append(phrase("Without measurements the model errs {times:.2g} times more than its Q and R let expect: it misses "
                               "something slow.", times=self.free_size))
        return tuple(said)

    @property
    def consistent(self) -> bool:
        """Whether every check passes."""
        return self.nis and not self.failures


def evidence_of(kf: KalmanFilter, track: Track, record: Record, first: int, nis: bool, fit: np.ndarray, tuned: bool = False,
                biases: int = 0) -> Evidence:
    """All tests of the innovations in the rows from `first` on; `tuned` if the gain was set by hand. The last `biases` states are no
    poles of the plant."""
    e, slopes, seen = _slopes(kf, track, record, first, tuned)
    own = kf.n - biases
    radius = float(np.abs(np.linalg.eigvals(kf.A[:own, :own])).max(initial=0.0))
    u = record.u[first:]
    p = kf.C.shape[0]
    count = int(seen.sum()) // p
    room = max(min(count * p // ROWS_PER_COLUMN, MOST_ENTRIES // max(count * p, 1)), 1)
    lags = int(np.clip(min(MAX_LAGS, count // 4, room // (p * p)), 1, MAX_LAGS))
    past = _by_output(_lagged(e, range(1, lags + 1)), p)
    plain = _added(e, slopes[:, :, :0], past, seen)  # a gain by hand has no error of a fit to allow for
    white = plain if tuned else min(_added(e, slopes, past, seen), PLAIN * plain, 1.0)
    if not u.shape[1]:
        return Evidence(radius, nis, white, 1.0, 1.0, 1.0, float(fit.min()), float("nan"), float("nan"))
    m = u.shape[1]
    reach = int(np.clip(min(MAX_LAGS, room // (p * m)), 1, MAX_LAGS))
    earlier = _by_output(_lagged(u, range(0, reach)), p)
    ahead = int(np.clip(reach // 4, 1, 5))
    later = _by_output(_lagged(u, range(-ahead, 0)), p)
    inner = seen.copy()
    inner[:reach] = False
    inner[len(inner) - ahead:] = False
    return Evidence(radius, nis, white, _added(e, slopes, earlier, inner),
                    _added(e, np.concatenate([slopes, past, earlier], axis=2), later, inner), _same_row(kf, e, slopes, seen),
                    float(fit.min()), *_free_run(kf, track, record, first))


def _slopes(kf: KalmanFilter, track: Track, record: Record, first: int, tuned: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whitened innovations e (N, p), their slopes over every parameter (N, p, c), and which readings came (N, p); 0 where none did.

    x̂⁺ = A x̂ + B u + K e, e = y − C x̂ − D u: with dA, … the error of x̂ follows dx⁺ = (A − K C) dx + dA x̂ + dB u + dK e − K (dC x̂ + dD u),
    de = −C dx − dC x̂ − dD u. The last columns are a constant for each output; those of D stand first.
    """
    n, p = kf.n, kf.C.shape[0]
    x, u = track.predicted[first:], record.u[first:]
    nu = track.innovations[first:]
    seen = np.isfinite(nu)
    own = not seen.all() and len(nu) <= OWN_GAINS  # a missing reading has the gain 0, so each row has its own
    settled = int(seen.sum(axis=1)[::-1].argmax()) + 1
    K = kf.A @ (track.gains[first:] if own else track.gains[-settled])
    steady = kf.A - K @ kf.C
    e = np.where(seen, nu, 0.0)
    N = len(x)
    columns, wide = [], []

    def add(forcing: np.ndarray, direct: np.ndarray) -> None:
        if own:
            wide.append((forcing, direct))
        else:
            dx = affine_scan(steady, forcing - direct @ K.T, np.zeros(n), N)[:N]
            columns.append(-dx @ kf.C.T - direct)
    eye_n, eye_p, none_n, none_p = np.eye(n), np.eye(p), np.zeros((N, n)), np.zeros((N, p))
    for column in u.T:
        for i in range(p):
            add(none_n, np.outer(column, eye_p[i]))
    for column in (*x.T, *u.T, *(() if tuned else e.T)):
        for i in range(n):
            add(np.outer(column, eye_n[i]), none_p)
    for column in x.T:
        for i in range(p):
            add(none_n, np.outer(column, eye_p[i]))
    if own:
        forcings, directs = (np.stack(part, axis=2) for part in zip(*wide, strict=True))
        dx = responses(steady, forcings - K @ directs, np.zeros((n, len(wide))))
        columns = list(np.moveaxis(-kf.C @ dx - directs, 2, 0))
    table = np.stack([*columns, *(np.broadcast_to(row, (N, p)) for row in eye_p)], axis=2)
    roots = np.linalg.cholesky(padded(track.S[first:], seen))
    both = np.where(seen[:, :, None], np.concatenate([e[:, :, None], table], axis=2), 0.0)
    white = np.linalg.solve(roots, both) if p > 1 else both / roots
    return white[:, :, 0], white[:, :, 1:], seen


def _lagged(columns: np.ndarray, lags: range) -> np.ndarray:
    """Columns moved down by each of the lags (up by negative ones), zero where they leave the record: (N, columns·lags)."""
    out = []
    for lag in lags:
        moved = np.zeros_like(columns)
        if lag > 0:
            moved[lag:] = columns[:-lag]
        elif lag < 0:
            moved[:lag] = columns[-lag:]
        else:
            moved[:] = columns
        out.append(moved)
    return np.hstack(out)


def _by_output(regressors: np.ndarray, p: int) -> np.ndarray:
    """The same regressors for each output alone: (N, p, p·columns)."""
    return np.einsum("tc,ij->tijc", regressors, np.eye(p)).reshape(len(regressors), p, -1)


def _added(e: np.ndarray, base: np.ndarray, added: np.ndarray, rows: np.ndarray) -> float:
    """The p-value of the added columns explaining nothing of e beside the base, by an F test over the readings in `rows` (N, p)."""
    target = e[rows]
    if len(target) < base.shape[2] + 2 * added.shape[2]:
        return 1.0
    Q, rank = _basis(base[rows])
    left = target - Q @ (Q.T @ target)
    more = added[rows]
    more = more - Q @ (Q.T @ more)
    E, extra = _basis(more - Q @ (Q.T @ more))
    gained, rest, free = float(np.sum((E.T @ left) ** 2)), float(left @ left), len(target) - rank - extra
    if not extra or free < 2 or rest <= 0:
        return 1.0
    return float(fdtrc(extra, free, gained / extra / max((rest - gained) / free, 1e-300)))


def _basis(table: np.ndarray) -> tuple[np.ndarray, int]:
    """An orthonormal basis of the columns of a table, and their rank."""
    size = np.linalg.norm(table, axis=0)
    kept = table[:, size > 1e-12 * size.max(initial=1e-300)]
    if not kept.shape[1]:
        return np.zeros((len(table), 0)), 0
    Q, R, _ = qr(kept / np.linalg.norm(kept, axis=0), mode="economic", pivoting=True)
    rank = int(np.count_nonzero(np.abs(np.diag(R)) > RANK * abs(R[0, 0])))
    return Q[:, :rank], rank


def _same_row(kf: KalmanFilter, e: np.ndarray, slopes: np.ndarray, rows: np.ndarray) -> float:
    """The p-value of D being zero: e of the model without D, against the columns of D beside all others."""
    count = kf.D.size
    direct, others = slopes[:, :, :count], slopes[:, :, count:]
    without = e - direct @ kf.D.T.reshape(-1)
    return _added(without, others, direct, rows)


def _free_run(kf: KalmanFilter, track: Track, record: Record, first: int) -> tuple[float, float]:
    """The least share of an output's variation that the model gives from the inputs alone, from the filter's state at `first`.

    And the most that an output's error is larger than its variance C P Cᵀ + R lets expect, P⁺ = A P Aᵀ + Q without corrections.
    """
    u, y = record.u[first:], record.y[first:]
    x = affine_scan(kf.A, u @ kf.B.T, track.predicted[first], len(u))[:len(u)]
    found = x @ kf.C.T + u @ kf.D.T
    expected, P = np.empty_like(y), track.schedule.prior[min(first, len(track.schedule.prior) - 1)]
    for k in range(len(y)):
        expected[k] = np.diag(kf.C @ P @ kf.C.T + kf.R)
        before, P = P, kf.A @ P @ kf.A.T + kf.Q
        if np.allclose(P, before, rtol=1e-9, atol=0.0):
            expected[k + 1:] = np.diag(kf.C @ P @ kf.C.T + kf.R)
            break
    shares, sizes = [], []
    for j in range(y.shape[1]):
        seen = np.isfinite(y[:, j])
        away, error = float(np.linalg.norm(y[seen, j] - y[seen, j].mean())), float(np.linalg.norm(y[seen, j] - found[seen, j]))
        shares.append(1 - error / max(away, 1e-300))
        sizes.append(error / max(float(np.sqrt(expected[seen, j].sum())), 1e-300))
    return min(shares), max(sizes)


def partly_seen(seen: np.ndarray) -> bool:
    """Whether some row of seen (N, p) has a part of its outputs."""
    return bool((seen.any(axis=1) & ~seen.all(axis=1)).any())


def padded(S: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """S (N, p, p) with the rows and columns of I for readings that did not come: neither S⁻¹ e nor det S counts them."""
    both = seen[:, :, None] & seen[:, None, :]
    return np.where(both, S, np.eye(S.shape[-1]))


def whitened(nu: np.ndarray, S: np.ndarray) -> np.ndarray:
    """S^{-½} ν (N, p) of the readings that came; NaN for the others."""
    seen = np.isfinite(nu)
    roots = np.linalg.cholesky(padded(S, seen))
    return np.where(seen, np.linalg.solve(roots, np.where(seen, nu, 0.0)[:, :, None])[:, :, 0], np.nan)


def mean_below(counts: np.ndarray, share: float) -> float:
    """Mean of χ² below its quantile `share`, over its mean without a limit, for rows of so many readings each."""
    own = np.maximum(counts, 1)
    return float(np.sum(counts * chdtr(own + 2, chdtri(own, 1 - share))) / share / max(float(np.sum(counts)), 1.0))
