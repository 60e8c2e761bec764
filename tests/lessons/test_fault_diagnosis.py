"""Fault diagnosis: each single fault isolated, false alarms as designed, and what the lesson says about the deck."""

import numpy as np
import pytest
from lesson_checks import carried
from scipy.stats import chi2

from observer_lab.colours import COLOURS, rgb
from observer_lab.engine import Plant, observability, residual_generator
from observer_lab.engine.observers import FaultBank, binomial_band
from observer_lab.lessons.fault_diagnosis.diagnosis import ALARM_HOLD_SAMPLES, ENERGY, MEAN, Rule, judge
from observer_lab.lessons.fault_diagnosis.job import residuals_of
from observer_lab.lessons.fault_diagnosis.lesson import LESSON
from observer_lab.lessons.fault_diagnosis.observer_bank import DT, FAULT_PLACES, SAMPLE_COUNT, gain, guard, model, truth
from observer_lab.lessons.fault_diagnosis.run_length import rate_for
from observer_lab.lessons.fault_diagnosis.runs import (
    DRIFT_FAULT,
    KEEP_LOOP_OPEN,
    NO_REACTION,
    NONE,
    STUCK_FAULT,
    SWITCH_LOOP,
    Case,
    Fault,
    drawn,
    quiet,
    simulate,
    switched,
)
from observer_lab.lessons.fault_diagnosis.sensitivity import TONES, gathered, least, over_tones
from observer_lab.lessons.fault_diagnosis.study import unknown_coil

SEEDS = range(30)


def outcome(**values):
    return LESSON.compute(LESSON.apply(LESSON.start(), values))


def worked_through(**values):
    *_, (_, done) = LESSON.job.outcomes(outcome(**values))
    return done.study.trials


# --- isolation ---------------------------------------------------------------------------------------------------------
FAULTS = (
    *(pytest.param(Case(p, size=10.0), Rule(), id=f"{p}-bias") for p in FAULT_PLACES[:4]),
    *(pytest.param(Case(p, DRIFT_FAULT, 4.0), Rule(), id=f"{p}-drift") for p in FAULT_PLACES[:4]),
    *(pytest.param(Case(p, STUCK_FAULT, force=2.0), Rule(MEAN), id=f"{p}-stuck") for p in FAULT_PLACES[:4]),
    *(pytest.param(Case(p, size=0.6, loop=KEEP_LOOP_OPEN, tone=1.4), Rule(), id=f"{p}-weak") for p in FAULT_PLACES[4:]),
)


@pytest.mark.parametrize("case, test", FAULTS)
def test_each_single_fault_is_isolated_on_every_seed(case, test):
    for seed in SEEDS:
        verdict = judge(test, simulate(case, drawn(seed)))
        assert verdict.who == case.place, seed
        assert verdict.decided >= case.start + ALARM_HOLD_SAMPLES - 1


def test_every_fault_has_a_row_of_its_own():
    signature = guard().bank.signature
    assert np.array_equal(signature, ~np.eye(7, dtype=bool))
    assert len({tuple(column) for column in signature.T}) == 7


def test_without_any_one_sensor_the_rest_sees_the_whole_deck():
    kf = model()
    for i in range(4):
        rest = Plant(kf.A, kf.B, np.delete(kf.C, i, axis=0), dt=DT)
        assert observability(rest).observable
        assert guard().bank.members[i].size == 6


@pytest.mark.parametrize("liar, honest", [("HL", "HR"), ("HR", "HL")])
def test_the_model_tells_apart_what_the_sum_cannot(liar, honest):
    """HL + HR moves by the bias whichever of the two lies; the member without the liar stays exactly as it was."""
    case = Case(liar, size=3.0)
    lie, sane = quiet(case), quiet(Case())
    total = (lie.y - sane.y)[case.start:, [1, 3]].sum(axis=1)
    assert np.allclose(total, 3e-3, atol=1e-12)
    strength = np.abs(lie.residuals - sane.residuals).max(axis=(0, 2))
    assert strength[FAULT_PLACES.index(liar)] < 1e-9 < 1 < strength[FAULT_PLACES.index(honest)]
    assert outcome(place=liar).study.right


