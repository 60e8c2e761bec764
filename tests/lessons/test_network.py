"""Lesson 18: how many packets may be lost, and what a delay does to separation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from lesson_checks import by_knobs, carried

from observer_lab.course.knobs import Choice, Number
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine.network import mean_square_growth
from observer_lab.lessons.network.bodies import LIT_COLOUR, PACKETS
from observer_lab.lessons.network.cases import CART_CASE, CASE_KINDS, CHIP_CASE, DECK_CASE, RUN_SAMPLES, SCALAR_CASE, TWO, sampled
from observer_lab.lessons.network.lesson import LESSON
from observer_lab.lessons.network.study import AUTONOMOUS_TOLERANCE, LOSSES, OVER, bounds_over_loss, key
from observer_lab.lessons.network.tasks import TASKS
from observer_lab.plants import MODELS

SEEDS = range(1, 9)


def outcome(**values: Any) -> Outcome:
    return LESSON.compute(LESSON.apply(LESSON.start(), values))


def finished(start: Outcome) -> Outcome:
    assert LESSON.job is not None
    return [start, *(better for _, better in LESSON.job.outcomes(start))][-1]


# --- how many may be lost ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("a", [1.01, 1.2, 1.4, 2.0])
def test_scalar_the_critical_loss_is_one_over_a_squared(a: float) -> None:
    o = outcome(a=a)
    assert o.metrics["critical"] == o.metrics["safe"] == pytest.approx(1 / a**2, rel=1e-12)
    edge = 1 / a**2
    for loss, bounded in ((0.97 * edge, True), (min(1.03 * edge, 0.99), False)):
        assert outcome(a=a, loss=loss).checks[0].holds == (bounded or loss < edge)


def test_the_lower_bound_diverges_above_the_edge_and_the_upper_one_settles_below() -> None:
    below, above = outcome(loss=0.6).study, outcome(loss=0.8).study
    assert below.upper[-1] == pytest.approx(below.upper[-10], rel=1e-2) and below.upper[-1] < 20
    assert above.lower[-1] / above.lower[-2] == pytest.approx(0.8 * 1.44, rel=1e-3)


def test_the_numbers_of_the_second_step() -> None:
    shares = {case: outcome(case=case).metrics for case in (CHIP_CASE, CART_CASE, DECK_CASE, TWO)}
    assert 100 * shares[CHIP_CASE]["critical"] == pytest.approx(88.4, abs=0.05)
    assert 100 * shares[CART_CASE]["critical"] == pytest.approx(71.0, abs=0.05)
    assert shares[DECK_CASE]["critical"] == shares[DECK_CASE]["safe"] == 1.0
    assert 100 * shares[TWO]["critical"] == pytest.approx(64, abs=1e-9)
    assert 100 * shares[TWO]["safe"] == pytest.approx(52.9, abs=0.05)
    for case in (CHIP_CASE, CART_CASE):  # the edge from the continuous plant: e^{−2 s h}
        s = float(np.max(np.linalg.eigvals(MODELS[case].plant.A).real))
        assert shares[case]["critical"] == pytest.approx(np.exp(-2 * s * shares[case]["period"]), rel=1e-9)


def test_faster_sampling_lets_more_packets_be_lost() -> None:
    slow, fast = outcome(case=CART_CASE).metrics, outcome(case=CART_CASE, stretch=0.5).metrics
    assert (slow["radius"], fast["radius"]) == pytest.approx((1.187, 1.089), abs=5e-4)
    assert 100 * fast["critical"] == pytest.approx(84.3, abs=0.05)


def test_the_variance_climbs_where_a_packet_is_lost_and_falls_where_one_comes() -> None:
    s = outcome(loss=0.5).study
    before = np.concatenate([[1.0], s.teeth[:-1, 1]])
    assert np.all(s.teeth[s.heard, 0] < before[s.heard])
    assert s.teeth[~s.heard, 0] == pytest.approx(before[~s.heard], rel=1e-12)
    assert np.all(s.teeth[:, 1] > s.teeth[:, 0])


def test_many_runs_lie_between_the_bounds_below_the_edge_and_their_median_stays_small_above() -> None:
    o = finished(outcome(loss=0.3))
    t, (lower, upper) = o.study.trials, bounds_over_loss(key(o.design))
    assert len(t.mean) == RUN_SAMPLES + 1 and len(t.means) == len(OVER)
    assert o.study.lower[-1] < t.mean[20:].mean() < 1.02 * o.study.upper[-1]
    for p, mean in zip(OVER[OVER < 0.5], t.means, strict=False):
        assert np.interp(p, LOSSES, lower) < mean < 1.1 * np.interp(p, LOSSES, upper)
    at = int(np.argmin(np.abs(OVER - 0.8)))
    assert t.medians[at] < 20 and np.interp(0.8, LOSSES, lower) > 1e5
    assert list(t.medians) == sorted(t.medians)  # the same random numbers at every loss


def test_averages_go_over_only_where_they_still_hold() -> None:
    o = finished(outcome())
    told = carried(LESSON, o.design, o.study.trials, outcome(told="asked", delay=1))
    assert told.study.trials is o.study.trials
    loss = carried(LESSON, o.design, o.study.trials, outcome(loss=0.5))
    assert loss.study.trials.means == o.study.trials.means and not len(loss.study.trials.mean)
    for other in (dict(noise=2.0), dict(a=1.3), dict(case=CHIP_CASE), dict(seed=2)):
        assert carried(LESSON, o.design, o.study.trials, outcome(**other)).study.trials is None


# --- what the page claims, at designs drawn at random and at the ends of the knobs ---------------------------------------------
def designs(count: int) -> list[Design]:
    """Designs of every case, each knob at an end, at rest or anywhere between."""
    rng, found = np.random.default_rng(18), []
    for index in range(count):
        values: dict[str, Any] = {"case": list(CASE_KINDS)[index % len(CASE_KINDS)]}
        for knob in LESSON.knobs:
            if knob.name in ("case", "seed", "kick"):
                continue
            if isinstance(knob, Choice):
                values[knob.name] = str(rng.choice([name for name, _ in knob.options]))
            elif isinstance(knob, Number):
                values[knob.name] = float(rng.choice([knob.low, knob.default, knob.high, rng.uniform(knob.low, knob.high)]))
        found.append(LESSON.apply(LESSON.start(), values))
    return found


@pytest.mark.parametrize("case", list(CASE_KINDS))
def test_the_light_of_the_bounded_mean_goes_out_at_the_critical_share_and_nowhere_else(case: str) -> None:
    for stretch, a in ((0.5, 1.01), (1.0, 1.2), (1.7, 1.6), (3.0, 2.0)):
        o = outcome(case=case, stretch=stretch, a=a, loss=0.0)
        edge = o.study.watched.sampled.edge
        assert edge.critical is not None and edge.critical == (1.0 if edge.lost == 1 else 1 / o.metrics["radius"] ** 2)
        for loss in (edge.critical - 1e-3, edge.critical + 1e-3):
            if 0 <= loss <= 0.99:
                o = outcome(case=case, stretch=stretch, a=a, loss=loss)
                light = next(check for check in o.checks if check.id == "bounded")
                said = next(f for f in LESSON.figures(o) if f.id == "limits").caption("en")
                assert light.holds == ("expects a bounded" in o.live("en")) == ("stays bounded" in said) == (loss < edge.critical)


def test_a_deck_that_loses_everything_stays_bounded() -> None:
    s = sampled(DECK_CASE, 1.2, 3.0)
    assert s.radius < 1 and s.edge.bounded(1.0)


@pytest.mark.slow
def test_nothing_is_said_to_leave_the_error_alone_where_the_meter_reads() -> None:
    quiet = 0
    for design in designs(60):
        o = LESSON.compute(design)
        said = {f.id: f.caption("en") for f in LESSON.figures(o) if f.id in ("blocks", "error")}
        alone = o.metrics["separation_meter"] < AUTONOMOUS_TOLERANCE
        assert ("do not drive the error" not in said["blocks"]) or alone, design
        assert ("whatever the controller does" in said["error"]) == alone, design
        quiet += alone
    assert 5 < quiet < 55
    for values in (dict(told="asked", loss_u=0.3, delay=0), dict(jitter=3, order="arrival")):
        o = outcome(**values)
        caption = next(f for f in LESSON.figures(o) if f.id == "blocks").caption("en")
        assert o.metrics["separation_meter"] > 0.1 and "lost or out of order" in caption


# --- late, and taken for fresh -------------------------------------------------------------------------------------------
def test_late_measurements_put_in_their_place_keep_the_wall_and_the_edge() -> None:
    o = outcome(jitter=4)
    assert o.metrics["separation_meter"] < 1e-12 and o.metrics["critical"] == outcome().metrics["critical"]
    assert o.study.teeth[:, 1].mean() > 2 * outcome().study.teeth[:, 1].mean()
    for seed in SEEDS:
        assert outcome(jitter=4, order="arrival", seed=seed).metrics["separation_meter"] > 0.1


# --- delay ---------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("case", [SCALAR_CASE, TWO, CHIP_CASE, CART_CASE, DECK_CASE])
def test_a_delay_unknown_to_the_observer_breaks_separation_and_a_known_one_does_not(case: str) -> None:
    for seed in SEEDS:
        assert outcome(case=case, delay=2, told="asked", loss_u=0.0, seed=seed).metrics["separation_meter"] > 0.1
        assert outcome(case=case, delay=2, told="applied", seed=seed).metrics["separation_meter"] < 1e-9


@pytest.mark.parametrize("case", [SCALAR_CASE, TWO, CHIP_CASE, CART_CASE, DECK_CASE])
def test_looking_ahead_brings_the_loop_back_to_its_crosses(case: str) -> None:
    o = outcome(case=case, delay=2, told="ahead")
    chosen = np.concatenate([o.poles["controller"], o.poles["observer"]])
    left = list(o.poles["loop"])
    for pole in chosen:
        near = min(left, key=lambda z: abs(z - pole))
        assert abs(near - pole) < 1e-6
        left.remove(near)
    assert np.max(np.abs(left)) < 1e-3


def test_being_told_is_not_enough_for_the_pole_on_a_cart() -> None:
    told, ahead = (outcome(case=CART_CASE, delay=2, told=how).metrics for how in ("applied", "ahead"))
    assert told["separation_meter"] < 1e-9 and told["loop_radius"] > 1
    assert ahead["loop_radius"] == pytest.approx(0.907, abs=5e-4)


# --- lost inputs -----------------------------------------------------------------------------------------------------------
def test_neither_holding_nor_zero_always_wins() -> None:
    s = sampled(CHIP_CASE, 1.2, 1.0)
    growth = {(p, how): mean_square_growth(s.plant, s.K, p, how) for p in (0.3, 0.5) for how in ("hold", "zero")}  # type: ignore[arg-type]
    assert growth[0.3, "hold"] == pytest.approx(0.729, abs=5e-4) and growth[0.3, "zero"] == pytest.approx(0.781, abs=5e-4)
    assert growth[0.5, "hold"] == pytest.approx(0.920, abs=5e-4) and growth[0.5, "zero"] == pytest.approx(0.840, abs=5e-4)


# --- tasks, exam, stage ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("task", by_knobs(TASKS), ids=lambda t: t.id)
def test_no_task_turns_on_the_noise(task: Any) -> None:
    for seed in SEEDS:
        assert task.check(outcome(**task.solution, seed=seed)).solved
        assert not task.check(outcome(seed=seed)).solved


def test_near_misses_of_the_tasks() -> None:
    edge, faster, gap, wall = by_knobs(TASKS)
    assert not edge.check(outcome(a=1.4, loss=0.52)).solved and not edge.check(outcome(a=1.4, loss=0.45)).solved
    assert not faster.check(outcome(case=CART_CASE, loss=0.8)).solved
    assert not gap.check(outcome(case=TWO, loss=0.5)).solved and not gap.check(outcome(case=TWO, loss=0.7)).solved
    assert not wall.check(outcome(case=CART_CASE, delay=2, told="asked")).solved
    assert not wall.check(outcome(case=CART_CASE, delay=2, told="applied")).solved


@pytest.mark.parametrize("stretch", [0.5, 0.7, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("told", ["asked", "applied"])
def test_the_wall_is_not_mended_without_looking_ahead(told: str, stretch: float) -> None:
    wall = TASKS[3]
    for delay in (2, 3, 4):
        assert not wall.check(outcome(case=CART_CASE, delay=delay, told=told, stretch=stretch)).solved


def test_the_fastest_sampling_is_not_the_answer() -> None:
    faster = TASKS[1]
    solved = [stretch for stretch in np.arange(10, 21) / 20 if faster.check(outcome(case=CART_CASE, loss=0.8, stretch=stretch)).solved]
    assert solved == [0.6, 0.65]


@pytest.mark.parametrize("loss", [0.0, 0.3, 0.75])
def test_the_gate_stands_three_sigma_to_either_side_of_the_estimate(loss: float) -> None:
    """P grows to a² P + 0.09 in a sample; a packet makes P r/(P + r) of it, r = 0.09. Places are drawn at 1.5 tanh(0.16 x/1.5)."""
    o = outcome(loss=loss)
    assert o.stage is not None and o.stage.body.marks is not None and o.stage.spread is None
    per, a, before = (len(o.stage.t) - 1) // (RUN_SAMPLES - 1), o.design["a"], None
    for k in range(RUN_SAMPLES - 1):
        x, xhat = o.stage.x[k * per].tolist(), float(o.stage.xhat[k * per, 0])  # type: ignore[index]
        variance = (x[-1] / 3) ** 2
        if before is not None:
            grown = a * a * before + 0.09
            assert variance == pytest.approx(grown * 0.09 / (grown + 0.09) if o.study.heard[k] else grown, rel=1e-6)
        before = variance
        poses = o.stage.body.pose(x, 1.0)
        ends = [poses[f"gate {name}"].position[0] for name in ("left", "right")]
        assert ends == pytest.approx([1.5 * np.tanh(0.16 * (xhat + side * x[-1]) / 1.5) for side in (-1, 1)], abs=1e-9)
        assert poses["gate top"].scale[2] == pytest.approx(ends[1] - ends[0], abs=1e-9)
        (words, _, _), = o.stage.body.marks(x, x, 1.0).words
        assert float(words.split(" ")[2]) == pytest.approx(x[-1], rel=0.06)


def test_packets_leave_room_for_their_lamp() -> None:
    body = CASE_KINDS[SCALAR_CASE].body
    poses = body.pose([0.0, 1.0, 1.0, 1.0, *[1.0] * (2 * (PACKETS - 1)), 0.0, 0.0, 0.0, 1.0], 1.0)
    for side in ("sensor", "input"):
        last = abs(poses[f"{side} packet {PACKETS - 1}"].position[0]) + 0.065
        assert last < abs(poses[f"{side} lamp foot"].position[0]) - 0.12


def test_the_stage_lights_a_lamp_where_a_packet_has_come() -> None:
    o = outcome(loss=0.5)
    assert o.stage is not None
    at = [int(np.searchsorted(o.stage.t, k * 0.1 - 1e-9)) for k in range(RUN_SAMPLES)]
    assert np.array_equal(o.stage.x[at, 1] > 0.5, o.study.heard)
    assert o.stage.x[at, 0] == pytest.approx(o.study.x[:, 0])
    lit, dark = (CASE_KINDS[SCALAR_CASE].body.pose([0.0, heard, 1.0], 1.0)["sensor lamp"] for heard in (1.0, 0.0))
    assert lit.colour != dark.colour and lit.scale != dark.scale


@pytest.mark.parametrize("case", CASE_KINDS)
def test_a_belt_carries_the_last_packets_outwards_and_shows_which_were_lost(case: str) -> None:
    o = outcome(case=case, loss=0.4, loss_u=0.4)
    assert o.stage is not None
    per = (len(o.stage.t) - 1) // (RUN_SAMPLES - 1)
    for k in (0, 3, 20, RUN_SAMPLES - 1):
        for link, came in (("sensor", o.study.heard), ("input", o.study.fresh)):
            poses = [o.stage.body.pose(o.stage.x[k * per].tolist(), 1.0)[f"{link} packet {age}"] for age in range(PACKETS)]
            assert [pose.position[2] > 0 for pose in poses] == [age <= k for age in range(PACKETS)]
            assert [pose.colour == LIT_COLOUR for pose in poses[:k + 1]] == [bool(came[k - age]) for age in range(min(k + 1, PACKETS))]
            across = np.abs([pose.position[0] for pose in poses])
            assert np.all(np.diff(across) > 0)
            if per > 1 and k < RUN_SAMPLES - 1:
                later = o.stage.body.pose(o.stage.x[k * per + 1].tolist(), 1.0)
                assert abs(later[f"{link} packet 0"].position[0]) > across[0]


@pytest.mark.parametrize("loss", [0.0, 0.3, 0.75, 0.9])
def test_the_products_of_a_gap_shrink_only_below_the_limit(loss: float) -> None:
    """Every term of the mean is growth times probability; the caption says whether their sum is finite."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"loss": loss}))
    gaps = next(figure for figure in LESSON.figures(outcome) if figure.id == "gaps")
    growth, chance, product, _ = (curve.y for curve in gaps.curves)
    ratio = loss * outcome.study.watched.sampled.radius ** 2
    assert product[1] == pytest.approx(np.log10(ratio) if loss else -9 + growth[1], abs=1e-9)
    assert product[3] == pytest.approx(max(growth[3] + chance[3], -12.0), abs=1e-9) or loss == 0
    assert ("finite" in gaps.caption("en")) == (ratio < 1)


