"""Lesson 9: the gain converges to Riccati, the tuned filter is consistent, the wrong ones are found out."""

from __future__ import annotations

import control
import numpy as np
import pytest
from lesson_checks import by_knobs, carried
from scipy.linalg import expm, solve_discrete_are
from scipy.stats import binom, chi2

from observer_lab.engine import chi2_band
from observer_lab.lessons.kalman.all_records import expected
from observer_lab.lessons.kalman.deck_figures import PRINTED_MEAN, PRINTED_SAMPLES, PRINTED_SIGMA
from observer_lab.lessons.kalman.filters import ADC, SENSOR_SIGMA, UNTESTED_SAMPLES, compare, truth, tuned, watch, watcher
from observer_lab.lessons.kalman.job import RUN_COUNT
from observer_lab.lessons.kalman.knobs import DT, MODEL
from observer_lab.lessons.kalman.lesson import LESSON
from observer_lab.lessons.kalman.noise_identification import fitted


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def flags(o) -> set[str]:
    return {c.id for c in o.checks if not c.holds}


@pytest.fixture(scope="module")
def tried():
    """The button pressed for three filters: NIS and NEES of many runs."""
    def press(**changes):
        *_, (fraction, done) = LESSON.job.outcomes(outcome(**changes))
        assert fraction == 1.0 and done.study.trials.count == RUN_COUNT
        return done.metrics
    return {"tuned": press(q=1.0, r=1.0), "decoy": press(), "carried": press(noise="carried", q=1.0, r=1.0)}


# --- the gain --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("q, r, p0", [(1.0, 1.0, 1.0), (20.0, 0.47, 100.0), (0.3, 2.0, 0.01)])
def test_the_recursion_ends_at_the_riccati_solution(q, r, p0):
    who = watcher("white", q, r, p0)
    kf = who.filter
    P = solve_discrete_are(kf.A.T, kf.C.T, kf.Q, kf.R)
    M = P @ kf.C.T @ np.linalg.inv(kf.C @ P @ kf.C.T + kf.R)
    assert np.allclose(who.schedule.gains[-1], M, atol=1e-6 * np.abs(M).max())
    L, _, _ = control.dlqe(kf.A, np.eye(6), kf.C, kf.Q, kf.R)
    assert np.allclose(L, kf.A @ who.schedule.gains[-1], atol=1e-6 * np.abs(M).max())  # the predictor gain A M


def test_the_model_is_sampled_exactly():
    kf = tuned()
    assert np.allclose(kf.A, expm(MODEL.plant.A * DT), atol=1e-12)
    assert np.allclose(kf.R, SENSOR_SIGMA**2 * np.eye(4))


def test_one_step_by_hand_is_the_first_step_of_the_record():
    who, what = watcher("white", 1.0, 1.0, 1.0), truth(1, False, 1.0, -1.0)
    kf, P = who.filter, who.start.covariance
    track = watch(who, what)
    S = kf.C @ P @ kf.C.T + kf.R
    M = P @ kf.C.T @ np.linalg.inv(S)
    x = M @ what.y[0]
    after = (np.eye(6) - M @ kf.C) @ P
    assert np.allclose(track.means[0], x, atol=1e-12)
    assert np.allclose(who.schedule.posterior[0], after, atol=1e-14)
    assert np.allclose(track.predicted[1], kf.A @ x + kf.B @ what.u[0], atol=1e-12)
    assert np.allclose(who.schedule.prior[1], kf.A @ after @ kf.A.T + kf.Q, atol=1e-14)


# --- the tests of consistency ----------------------------------------------------------------------------------------
@pytest.mark.slow
def test_tuned_nis_is_the_number_of_measurements_and_nees_of_states(tried):
    """NIS of different samples are independent: χ² over all of them. NEES is not: a wider look, from a tenth of them."""
    for name in ("tuned", "carried"):
        low, high = chi2.ppf([5e-4, 1 - 5e-4], 4 * 251 * RUN_COUNT) / (251 * RUN_COUNT)
        assert low < tried[name]["trials_nis"] < high, name
        low, high = chi2.ppf([5e-4, 1 - 5e-4], 6 * 5 * RUN_COUNT) / (5 * RUN_COUNT)
        assert low < tried[name]["trials_nees"] < high, name


@pytest.mark.slow
def test_the_decoy_has_a_fitting_nis_and_a_hopeless_nees(tried):
    assert 3.6 < tried["decoy"]["trials_nis"] < 4.5
    assert tried["decoy"]["trials_nees"] > 30