def test_a_lie_of_VL_looks_almost_like_coil_1():
    size = np.linalg.norm(guard().bank.response(1.0)[:, :, 0], axis=1)
    assert size[4] / size[1] == pytest.approx(0.257, abs=0.005)
    assert np.argmin(np.delete(size, 0)) == 3


def test_without_HR_a_lasting_lie_of_HL_could_not_be_told_from_coil_3():
    kf = model()
    alone = FaultBank(kf, (residual_generator(kf, name="u3", outputs=[0, 1, 2], E=kf.B[:, [2]]),))
    both = np.linalg.norm(guard().bank.response(1.0)[6, :, 1])
    assert np.linalg.norm(alone.response(1.0)[0, :, 1]) < 1e-3 * both
    parity = 1 / (np.sqrt(2) * 1e-3)  # HL + HR has twice the variance
    assert both == pytest.approx(parity, rel=1e-3)


# --- coils -------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("coil", range(3))
def test_no_observer_of_six_states_but_a_residual_of_five(coil):
    known = unknown_coil(coil)
    assert known.rank_CE == known.rank_E == 1 and not known.exists
    assert np.allclose(known.zeros, 0, atol=1e-8)
    member = guard().bank.members[4 + coil]
    assert member.size == 5 and np.allclose(member.hidden, 1, atol=1e-8)


@pytest.mark.parametrize("coil", ["u1", "u2", "u3"])
def test_a_weak_coil_leaves_its_member_untouched_and_a_constant_one_leaves_all(coil):
    healthy, weak = (simulate(c, drawn(2)) for c in (Case(loop=KEEP_LOOP_OPEN), Case(coil, size=0.7, loop=KEEP_LOOP_OPEN)))
    change = np.abs(weak.residuals - healthy.residuals).max(axis=(0, 2))
    assert change[FAULT_PLACES.index(coil)] < 1e-9 and np.all(np.delete(change, FAULT_PLACES.index(coil)) > 0.1)
    at_rest = np.linalg.norm(guard().bank.response(1.0)[:, :, FAULT_PLACES.index(coil)], axis=1)
    assert np.all(at_rest < 1e-9)


def test_what_nobody_asks_for_cannot_be_missed():
    healthy, dead = (
        simulate(c, drawn(5)) for c in (Case(loop=KEEP_LOOP_OPEN, force=0.0), Case("u1", size=1.0, loop=KEEP_LOOP_OPEN, force=0.0))
    )
    assert np.abs(healthy.residuals - dead.residuals).max() < 1e-10


def test_a_good_loop_hides_a_weak_coil():
    """Near a mode the loop pushes against the known force; 1 N is left with 0.13 N at 1.3 Hz."""
    asked = [np.abs(quiet(Case(loop=loop, tone=1.3)).asked[300:, 0]).max() for loop in (NO_REACTION, KEEP_LOOP_OPEN)]
    assert asked[0] < 0.15 and asked[1] == pytest.approx(1.0, abs=0.01)


def test_the_best_frequency_lies_between_pitch_and_vertical_mode():
    worst = over_tones()
    assert 1.19 < TONES[np.argmax(worst[:, 0])] < 1.5
    half = [np.linalg.norm(guard().bank.response(np.exp(2j * np.pi * f * DT))[0, :, 4]) for f in (1.4, 0.5)]
    assert half[0] / half[1] == pytest.approx(7, abs=0.6)


