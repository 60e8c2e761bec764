"""Equal effort: each controller is made as bold as the full LQG, and who leads then is found by other means."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from witnesses import Shown
from witnesses_of_effort import WITNESSES, moved

from observer_lab.lessons.showdown.controllers import ORDER, Player
from observer_lab.lessons.showdown.equal_effort import Equal, equal_effort, met, retuned
from observer_lab.lessons.showdown.lesson import LESSON
from observer_lab.lessons.showdown.rankings import equal
from observer_lab.lessons.showdown.simulation import loop_of
from observer_lab.lessons.showdown.study import Trials
from observer_lab.lessons.showdown.suppression import best_words

BEST = WITNESSES["Best by area: {short} vertically, {short2} in rotation, {short3} horizontally."]


def compared(**values: Any) -> tuple[Any, Equal]:
    """The outcome of a design, with the comparison alone as its trials."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), values))
    m, d = outcome.study, outcome.design
    *_, (_, found) = equal_effort(m.world, m.five, d["v"], d["pair"], float(m.forces[ORDER.index("lqe")].max()))
    assert found is not None and LESSON.job is not None
    return LESSON.job.shown(outcome, Trials((None,) * 5, equal=found)), found


def said(outcome: Any) -> str:
    return equal(outcome)[0].caption("en")


def test_with_the_dial_at_one_each_controller_is_the_one_on_the_page() -> None:
    for v, pair in ((1e-10, "own"), (1e-12, "published")):
        five = LESSON.compute(LESSON.apply(LESSON.start(), {"v": v, "pair": pair})).study.five
        for player in five[1:]:
            once_more = retuned(player.id, 1.0, v, pair)
            for name in "ABCD":
                ours, theirs = getattr(once_more, name), getattr(player.controller, name)
                np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9 * np.abs(theirs).max(initial=1e-300))


@pytest.mark.parametrize("values", [{}, {"sensor": 1e-14}, {"ground": "shaped", "delay": 2.0}])
def test_all_tell_their_coils_as_much_by_the_lyapunov_equation_of_each_loop(values: dict[str, Any]) -> None:
    """Forces and velocities from the stationary covariance of w, where the page integrates densities from 0.1 Hz up."""
    outcome, found = compared(**values)
    m, d = outcome.study, outcome.design
    assert found.dials[ORDER.index("lqe") - 1] == 1.0
    for i, id in enumerate(ORDER[1:]):
        loop = loop_of.__wrapped__(m.world, Player(id, m.five[0].name, retuned(id, float(found.dials[i]), d["v"], d["pair"])))
        P, T = loop.covariance, loop.T[-1]
        force = np.sqrt(np.diag(loop.feedback @ P @ loop.feedback.T + T @ loop.reading @ T.T)).max()
        assert found.forces[i] == pytest.approx(found.wanted, rel=2e-3) and force == pytest.approx(found.wanted, rel=0.03)
        if not values.get("ground"):
            rms = 1e6 * np.sqrt(np.diag(loop.outputs @ P @ loop.outputs.T))[:3]
            np.testing.assert_allclose(found.rms[i], rms, rtol=0.03)


def test_what_the_text_says_of_the_start() -> None:
    outcome, found = compared()
    siso, lqe, recursive = (ORDER.index(id) - 1 for id in ("siso", "lqe", "recursive"))
    assert 1 / found.dials[siso] == pytest.approx(24, abs=0.5) and 1e3 * found.wanted == pytest.approx(16.4, abs=0.05)
    for at, (low, high) in enumerate([(24.9, 25.1), (2.54, 3.77)]):
        assert (found.rms[lqe, at], found.rms[siso, at]) == pytest.approx((low, high), abs=0.06)
    assert found.dials[recursive] < 0.7 and "leads the SISO loops at this effort, or ties with them, in every channel" in said(outcome)
    quiet, _ = compared(v=1e-12, sensor=1e-12, limited=True, limit=0.001)
    assert "moves less than the SISO loops in every channel" in said(quiet) and "clipped often" in said(quiet)
    assert "with any gain" in said(compared(pair="published")[0])