@pytest.mark.parametrize("changes, expected", [
    ({"q": 1.0, "r": 1.0}, set()), ({}, {"white", "nees"}), ({"q": 1.0, "r": 0.1}, {"nis", "nees"}),
    ({"q": 1.0, "r": 10.0}, {"nis"}), ({"q": 0.01, "r": 1.0}, {"nis", "white", "nees"}), ({"q": 100.0, "r": 1.0}, {"nis", "white"}),
    ({"noise": "coloured", "q": 1.0, "r": 1.0}, {"white"}), ({"noise": "carried", "q": 1.0, "r": 1.0}, set()),
])
def test_detuned_filters_are_flagged(changes, expected):
    found = flags(outcome(**changes))
    assert expected <= found if expected else not found


@pytest.mark.slow
def test_how_often_the_right_filter_is_flagged_is_what_the_levels_say():
    """240 seeds: innovation tests at 5 %, NEES at 5 %, together one record of ten. Bounds at 1e-3 of those rates."""
    runs = [outcome(seed=seed, q=1.0, r=1.0) for seed in range(240)]
    by_innovations = sum(bool(o.metrics["failures"]) for o in runs)
    by_nees = sum(o.study.settled.verdict != "consistent" for o in runs)
    low, high = binom.ppf([5e-4, 1 - 5e-4], len(runs), 0.05)
    assert low <= by_innovations <= high and low <= by_nees <= high
    low, high = binom.ppf([5e-4, 1 - 5e-4], len(runs), 0.0975)
    assert low <= sum(bool(flags(o) - {"riccati"}) for o in runs) <= high


@pytest.mark.slow
def test_251_errors_count_as_thirty():
    """Var of the mean of NEES over 240 records is 2n/N′; 251 independent ones would have an eighth of it."""
    runs = [outcome(seed=seed, q=1.0, r=1.0) for seed in range(240)]
    count = runs[0].study.watcher.independent.value
    assert count == pytest.approx(30.5, abs=0.1) and len(runs[0].study.settled.values) == 251
    assert np.var([o.study.settled.mean for o in runs]) == pytest.approx(12 / count, rel=0.35)  # 3.5 of its σ


@pytest.mark.slow
@pytest.mark.parametrize("noise, q, r", [("white", 1.0, 1.0), ("white", 0.05, 1.73), ("white", 20.0, 0.47), ("white", 0.3, 1.0),
                                         ("coloured", 1.0, 1.0), ("carried", 1.0, 1.0), ("carried", 3.0, 1.0)])
def test_expected_statistics_are_the_averages_of_records(noise, q, r):
    e = expected(noise, q, r)
    runs = [outcome(noise=noise, q=q, r=r, seed=seed) for seed in range(60)]

    def near(values, wanted):
        assert abs(np.mean(values) - wanted) < 4 * np.std(values) / np.sqrt(len(values)) + 0.01 * wanted

    near([o.metrics["nis_mean"] for o in runs], e.nis)
    near([o.metrics["nees_mean"] for o in runs], e.nees)
    near([o.metrics["seen_over_R"] for o in runs], e.over_R)
    near([o.study.test.whiteness.correlation[0, 0] + 1 for o in runs], e.memory + 1)
    assert np.mean(["white" in flags(o) for o in runs]) == pytest.approx(e.flagged, abs=0.2)


@pytest.mark.parametrize("task", by_knobs(LESSON.tasks), ids=lambda task: task.id)
@pytest.mark.parametrize("seed", [0, 1, 2, 3, 5, 17, 116, 2024, 9999])
def test_tasks_hold_for_every_seed(task, seed):
    """What they say does not turn on the noise: start and solution get the same sentence for every seed."""
    start, solved = (task.check(outcome(seed=seed, **values)) for values in ({}, task.solution))
    assert not start.solved and solved.solved
    assert (start, solved) == (task.check(outcome()), task.check(outcome(**task.solution)))


@pytest.mark.parametrize("name, near_by", [
    ("tune", {"q": 1.3, "r": 0.9}), ("tune", {"q": 0.8, "r": 1.1}), ("decoy", {"q": 15.0, "r": 0.5}),
    ("converter", {"noise": "carried", "q": 0.9, "r": 1.2}),
])
def test_tasks_hold_in_a_neighbourhood_of_their_solution(name, near_by):
    task = next(t for t in LESSON.tasks if t.id == name)
    assert task.check(outcome(**near_by)).solved