# --- thresholds --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("statistic, window, rate", [(ENERGY, 25, 1e-3), (ENERGY, 1, 0.05), (MEAN, 60, 1e-5)])
def test_the_threshold_is_the_quantile(statistic, window, rate):
    test = Rule(statistic, window, rate)
    assert test.threshold == pytest.approx(chi2.isf(rate, 3 * window if statistic == ENERGY else 3), rel=1e-12)
    assert outcome(statistic=statistic, window=window, rate=rate).metrics["threshold"] == test.threshold


@pytest.mark.slow
@pytest.mark.parametrize("values", [{"rate": 1e-2}, {"rate": 0.05, "statistic": MEAN, "window": 10},
                                    {"rate": 1e-2, "loop": KEEP_LOOP_OPEN, "force": 4.0}])
def test_false_alarms_come_as_designed(values):
    trials = worked_through(place=NONE, **values)
    low, high = binomial_band(trials.windows, values["rate"], level=1 - 0.01 / 7)
    assert np.all((trials.alarms >= low * trials.windows) & (trials.alarms <= high * trials.windows))
    assert trials.any <= 7 * values["rate"] * trials.windows * 1.2


@pytest.mark.slow
def test_a_wrong_model_breaks_the_promise():
    trials = worked_through(place=NONE, stiffer=15.0)
    assert trials.alarms.max() / trials.windows > 3 * trials.band(1e-3)[1]


@pytest.mark.slow
def test_many_runs_accuse_the_right_one_and_never_another():
    trials = worked_through(place="VR", kind=DRIFT_FAULT)
    assert trials.right == trials.runs and trials.wrong == 0


@pytest.mark.slow
def test_the_promised_delay_holds_for_nine_runs_in_ten():
    """Six members at 99 % each: at least 94 % of the runs have all six alarms at the promised time."""
    for place in ("HL", "u3"):
        o = outcome(place=place, loop=KEEP_LOOP_OPEN)
        s = o.study
        at = s.case.start + s.forecast.delay
        alarms = np.array([s.test.values(simulate(s.case, drawn(seed)).residuals)[at] > s.test.threshold for seed in range(200)])
        seen = guard().bank.signature[:, s.column]
        assert np.all(alarms[:, seen].mean(axis=0) > 0.96)
        assert np.all(alarms[:, ~seen].mean(axis=0) < 0.02)


def test_reach_is_the_size_that_gives_an_alarm_with_99_percent():
    test = Rule()
    size = least(test, 0.5)[6, 1]  # HL, seen by −u3
    lie, none = quiet(Case("HL", size=1e3 * size)), quiet(Case())
    strength = test.values(lie.residuals - none.residuals)[-1] / test.needed
    assert strength[6] == pytest.approx(1.0, rel=1e-3)
    k = np.arange(25)
    phases = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    waves = np.sin(2 * np.pi * 0.8 * DT * k + phases[:, None])
    assert gathered(test, 0.8) == pytest.approx((waves**2).sum(axis=1).mean(), rel=1e-6)
    assert gathered(Rule(MEAN), 0.8) == pytest.approx((waves.sum(axis=1)**2).mean() / 25, rel=1e-6)