@pytest.mark.parametrize("told", ["applied", "ahead"])
@pytest.mark.parametrize("delay", [1, 2])
def test_the_green_ball_stands_where_the_late_force_was_right(told: str, delay: int) -> None:
    """Without look-ahead: the estimate of some samples ago; with it that estimate, run on by x⁺ = a x + u with the forces that acted."""
    o = outcome(delay=delay, told=told, loss_u=0.0)
    assert o.stage is not None and o.stage.xhat is not None and o.stage.note
    per, a = (len(o.stage.t) - 1) // (RUN_SAMPLES - 1), o.design["a"]
    for k in range(delay + 1, 20):
        place = float(o.stage.xhat[(k - delay) * per, 0])
        for sample in range(k - delay, k) if told == "ahead" else ():
            place = a * place + float(o.stage.u[sample * per, 0])  # type: ignore[index]
        drawn, ball = (o.stage.body.pose(state, 1.0)[name].position for state, name in (
            (o.stage.x[k * per].tolist(), "target"), ([place, *o.stage.x[k * per, 1:].tolist()], "ball")))
        assert drawn == pytest.approx(ball, abs=1e-6)
    there, here = (o.stage.body.pose(o.stage.x[3 * per].tolist(), 1.0)[name].position[0] for name in ("target", "ball"))
    assert told == "ahead" or delay == 2 or (there > 0.2 and here < 0 and o.stage.u[3 * per, 0] < 0)  # type: ignore[index]


def test_without_a_delay_no_green_ball_is_seen_and_nothing_is_said_of_it() -> None:
    o = outcome(delay=0)
    assert o.stage is not None and not o.stage.note
    assert all(o.stage.body.pose(state.tolist(), 1.0)["target"].position[2] < -1 for state in o.stage.x[::7])