def test_a_converter_taken_for_white_is_flagged_nearly_always():
    assert sum("white" in flags(outcome(seed=seed, noise="coloured", q=1.0, r=1.0)) for seed in range(20)) >= 15


def test_whiteness_sees_a_wrong_ratio_and_nis_a_wrong_scale():
    """The gain depends on Q/R alone, and so do the innovations: a common factor changes S only."""
    good, scaled = outcome(q=1.0, r=1.0), outcome(q=3.0, r=3.0, p0=3.0)
    assert np.allclose(scaled.study.track.innovations, good.study.track.innovations, atol=1e-9 * SENSOR_SIGMA)
    assert scaled.metrics["nis_mean"] == pytest.approx(good.metrics["nis_mean"] / 3, rel=1e-6)
    assert {c.id for c in scaled.checks if not c.holds} == {"nis", "nees"}


def test_too_little_q_leaves_memory_and_too_much_the_opposite():
    first = {q: outcome(q=q, r=1.0).study.test.whiteness.correlation[0].mean() for q in (0.01, 1.0, 100.0)}
    assert first[0.01] > 0.2 and abs(first[1.0]) < 0.1 and first[100.0] < -0.2


def test_no_belief_about_a_white_r_makes_the_converter_white():
    assert not [r for r in np.geomspace(0.05, 20, 9) if outcome(noise="coloured", q=1.0, r=float(r)).metrics["white_p"] > 0.017]


def test_numbers_of_the_text():
    start, good = outcome().metrics, outcome(q=1.0, r=1.0).metrics
    assert start["nis_mean"] == pytest.approx(3.79, abs=0.006) and start["nees_mean"] == pytest.approx(61, abs=0.5)
    assert good["nis_mean"] == pytest.approx(3.90, abs=0.006) and good["nees_mean"] == pytest.approx(6.09, abs=0.006)
    assert good["S_over_R"] == pytest.approx(1.48, abs=0.006)
    for noise in ("white", "carried"):
        e = expected(noise, 1.0, 1.0)
        assert (e.nis, e.nees) == pytest.approx((4, 6), abs=1e-9) and e.flagged == pytest.approx(1 / 60, rel=1e-3)
    decoy = expected("white", 20.0, 0.47)
    assert decoy.nis == pytest.approx(4.08, abs=0.006) and decoy.flagged > 0.9
    assert outcome(noise="carried", q=1.0, r=1.0).study.watcher.filter.n == 6 + 16


# --- two updates -----------------------------------------------------------------------------------------------------
def test_joseph_is_the_true_covariance_for_any_gain_and_the_short_form_is_not():
    """A constant gain from the start: variances of 20 000 drawn errors are the judge, not either form."""
    who = watcher("white", 1.0, 1.0, 1.0)
    kf, M, rng, runs = who.filter, who.steady.filter_gain, np.random.default_rng(3), 20_000
    keep, joseph, short = np.eye(6) - M @ kf.C, who.start.covariance, who.start.covariance
    e = rng.multivariate_normal(np.zeros(6), joseph, runs)
    for _ in range(6):
        e = e @ keep.T - rng.normal(0, SENSOR_SIGMA, (runs, 4)) @ M.T
        e = e @ kf.A.T + rng.multivariate_normal(np.zeros(6), kf.Q, runs)
        joseph = kf.A @ (keep @ joseph @ keep.T + M @ kf.R @ M.T) @ kf.A.T + kf.Q
        short = kf.A @ keep @ short @ kf.A.T + kf.Q
    drawn = e.var(axis=0)
    assert np.abs(drawn / np.diag(joseph) - 1).max() < 0.06  # six standard deviations of a variance of 20 000
    assert np.abs(np.diag(short) / drawn - 1).max() > 0.5
    frozen = compare(1.0, 1.0, 1.0, False)
    assert frozen.short.max() > 0.1 and frozen.joseph.max() == 0.0


def test_single_precision_ruins_the_short_form_first():
    plain, hard, harder = (compare(q, r, p0, True) for q, r, p0 in ((1.0, 1.0, 1.0), (1.0, 0.01, 1e4), (0.05, 0.01, 1e4)))
    assert plain.joseph.max() < plain.short.max() < 1e-3
    assert hard.least_short < 0 < hard.least_joseph
    assert harder.least_joseph < 0  # Joseph's is no cure for everything: A P Aᵀ is rounded too