# --- the loop ----------------------------------------------------------------------------------------------------------
def step_by_step(case, noise, decided, who):
    """The same run, one sample after another: the oracle of the legs and scans."""
    kf, g = model(), guard()
    A, B = truth(case.stiffer)
    index = FAULT_PLACES.index(who)
    x, xhat, frozen = np.zeros(6), noise.whole.copy(), {}
    z = [noise.bank[s].copy() for s in g.bank.slices]
    used, K, active = None, gain(), np.ones(3)
    xs, beliefs = [], []
    for k in range(SAMPLE_COUNT):
        if k == decided:
            if index < 4:
                used, xhat = g.bank.members[index], z[index].copy()
            else:
                K, active = gain(index - 4), np.where(np.arange(3) == index - 4, 0.0, 1.0)
        t = DT * k
        rise, angle = case.force * (1 - np.exp(-2 * t)), 2 * np.pi * case.tone * t
        r = active * rise * np.array([np.sin(angle), np.sin(angle), np.cos(angle)])
        u = r - K @ xhat
        y = kf.C @ x + noise.v[k]
        push = u.copy()
        for fault in case.faults:
            if k >= fault.start and fault.sensor is not None:
                i = fault.sensor
                frozen.setdefault(i, y[i])
                y[i] = frozen[i] if fault.kind == STUCK_FAULT else y[i] + 1e-3 * fault.size * (
                    DT * (k - fault.start) if fault.kind == DRIFT_FAULT else 1.0)
            if k >= fault.start and fault.coil is not None:
                push[fault.coil] *= 1 - fault.size
        xs.append(x)
        beliefs.append(xhat)
        o = g.whole if used is None else used
        x, xhat = A @ x + B @ push + noise.w[k], o.F @ xhat + o.G @ u + o.K @ y
        z = [m.F @ v + m.G @ u + m.K @ y for m, v in zip(g.bank.members, z, strict=True)]
    return np.array(xs), np.array(beliefs)


@pytest.mark.parametrize(
    "case",
    [
        Case("VR", DRIFT_FAULT, 4.0, loop=SWITCH_LOOP),
        Case("HL", STUCK_FAULT, loop=SWITCH_LOOP, force=3.0, stiffer=0.05),
        Case("u2", size=1.0, loop=SWITCH_LOOP, force=3.0),
        Case("VR", DRIFT_FAULT, 4.0, loop=SWITCH_LOOP, also=Fault("HL", STUCK_FAULT, at=9.0)),
    ],
    ids=lambda c: c.place,
)
def test_the_run_is_what_stepping_through_it_gives(case):
    before = simulate(case, drawn(3))
    verdict = judge(Rule(), before)
    assert verdict.who == case.place
    after = switched(case, drawn(3), before, verdict.decided, verdict.who)
    x, xhat = step_by_step(case, drawn(3), verdict.decided, verdict.who)
    assert np.allclose(after.x, x, atol=1e-12) and np.allclose(after.xhat, xhat, atol=1e-12)
    assert np.array_equal(after.y[:verdict.decided], before.y[:verdict.decided])
    assert judge(Rule(), after).decided == verdict.decided


def test_faults_to_come_come_to_a_loop_that_was_switched_before_them():
    """Accused for nothing at 2 s: the readings that stick at 4 s are those of the run that follows, and u1 is whole until 6 s."""
    case = Case("HL", STUCK_FAULT, force=3.0, loop=SWITCH_LOOP, also=Fault("u1", size=1.0, at=6.0))
    after = switched(case, drawn(3), simulate(case, drawn(3)), 100, "VR")
    x, xhat = step_by_step(case, drawn(3), 100, "VR")
    assert np.allclose(after.x, x, atol=1e-12) and np.allclose(after.xhat, xhat, atol=1e-12)
    assert np.array_equal(after.asked[:300], after.applied[:300]) and not after.applied[300:, 0].any()


def test_runs_beside_each_other_are_those_one_by_one():
    noises = [drawn(seed) for seed in (1, 2, 3)]
    for case in (
        Case(),
        Case("VL", size=1.0),
        Case("HR", DRIFT_FAULT, 2.0, at=7.0),
        Case("u2", size=0.6, loop=KEEP_LOOP_OPEN, stiffer=0.1),
        Case("VR", STUCK_FAULT, at=3.0, loop=KEEP_LOOP_OPEN),
        Case("HL", size=1.0, at=0.0),
        Case("VR", STUCK_FAULT, at=3.0, also=Fault("HL", DRIFT_FAULT, 2.0, 5.0)),
        Case("u2", size=1.0, also=Fault("u3", size=0.5, at=8.0)),
    ):
        together = residuals_of(case, noises)
        for run, noise in enumerate(noises):
            alone = simulate(case, noise).residuals
            assert np.allclose(together[:, run], alone, rtol=0, atol=1e-12 * np.abs(alone).max()), case


