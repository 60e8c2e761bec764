"""Witnesses for observers of less than the state, robust and bilinear ones: their matrices asked again, their noise summed up."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import expm
from witnesses import Shown, Witness, near, rightmost, value

from observer_lab.course.figures.records import LineFigure
from observer_lab.lessons.robust_observer.study import errors
from observer_lab.plants.bilinear import PRINTED_FORM
from observer_lab.text import Text


# --- bilinear -----------------------------------------------------------------------------------------------------------
def _law(shown: Shown, _: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    mine, law = (c.y for c in figure.curves[:2])
    off = float(np.max(np.abs(np.abs(mine) - np.abs(law)))) / max(float(np.max(np.abs(law))), 1e-12)
    assert off < 1e-5, f"leaves the line by {off:.2g} of its peak"


def _silent(shown: Shown) -> np.ndarray:
    """(V₂ − L V₁) A T₂, if L takes u and the rest of the state out of the error: asked of its matrices."""
    study = shown.outcome.study
    o, L = study.observer, shown.outcome.gains["L"]
    P, (_, T2, T3), A = o.V[1] - L @ o.V[0], o.T, o.plant.A
    each = np.hsplit(o.plant.F, o.plant.B.shape[1])
    for M, X in (*((F, T2) for F in each), (A, T3), *((F, T3) for F in each)):
        terms = (np.abs(o.V[1]) + np.abs(L) @ np.abs(o.V[0])) @ np.abs(M) @ np.abs(X)
        scale = np.maximum(terms, 1e-6 * terms.max(initial=0.0))
        off = np.max(np.abs(P @ M @ X) / np.where(scale > 0, scale, 1.0), initial=0.0)
        assert off < 1e-8, f"L lets u or the state into the error: {off:.2g}"
    return P @ A @ T2


def _silenced(shown: Shown, _: Text) -> None:
    _silent(shown)


def _dies_out(shown: Shown, _: Text) -> None:
    run, pole = shown.outcome.study.run, rightmost(_silent(shown))
    assert pole < 0, "the error does not die out"
    if shown["kick"] < 0 and shown["form"] != "filtered":
        size = np.abs(run.errors.reshape(len(run.t), 3, -1)[:, ("plain", "exact").index(shown["form"])])
        floor = 1e-6 * max(1.0, float(np.abs(run.g).max()))
        assert np.all(size[-1] <= 1e3 * np.exp(pole * run.t[-1]) * size.max() + floor), "the run ends with an error"


def _noise_of(shown: Shown, words: Text) -> None:
    """The promise at u = 0 as a sum over all past steps of what one held value does, by matrix exponentials."""
    study = shown.outcome.study
    own = study.setting.own
    L = shown.outcome.gains["L"]
    exact, plain = study.observer.forms(L)
    sigma = np.full(L.shape[1], shown["noise"])
    if own:  # a share of what each sensor reads at most in the run at the start
        first = shown.lesson.compute(shown.lesson.start()).study.run.x @ study.observer.plant.C.T
        sigma = sigma / 100 * np.abs(first).max(axis=0)
    size = np.maximum(np.abs(study.run.g).max(axis=0), 1e-300) if own else np.ones(1)
    form, tau, h, q, m = shown["form"], shown["tau"], float(study.run.t[1]), len(L), L.shape[1]
    if not own and (shown["problem"], shown["gain"]) == ("paper", "rounded"):  # what runs then is step 8 as the paper prints it
        plain = PRINTED_FORM
    A, Y, G, H = plain.A, plain.Y, plain.G_y, plain.G_z
    if form != "plain":
        A, Y, G, H = exact.A, exact.Y, exact.G_y, exact.G_z
    if form == "filtered":  # (L y − d)/τ stands for L ẏ
        A = np.block([[A, -np.eye(q) / tau], [np.zeros((q, q)), -np.eye(q) / tau]])
        Y, H = np.vstack([Y + L / tau, L / tau]), np.hstack([H, np.zeros_like(H)])
    step = expm(np.block([[A, Y * sigma], [np.zeros((m, len(A) + m))]]) * h)
    Phi, z = step[:len(A), :len(A)], step[:len(A), len(A):]
    total = np.sum((G * sigma) ** 2, axis=1)
    for _ in range(200_000):
        more = np.sum((H @ z) ** 2, axis=1)
        total, z = total + more, Phi @ z
        if np.all(more <= 1e-9 * total):
            break
    near(value(words, "promised"), float(np.max(np.sqrt(total) / size)), 1e-3)
    late = study.run.heard.reshape(len(study.run.t), 3, -1)[len(study.run.t) // 2:, ("plain", "exact", "filtered").index(form)] / size
    near(value(words, "rms"), float(np.max(np.sqrt(np.mean(late ** 2, axis=0)))), 1e-6)


# --- robust -------------------------------------------------------------------------------------------------------------
def missed(shown: Shown) -> np.ndarray:
    """û − Kx of a robust observer on the true plant (n_t,): the loop written out and joined to the oscillator that makes v."""
    d, o = shown.outcome.design, shown.outcome.study.observer
    A, B, C = o.plant.A, o.plant.B, o.plant.C
    dA, _, dC = errors(d)
    true_A, true_B, true_C = A + dA, (1 + d["input"]) * B, C + dC
    steer, turns = -np.hstack([o.M @ true_C, o.N]), np.array([[0.0, 5.0], [-5.0, 0.0]])
    n, q = len(A), o.order
    open_loop = np.block([[true_A, np.zeros((n, q))], [o.L @ true_C, o.F]])
    drive = np.vstack([true_B, o.T @ B])
    whole = np.block([[open_loop + drive @ steer, drive @ np.array([[-4.0, 0.0]])], [np.zeros((2, n + q)), turns]])
    state = np.concatenate([shown.outcome.study.true.x[0], shown.outcome.study.true.z[0], [1.0, 0.0]])  # sin, cos of 5t + π/2
    step, out = expm(whole * 0.015), []
    for _ in range(401):
        out.append(float((steer @ state[:-2] + o.K @ state[:n])[0]))
        state = step @ state
    return np.abs(np.array(out))


def _misses(shown: Shown, words: Text) -> None:
    far = missed(shown)
    near(value(words, "late_error"), min(float(far[301:].max()), 1e3), 1e-4)


def _settles(shown: Shown, words: Text) -> None:
    late = float(missed(shown)[301:].max())
    assert late < 1.21 * value(words, "steady") + 1e-6, f"at the end it is still {late:.3g}"


def _fixed(shown: Shown, words: Text) -> None:
    """N and M are the only solution: the rows of [T; C] span K, and none depends on the others."""
    g, C = shown.outcome.gains, shown.outcome.study.observer.plant.C
    rows = np.vstack([g["T"], C])
    solved = np.linalg.lstsq(rows.T, g["K"].T, rcond=None)[0].T @ rows
    near(value(words, "rank"), float(len(rows)))
    assert np.linalg.norm(solved - g["K"]) < 1e-8 * np.linalg.norm(g["K"]) and np.linalg.matrix_rank(rows, tol=1e-12) == len(rows)


def _unstable_loop(shown: Shown, _: Text) -> None:
    assert shown.outcome.metrics["slowest_loop"] >= 0


WITNESSES: Mapping[str, Witness] = {
    "|ε| follows e^({pole}t) to within {law_gap:.0e} of its peak, whatever u does.": _law,
    "|ε| follows ẇ = A_L w to within {law_gap:.0e} of its peak, whatever u does.": _silenced,
    "Case {case}: one state estimates g, and ε decays as e^({pole}t) under this u.": _dies_out,
    "Case {case}: an observer of order {order} estimates g, and ε decays under this u; poles: {poles}.": _dies_out,
    "The sensors' noise moves ĝ by {rms:.2g} (rms, second half of the run); at rest and u = 0 its law says {promised:.2g}.": _noise_of,
    "The sensors' noise moves ĝ by {rms:.2g} of g (rms, second half of the run); at rest and u = 0 its law says {promised:.2g}.": _noise_of,
    "With the true plant the loop is unstable.": _unstable_loop,
    "On the true plant û misses the wanted input by up to {late_error:.2g} at the end.": _misses,
    "The {rows} rows of [T; C] have rank {rank}, and with K no more: N and M exist and are fixed.": _fixed,
    "With the true plant e_u settles to an amplitude of {steady:.2g}; on the model it decays.": _settles,
}