# --- the report --------------------------------------------------------------------------------------------------------
def test_published_bands_of_nis():
    assert chi2_band(4) == pytest.approx((0.484, 11.143), abs=5e-4)
    assert chi2_band(4, count=1000) == pytest.approx((3.827, 4.177), abs=1e-3)


def test_slips_of_the_report_are_named_with_numbers():
    table = {line: next(f for f in LESSON.figures(outcome(q=1.0, r=1.0, line=line)) if f.id == "report")
             for line in ("near-r", "short", "means", "joseph", "gain")}
    said = {line: " ".join(cell("en") for row in f.rows for cell in row if not isinstance(cell, str)) for line, f in table.items()}
    assert "slip" in said["near-r"] and "1.48" in said["near-r"]
    assert "against (59)'s advice" in said["short"] and "slip" in said["means"] and "77 σ" in said["means"]
    assert "slip" not in said["joseph"] and "slip" not in said["gain"]
    assert PRINTED_MEAN / (PRINTED_SIGMA / PRINTED_SAMPLES**0.5) > 50


def test_the_known_sine_leaves_no_peak_in_the_output_error():
    """Figure 11 of the report: a known force at 0.16 Hz is in the output and not in its error."""
    loud = next(f for f in LESSON.figures(outcome(q=1.0, r=1.0, force=2.0)) if f.id == "tracking")
    near = int(np.argmin(np.abs(loud.x - 0.16)))
    output, error = (c.y for c in loud.curves)
    assert output[near] > 100 * error[near]
    quiet = next(f for f in LESSON.figures(outcome(q=1.0, r=1.0, force=0.0)) if f.id == "tracking")
    assert np.allclose(quiet.curves[1].y, error, rtol=1e-6)
    assert output[near] > 10 * quiet.curves[0].y[near]


def test_the_converters_noise_has_the_variance_that_its_density_promises():
    f = np.linspace(1e-4, 0.5 / DT, 200_001)
    assert ADC.density(f).mean() * 0.5 / DT == pytest.approx(ADC.variance, rel=1e-3)


def test_runs_carry_over_to_another_sample_only():
    *_, (_, done) = LESSON.job.outcomes(outcome(q=1.0, r=1.0))
    assert carried(LESSON, done.design, done.study.trials, outcome(q=1.0, r=1.0, k=5)).study.trials is done.study.trials
    assert carried(LESSON, done.design, done.study.trials, outcome(q=1.1, r=1.0)).study.trials is None


@pytest.mark.parametrize("seed", range(1, 13))
@pytest.mark.parametrize("noise", ["white", "carried"])
def test_a_filter_is_not_condemned_by_one_record(noise: str, seed: int) -> None:
    """The right filter is flagged in some records; only a filter that is wrong over all records is called wrong."""
    for q, wrong in ((1.0, False), (0.05, True)):
        caption = table(outcome(noise=noise, q=q, r=1.0, seed=seed), "tests")
        assert ("over all records" in caption.lower()) == wrong, caption


def table(o, name: str) -> str:
    return next(f for f in LESSON.figures(o) if f.id == name).caption("en")


def test_above_and_below_follow_the_sign_of_the_level() -> None:
    assert "above the output" in table(outcome(force=0.0), "tracking")
    for force in (0.0, 1.0, 2.0):
        assert "−" not in table(outcome(force=force), "tracking")


def test_the_first_decoy_cancels_over_all_records_and_not_in_one() -> None:
    start = LESSON.start()
    e = expected(start["noise"], start["q"], start["r"])
    assert e.nis == pytest.approx(4.0, abs=0.02) and e.flagged > 0.99


def test_the_likelihood_of_a_record_is_that_of_its_filter_and_finds_the_truth() -> None:
    """Each level is that of the lesson's own filter with the q and r found; the truth is left open by nearly every record."""
    kept = []
    for seed in range(1, 9):
        found = fitted(truth(seed, False, 1.0, -1.0))
        assert 0.5 < found.q < 2 and 0.8 < found.r < 1.25
        kept.append(found.low <= 1 <= found.high)
    assert sum(kept) >= 6, kept
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"seed": 8, "q": found.q, "r": found.r}))
    nu, S = outcome.study.track.innovations[UNTESTED_SAMPLES:], outcome.study.track.S[UNTESTED_SAMPLES:]
    level = np.mean([np.log(np.linalg.det(s)) + n @ np.linalg.inv(s) @ n for n, s in zip(nu, S, strict=True)])
    assert abs(level - found.least) < 5e-3  # its gain is still on the way at the start
    assert found.excess.min() == 0.0 and abs(found.low - found.high) > 0