def test_a_drift_that_nobody_notices_tilts_the_deck_and_acting_levels_it():
    """The numbers of the task: 13 mrad, 1.9 with the sum of squares, 1.1 with the mean, due after 2.5 and 1.8 s."""
    blind, energy, mean = (
        outcome(place="VR", kind=DRIFT_FAULT, **v) for v in ({}, {"loop": SWITCH_LOOP}, {"loop": SWITCH_LOOP, "statistic": MEAN})
    )
    assert [round(1e3 * o.metrics["pitch"], 1) for o in (blind, energy, mean)] == [13.2, 1.9, 1.1]
    assert energy.metrics["expected_delay"] == pytest.approx(2.5) and mean.metrics["expected_delay"] == pytest.approx(1.82)
    s = blind.study.record
    assert abs(s.xhat[-100:, 2].mean()) > 3 * abs(s.x[-100:, 2].mean())  # and the estimate wanders off farther


@pytest.mark.parametrize("loop", [KEEP_LOOP_OPEN, NO_REACTION, SWITCH_LOOP])
def test_a_kick_accuses_nobody(loop):
    for seed in range(20):
        s = outcome(place=NONE, kick=3.0 + 0.3 * seed, seed=seed, loop=loop).study
        assert s.verdict.who is None and s.verdict.first is not None


@pytest.mark.parametrize("seed", SEEDS)
def test_healthy_runs_accuse_nobody(seed):
    assert outcome(place=NONE, seed=seed).study.verdict.who is None


# --- tasks, exam, job --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("task", LESSON.tasks, ids=lambda t: t.id)
def test_tasks_hold_for_any_noise(task):
    for seed in (0, 7, 4711):
        assert task.check(outcome(**{**task.solution, "seed": seed})).solved


def test_a_slow_drift_is_seen_soonest_through_a_window_of_its_own():
    """The numbers of the task, at one false alarm an hour: a valley over the window, and the sum of squares above it."""
    def due(window, statistic=MEAN):
        rate = rate_for(statistic, int(window), 3600.0)
        o = outcome(place="HR", kind=DRIFT_FAULT, drift=1.0, statistic=statistic, window=window, rate=rate)
        return round(o.metrics["expected_delay"], 2)
    assert [due(n) for n in (25.0, 64.0, 150.0)] == [2.54, 2.1, 2.4]
    assert min(due(n, "energy") for n in (60.0, 75.0, 90.0)) == 3.08
    task = next(t for t in LESSON.tasks if t.id == "ramp")
    tried = [(45.0, 5.7e-6), (60.0, 7.7e-6), (64.0, 9.5e-6), (64.0, 7e-6), (75.0, 9.6e-6)]
    found = [outcome(place="HR", kind=DRIFT_FAULT, drift=1.0, statistic=MEAN, window=window, rate=rate) for window, rate in tried]
    assert [task.check(o).solved for o in found] == [False, True, False, False, True]


@pytest.mark.slow
def test_counts_carry_over_to_another_reaction_only():
    *_, (_, done) = LESSON.job.outcomes(outcome())
    assert carried(LESSON, done.design, done.study.trials, outcome(loop=SWITCH_LOOP)).study.trials is done.study.trials
    assert carried(LESSON, done.design, done.study.trials, outcome(kick=2.0)).study.trials is done.study.trials
    for other in ({"window": 26}, {"bias": 4.0}, {"loop": KEEP_LOOP_OPEN}, {"stiffer": 5.0}, {"seed": 2}):
        assert carried(LESSON, done.design, done.study.trials, outcome(**other)).study.trials is None