def test_what_cannot_be_met_is_said_and_not_drawn() -> None:
    outcome, found = compared()
    assert all(cell != "–" for table in equal(outcome) for row in table.rows for cell in row)
    found.dials[0], found.rms[0] = np.nan, np.nan
    assert "cannot be made to spend that" in said(outcome) and all(table.rows[0][-1] == "–" for table in equal(outcome))
    assert np.isnan(met(lambda dial: 1 - 0.5 / (1 + dial), 2.0)) and np.isnan(met(lambda dial: np.inf, 1.0))
    assert met(lambda dial: dial**1.3 if dial < 3 else np.inf, 2.0) == pytest.approx(2 ** (1 / 1.3), rel=1e-3)
    assert met(lambda dial: 5 * np.sqrt(dial), 0.2) == pytest.approx(0.2**2 / 25, rel=3e-3)
    lost = LESSON.compute(LESSON.apply(LESSON.start(), {"v": 1e-18}))
    assert "no effort to meet" in said(lost)


def test_no_controller_is_called_the_best_where_none_is_stable() -> None:
    """The table of suppression once named the first of four unstable ones, at 0 dB like all of them."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"delay": 5.0, "v": 1e-15, "placement": 60.0}))
    assert not any(s.stable for s in outcome.study.spectra[1:])
    caption = next(f for f in LESSON.figures(outcome) if f.id == "suppression").caption("en")
    assert caption == "Unstable with these settings: SISO, LQE, recursive, decoupled."


def test_the_only_stable_controller_is_best_only_where_it_beats_the_open_loop() -> None:
    """Only the recursive filter is stable here. Its rival is the deck alone, and not an LQG for a noise 10⁹ times as large."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {
        "v": 1.8828616e-17, "sensor": 1.08667e-12, "pair": "published", "ground": "shaped", "delay": 0.26, "adc": 466.296,
        "drift": 8.363, "stiffness": -28.384, "damping": -27.954, "placement": -54.041}))
    m = outcome.study
    assert [id for id, s in zip(ORDER[1:], m.spectra[1:], strict=True) if s.stable] == ["recursive"]
    table = next(f for f in LESSON.figures(outcome) if f.id == "suppression")
    assert table.caption("en") == "Best by area: recursive vertically, none in rotation, none horizontally."
    bare, alone = (moved(m.world, id, 1.0, outcome.design["v"], "published") for id in ("open", "recursive"))
    assert bare is not None and alone is not None
    np.testing.assert_allclose(m.band_db[ORDER.index("recursive")], 20 * np.log10(bare.band / alone.band), atol=0.1)
    shown = Shown(LESSON, outcome, table)
    BEST(shown, table.caption)
    with pytest.raises(AssertionError, match="dB behind the best"):
        BEST(shown, best_words(np.where([[False], [False], [True], [False]], np.ones((4, 3)), -np.inf)))


def test_the_bars_are_the_suppression_of_each_stable_loop_beside_what_is_asked() -> None:
    """A loop that is not stable has a cross at zero and no bar."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"delay": 5.0}))
    figure = next(f for f in LESSON.figures(outcome) if f.id == "suppression")
    m, lost = outcome.study, [i for i in range(1, 5) if not outcome.study.spectra[i].stable]
    assert lost and len(lost) < 4
    kept = [i for i in range(1, 5) if i not in lost]
    bars = [curve for curve in figure.curves if curve.width > 3]
    assert [curve.y[1] for curve in bars] == [m.band_db[i, j] for i in kept for j in range(3)]
    assert [mark.y for mark in figure.points if mark.mark == "dot"] == [m.peak_db[i, j] for i in kept for j in range(3)]
    assert [mark.y for mark in figure.points if mark.mark == "cross"] == [0.0] * 3 * len(lost)
    assert [curve.name("en") for curve in figure.curves if "unstable" in curve.name("en")] and list(figure.curves[-1].y) == [20.0, 20.0]