def test_the_stage_marks_the_liar_and_flags_the_accused():
    o = outcome()
    body, at = o.stage.body, o.study.verdict.decided
    before, between, after = (body.pose(o.stage.x[k].tolist(), body.gain) for k in (0, at - 1, at))
    assert before["gauge left"].colour != between["gauge left"].colour == after["gauge left"].colour
    assert between["flag"].position[2] < -5 < 0 < after["flag"].position[2]
    assert abs(after["flag"].position[0] - after["gauge left"].position[0]) < 1e-9


@pytest.mark.parametrize("values", [{}, {"bias": 1.5, "window": 100.0}, {"place": "u1", "rate": 1e-2}, {"loop": SWITCH_LOOP}])
def test_a_bar_before_the_deck_is_the_windows_sum_over_the_quantile(values):
    """T = Σ ‖S^(−1/2) ν‖² over the last N samples, over the quantile of χ² with 3 N degrees of freedom, no higher than 2.6 of it."""
    o = outcome(**values)
    window = int(o.design["window"])
    quantile = chi2.ppf(1 - o.design["rate"], 3 * window)
    for at in (window, 230, 350, 600):
        poses = o.stage.body.pose(o.stage.x[at].tolist(), o.stage.body.gain)
        level = poses["threshold"].position[2] - poses["test 0"].position[2]
        total = (o.study.record.residuals[at - window + 1:at + 1] ** 2).sum(axis=(0, 2)) / quantile
        for k, value in enumerate(total):
            bar = poses[f"test {k}"]
            assert bar.scale[2] / level == pytest.approx(min(max(value, 0.03), 2.6), rel=1e-6)
            assert (bar.colour == rgb(COLOURS["error"])) == (value > 1)


def test_the_bars_stand_before_the_deck_where_the_knob_says_so():
    body = outcome(shown="deck").stage.body
    assert not any(part.name.startswith("test ") and "mass" not in part.name for part in body.parts) and not body.labels
    assert len([part for part in outcome().stage.body.parts if part.name.startswith("test ") and "mass" not in part.name]) == 7


def test_the_sensors_keep_their_names_and_the_names_go_with_the_deck():
    stage = outcome().stage
    for k in (0, 200, 400):
        x, xhat = stage.x[k].tolist(), stage.xhat[k].tolist()
        poses = stage.body.pose(x, stage.body.gain)
        names = {words: at for words, at, _ in stage.body.marks(x, xhat, stage.body.gain).words}
        for name, part in (("VL", "sensor left"), ("VR", "sensor right"), ("HL", "gauge left"), ("HR", "gauge right")):
            assert abs(names[name][0] - poses[part].position[0]) < 0.15


def test_the_one_curve_below_the_threshold_is_the_one_in_colour():
    figure = next(f for f in LESSON.figures(outcome()) if f.id == "sensors")
    odd = [curve for curve in figure.curves if curve.role == "plant"]
    assert [curve.name("en") for curve in odd] == ["−HL"]
    assert {curve.name("en") for curve in figure.curves if curve.role == "muted"} == {"−VL, −VR, −HR"}


# --- what the page claims ----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("loop", [KEEP_LOOP_OPEN, NO_REACTION, SWITCH_LOOP])
def test_a_kick_without_a_fault_accuses_nobody_with_the_test_of_the_start(loop):
    for seed in (1, 2, 3):
        for kick in (0.0, 1.0, 2.5, 4.0, 7.0, 11.0):
            assert outcome(place=NONE, loop=loop, kick=kick, seed=seed).study.verdict.who is None


def test_what_the_design_expects_is_said_without_a_promise():
    said = 0
    for values in (
        {},
        {"place": "VR", "kind": DRIFT_FAULT},
        {"place": "u1", "loss": 100.0},
        {"place": "HL", "window": 100.0},
        {"kick": 4.2},
    ):
        o = outcome(**values)
        if "expects" in o.live("en"):
            said += 1
            assert f"{DT * o.study.forecast.delay:.2f} s" in o.live("en")
        assert "promise" not in o.live("en")
    assert said > 1
