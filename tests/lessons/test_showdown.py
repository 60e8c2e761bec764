"""What must come out of the showdown lesson, and every number that its text states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from lesson_checks import carried

from observer_lab.colours import COLOURS
from observer_lab.course.lesson import Outcome
from observer_lab.engine import noisy_loop, sampled_lqg
from observer_lab.engine.sampled import loop_density, mechanics_response, simulate_trials, welch_expectation
from observer_lab.lessons import LESSONS
from observer_lab.lessons.showdown.controllers import ORDER, decoupled, first_belief, full, gain_gap, players, reduced, sampled_design
from observer_lab.lessons.showdown.lesson import LESSON
from observer_lab.lessons.showdown.simulation import band_rms, loop_of, measures, respond, world_of
from observer_lab.plants.platform import model, siso_loops
from observer_lab.plants.platform.channels import T_y
from observer_lab.plants.platform.lqg_weights import Weights, coils, ground, lqg

CHANNELS = ("vertical", "rotation", "horizontal")


def outcome(**values: Any) -> Outcome:
    return LESSON.compute(LESSON.apply(LESSON.start(), values))


def band(result: Outcome, player: str) -> np.ndarray:
    return np.array([result.metrics[f"{player}_{channel}_band_db"] for channel in CHANNELS])


def rms(result: Outcome, player: str) -> np.ndarray:
    return np.array([result.metrics[f"{player}_{channel}_rms"] for channel in CHANNELS])


def test_the_players_are_those_of_the_plants_modules() -> None:
    for v in (1e-10, 1e-13):
        weights, plant = Weights(v0=v), reduced()
        for ours, theirs in ((full(v), lqg(plant, weights).controller), (decoupled(v), siso_loops.decoupled_lqg(weights))):
            for s in (2j, 30j):
                one, two = (c.C @ np.linalg.solve(s * np.eye(c.n) - c.A, c.B) for c in (ours, theirs))
                assert np.abs(one - two).max() <= 1e-6 * np.abs(two).max()
        theirs = sampled_lqg(coils(plant), weights.Q(plant), weights.R, weights.W, weights.V, 1e-3, G=ground(plant))
        assert np.allclose(sampled_design(v).K, theirs.K) and np.allclose(sampled_design(v).filter.R, theirs.filter.R)


def test_spectra_and_sizes_are_those_of_the_lyapunov_equation() -> None:
    """RMS by the area of the drawn density, from 0.1 Hz up, beside the variance of the sampled loop."""
    start = outcome()
    match = start.study
    for i, player in enumerate(match.five):
        if player.id == "open":
            continue
        loop = loop_of(match.world, player)
        variance = np.diag(loop.outputs @ loop.covariance @ loop.outputs.T)[:3]
        assert np.allclose(match.rms[i], 1e6 * np.sqrt(variance), rtol=0.02)



def test_the_sampled_densities_are_the_continuous_loops_at_low_frequency() -> None:
    start = outcome()
    whole, weights = model.plant(), Weights(v0=1e-10)
    loop = noisy_loop(coils(whole), lqg(reduced(), weights).controller, ground(whole), weights.W, V=weights.V)
    f = start.study.f
    low = f < 20
    continuous = 1e12 * loop.psd(f[low], loop.outputs(T_y[:3]))
    assert np.abs(start.study.spectra[ORDER.index("lqe")].density[low, :3] / continuous - 1).max() < 0.02


def test_steady_and_recursive_filter_coincide() -> None:
    for v in (1e-9, 1e-10, 1e-11):
        assert outcome(v=v).metrics["filters_apart_db"] < 0.2
    t, away = gain_gap(1e-10)
    assert away[0] > 25 and away[-1] < 0.003 and t[-1] == pytest.approx(20, abs=0.1)
    schedule = sampled_design(1e-10).filter.schedule(first_belief(1e-10), 1025).gains
    goal = sampled_design(1e-10).filter.steady.filter_gain
    for step in (0, 1, 2):
        by_steps = np.linalg.norm(schedule[512 * step] - goal) / np.linalg.norm(goal)
        assert away[step] == pytest.approx(by_steps, rel=1e-5)


def test_the_scores_at_the_start() -> None:
    start = outcome()
    assert band(start, "siso") == pytest.approx([21.5, 9.45, 15.8], abs=0.06)
    assert band(start, "lqe") == pytest.approx([20.1, 13.1, 16.5], abs=0.06)
    assert band(start, "decoupled") == pytest.approx([20.1, 10.4, 16.5], abs=0.06)
    assert rms(start, "siso")[0] == pytest.approx(100, abs=0.5) and rms(start, "lqe")[0] == pytest.approx(25, abs=0.5)
    assert 1e3 * start.metrics["siso_force_rms"] == pytest.approx(424, abs=1)
    assert 1e3 * start.metrics["lqe_force_rms"] == pytest.approx(16, abs=0.5)


def test_the_orders_of_figures_23_to_25_as_far_as_they_come_out() -> None:
    """Horizontally nearly equal, rotation LQG < decoupled LQG < SISO; vertically the decoupled LQG is the full one."""
    start = outcome()
    across = [band(start, player)[2] for player in ("siso", "lqe", "decoupled")]
    assert max(across) - min(across) < 1.0
    turn = [rms(start, player)[1] for player in ("lqe", "decoupled", "siso")]
    assert turn == pytest.approx([2.54, 3.47, 4.34], abs=0.006)
    assert turn == sorted(turn)
    peaks = [start.metrics[f"{player}_rotation_peak_db"] for player in ("lqe", "decoupled")]
    assert peaks[1] > peaks[0]
    up = [rms(start, player)[0] for player in ("lqe", "siso", "decoupled")]
    assert up[0] == pytest.approx(up[2], rel=1e-3) and up[1] > 3 * up[0]


def test_full_lqg_is_best_in_rotation_and_vertical_where_it_believes_the_truth() -> None:
    for v in (1e-9, 1e-10, 1e-11, 1e-12):
        result = outcome(v=v, sensor=v)
        for other in ("siso", "decoupled"):
            assert np.all(rms(result, "lqe")[:2] <= 1.001 * rms(result, other)[:2])


def test_the_prediction_and_its_reveal() -> None:
    quiet = outcome(sensor=1e-14)
    assert band(quiet, "siso") == pytest.approx([50, 42, 46], abs=0.5)
    assert band(quiet, "lqe") == pytest.approx([23, 22, 19], abs=0.5)
    told = outcome(sensor=1e-14, v=1e-14)
    assert band(told, "lqe") == pytest.approx([58, 52, 53], abs=0.5)
    assert np.all(band(told, "lqe") > band(told, "siso"))
    assert "SISO" in LESSON.words["en"].options[LESSON.answer]


def test_the_numbers_of_the_solutions() -> None:
    assert band(outcome(sensor=1e-11), "lqe") == pytest.approx([22.6, 19.9, 19.0], abs=0.06)
    assert band(outcome(sensor=1e-11, v=1e-11), "lqe") == pytest.approx([28.8, 22.5, 23.7], abs=0.06)
    quiet = outcome(sensor=1e-14)
    assert band(quiet, "siso") - band(quiet, "lqe") == pytest.approx([26.7, 19.6, 26.9], abs=0.06)
    late = outcome(delay=8.0)
    assert band(late, "lqe") == pytest.approx([19.9, 13.0, 16.3], abs=0.06)
    assert outcome(delay=4.0).metrics["siso_stable"] and not outcome(delay=5.0).metrics["siso_stable"]


def test_what_breaks_at_one_kilohertz() -> None:
    assert not outcome(pair="published").metrics["siso_stable"]
    literal = outcome(v=1e-18)
    assert not literal.metrics["lqe_stable"] and literal.metrics["recursive_stable"]
    assert not outcome(driver="second", bandwidth=30.0).metrics["siso_stable"]
    assert outcome(driver="first", bandwidth=30.0).metrics["siso_stable"]
    held = outcome(driver="second", bandwidth=30.0)
    assert np.all(np.abs(band(held, "lqe") - band(outcome(), "lqe")) < 0.3)


def test_monte_carlo_of_a_player_meets_the_drawn_prediction() -> None:
    match = outcome().study
    loop = loop_of(match.world, match.five[ORDER.index("lqe")])
    result = list(simulate_trials(loop, 24, 16.0, 5, segment=8192))[-1][1]
    assert result is not None
    expected = welch_expectation(loop, 8192)
    inside = (result.frequency > 0.3) & (result.frequency < 100)
    away = np.abs(result.density - expected.density)[inside, :3] / (result.spread[inside, :3] / np.sqrt(24))
    assert np.mean(away < 2) > 0.9
    drawn = np.interp(result.frequency[inside], match.f, 1e-12 * match.spectra[ORDER.index("lqe")].density[:, 0])
    assert np.abs(np.log10(expected.density[inside, 0] / drawn)).max() < 0.05


def test_clipping_keeps_the_linear_response_where_it_does_not_bite() -> None:
    start = LESSON.start()
    player = players(1e-10, "own")[ORDER.index("lqe")]
    free = respond(world_of(start), player, False)
    wide = respond(world_of(LESSON.apply(start, {"limited": True, "limit": 1.0})), player, False)
    narrow = respond(world_of(LESSON.apply(start, {"limited": True, "limit": 0.005})), player, False)
    assert free is not None and wide is not None and narrow is not None
    assert np.allclose(free.velocity, wide.velocity)
    assert np.abs(narrow.u).max() == pytest.approx(0.005)
    reference = respond(world_of(start), players(1e-10, "own")[0], False)
    assert reference is not None
    slow, fast = measures(narrow, reference)[0].recovery, measures(free, reference)[0].recovery
    assert slow is not None and fast is not None and slow >= fast


def test_the_grid_catches_the_sharp_peaks() -> None:
    """Area without control, 0.5–3 Hz, by the drawn points and by a hundred times as many."""
    match = outcome().study
    fine = np.geomspace(0.5, 3.0, 60_000)
    loop = noisy_loop(coils(model.plant()), None, ground(model.plant()), 1e-12)
    exact = band_rms(fine, 1e12 * loop.psd(fine, loop.outputs(T_y[:3])), 0.5, 3.0)
    ours = band_rms(match.f, match.spectra[0].density[:, :3], 0.5, 3.0)
    assert np.allclose(ours, exact, rtol=1e-3)


def test_the_scores_are_those_of_every_loops_own_resonances_too() -> None:
    """Areas in the band to four thousandths, commands to a hundredth, by the drawn points and by many more."""
    for values in ({"damping": -90.0, "stiffness": -30.0}, {"v": 5.1e-13, "sensor": 6e-18, "delay": 7.05, "adc": 76.0}):
        match = outcome(**values).study
        poles = [p for player in match.five for p in np.linalg.eigvals(loop_of(match.world, player).closed()) if abs(p) > 0.1]
        s = np.log(np.array(poles, dtype=complex)) / (2e-3 * np.pi)
        s = s[(s.imag > 0.1) & (s.imag < 499) & (np.abs(s.real) < 0.1 * s.imag)]
        s = s[np.unique(np.round(np.log(s), 3), return_index=True)[1]]
        widths = np.concatenate([[0.0], *(side * np.geomspace(0.05, 500.0, 120) for side in (-1, 1))])
        fine = np.unique(np.concatenate([np.geomspace(0.1, 499.0, 2000), [0.5, 3.0], *(p.imag + abs(p.real) * widths for p in s)]))
        fine = fine[(fine >= 0.1) & (fine <= 499.0)]
        for i, player in enumerate(match.five):
            if not match.spectra[i].stable:
                continue
            loop = loop_of(match.world, player)
            S = loop_density(loop, mechanics_response(loop, fine))
            inside = (fine >= 0.5) & (fine <= 3.0)
            band = 1e6 * np.sqrt(np.trapezoid(S[inside, :3], fine[inside], axis=0))
            np.testing.assert_allclose(band_rms(match.f, match.spectra[i].density, 0.5, 3.0)[:3], band, rtol=4e-3)
            np.testing.assert_allclose(match.forces[i], np.sqrt(np.trapezoid(S[:, 5:], fine, axis=0)), rtol=0.01, atol=1e-12)


@pytest.mark.slow
def test_the_job_measures_what_the_tables_show() -> None:
    assert LESSON.job is not None
    last = None
    for _, last in LESSON.job.outcomes(outcome()):  # noqa: B007
        pass
    assert last is not None
    trials = last.study.trials
    found = 1e6 * np.sqrt(np.mean(trials.noise[2].rms[:, :3] ** 2, axis=0))
    assert np.allclose(found, last.study.rms[2], rtol=0.12)
    assert trials.learning[0].max() > 10 * trials.learning[-1].max() and trials.learning[-1].max() < 0.1
    assert np.isfinite(trials.decks[:, 1:]).all() and np.isfinite(trials.costs[:, 2]).all()
    assert np.all(np.abs(trials.costs[:2, 2]) < 0.3) and np.isnan(trials.costs[:2, 1]).all()  # driver and delay: SISO lost
    moved = LESSON.compute(LESSON.apply(LESSON.start(), {"play": "siso"}))
    assert carried(LESSON, last.design, trials, moved).study.trials is trials
    other = LESSON.compute(LESSON.apply(LESSON.start(), {"v": 1e-9}))
    assert carried(LESSON, last.design, trials, other).study.trials is None


def test_the_clock_ends_at_a_round_time_and_cells_of_three_numbers_do_not_break() -> None:
    outcome = LESSON.compute(LESSON.start())
    assert outcome.stage is not None and float(outcome.stage.t[-1]) == pytest.approx(2.4, abs=1e-12)
    times = next(f for f in LESSON.figures(outcome) if f.id == "times")
    assert all(" " not in cell for row in times.rows for cell in row[1:] if isinstance(cell, str))


def test_nothing_is_measured_on_a_run_that_was_held_because_its_loop_is_unstable() -> None:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"play": "siso", "pair": "published"}))
    captions = {f.id: f.caption("en") for f in LESSON.figures(outcome)}
    assert "unstable" in captions["stage_velocity"] and "unstable" in captions["stage_force"]


def test_a_controller_that_makes_it_worse_is_said_to_be_higher_and_not_minus_lower() -> None:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"ground": "shaped"}))
    said = next(f.caption("en") for f in LESSON.figures(outcome) if f.id == "sensor_left_h")
    assert "dB higher than" in said and "-" not in said


# --- tasks are not solved by the wrong design, nor by a knob at its stop -----------------------------------------------------
def _task(name: str):
    return next(t for t in LESSON.tasks if t.id == name)


@pytest.mark.parametrize("values", [
    {"driver": "second", "bandwidth": 30.0}, {"driver": "second", "bandwidth": 30.0, "delay": 4.2}, {"delay": 10.0}, {"delay": 4.6},
    {"delay": 4.0}, {"pair": "published", "delay": 4.2},
])
def test_the_loops_are_lost_by_the_delay_and_where_it_begins(values: dict[str, object]) -> None:
    assert not _task("late").check(outcome(**values)).solved
    assert _task("late").check(outcome(delay=4.1)).solved


def test_the_coarse_converter_is_borne_best_with_the_noise_that_is_there() -> None:
    """The numbers of the task: V₀ + Δ²h/12, and the valley about it; the typed result and its slips."""
    rms = {v: outcome(adc=1000.0, v=v).metrics["lqe_vertical_rms"] for v in (1e-10, 1.6e-10, 1.83e-10, 2.1e-10)}
    assert (f"{rms[1e-10]:.2f}", f"{rms[1.83e-10]:.2f}") == ("29.63", "28.94") and min(rms, key=rms.__getitem__) == 1.83e-10
    task, right = _task("coarse"), outcome(adc=1000.0, v=1.9e-10)
    assert task.judge(right, "1.83e-10").solved and task.judge(right, "1e-10 + 1e-9/12").solved
    for said, why in (("8.33e-11", "alone"), ("1.1e-9", "twelfth"), ("8.343e-8", "h times")):
        verdict = task.judge(right, said)
        assert not verdict.solved and why in verdict.text("en")
    assert [task.check(outcome(adc=1000.0, v=v)).solved for v in (1.7e-10, 1.76e-10, 1.91e-10, 1.97e-10)] == [False, True, True, False]


def test_both_yardsticks_are_met_between_too_deaf_and_too_loud() -> None:
    task, found = _task("yardsticks"), {v: outcome(v=v) for v in (1e-11, 3e-11, 1e-10)}
    said = [f"{o.metrics['lqe_vertical_band_db']:.1f} dB, {1e3 * o.metrics['lqe_force_rms']:.3g} mN" for o in found.values()]
    assert said == ["21.4 dB, 52.3 mN", "21.0 dB, 30 mN", "20.1 dB, 16.4 mN"]
    assert [task.check(o).solved for o in found.values()] == [False, True, False]
    assert not task.check(outcome(v=3e-11, sensor=1e-12)).solved and not task.check(outcome(v=3e-11, stiffness=20.0)).solved
    assert task.check(outcome(v=3e-11, delay=2.0)).solved


@pytest.mark.parametrize("sensor", [1e-18, 1e-14, 1e-13, 6e-13])
def test_the_optimum_is_not_beaten_by_the_quietest_sensor_of_all(sensor: float) -> None:
    assert not _task("beaten").check(outcome(sensor=sensor)).solved


def test_the_stage_has_the_deck_of_the_chosen_controller_above_its_rival_each_with_the_velocity_that_the_figure_states() -> None:
    """RMS of the vertical velocity after the first second, less its mean: on the bars, at their ends and in the figure's caption."""
    for chosen, rival in (("siso", "lqe"), ("lqe", "siso"), ("open", "lqe")):
        upper, lower = outcome(play=chosen), outcome(play=rival)
        stage, bare = upper.stage, upper.study.ghost
        assert stage is not None and stage.xhat is not None
        np.testing.assert_array_equal(stage.x[:, :20], np.hstack([upper.study.run[1], lower.study.run[1]]))
        np.testing.assert_array_equal(stage.xhat[:, :20], np.hstack([bare, bare]))
        late = upper.study.run[0] > 1.0
        sizes = [1e6 * np.sqrt(np.mean((x[late, 6] - np.mean(x[late, 6])) ** 2)) for x in (upper.study.run[1], lower.study.run[1], bare)]
        long = [stage.body.pose(stage.x[7].tolist(), 1.0)[f"{floor} bar"].scale[2] / 3.6 for floor in ("upper", "lower")]
        whole = [stage.body.pose(stage.xhat[7].tolist(), 1.0)[f"{floor} bar"].scale[2] / 3.6 for floor in ("upper", "lower")]
        np.testing.assert_allclose([*long, *whole], np.clip(np.array([*sizes, sizes[2]]) / 200, 0.01, 1.05))
        assert stage.body.marks is not None
        words = [said for said, _, _ in stage.body.marks(stage.x[7].tolist(), stage.xhat[7].tolist(), 1.0).words]
        assert [float(said.removesuffix(" µm/s")) for said in words] == pytest.approx(sizes[:2], rel=5e-3)
        caption = next(f.caption("en") for f in LESSON.figures(upper) if f.id == "stage_velocity")
        assert all(said in caption for said in words)


def test_one_colour_for_each_controller_on_the_stage_and_in_the_figures() -> None:
    roles = {"two SISO loops": "second", "LQG, steady LQE": "plant", "LQG, recursive filter": "reference", "decoupled LQG": "error"}
    for chosen, names in (("lqe", ("LQG, steady LQE", "two SISO loops")), ("siso", ("two SISO loops", "LQG, steady LQE")),
                          ("decoupled", ("decoupled LQG", "LQG, steady LQE"))):
        made = outcome(play=chosen)
        assert made.stage is not None
        parts = {part.name: part.colour for part in made.stage.body.parts}
        assert [words("en") for words, _ in made.stage.body.labels[:2]] == list(names)
        assert [parts[f"{floor} bar"] for floor in ("upper", "lower")] == [COLOURS[roles[name]] for name in names]
        for figure in LESSON.figures(made):
            if figure.id in ("stage_velocity", "suppression", "channel_rotation"):
                found = {curve.name("en"): curve.role for curve in figure.curves if curve.name("en") in roles}
                assert found and all(roles[name] == role for name, role in found.items()), figure.id


def test_rings_stand_where_the_bars_ended_at_the_start_and_only_where_something_has_changed() -> None:
    """Reductions in dB of a full bar of 60, with the noises of the start; the same ring for every change."""
    first = band(outcome(), "lqe")[1], band(outcome(), "siso")[1]
    for values in ({"sensor": 1e-14}, {"v": 1e-8}, {"damping": -90.0}):
        stage = outcome(bars="reduction", **values).stage
        assert stage is not None
        poses = stage.body.pose(stage.x[3].tolist(), 1.0)
        at = [(poses[f"{floor} ring"].position[0] + 2.45) / 3.6 for floor in ("upper", "lower")]
        assert at == pytest.approx([each / 60 for each in first])
        assert any("ring: at the start" in words("en") for words, _ in stage.body.labels)
    for values in ({"bars": "reduction"}, {"bars": "run"}, {"bars": "whole", "play": "siso"}, {"ground": "shaped", "v": 1e-12}):
        stage = outcome(**values).stage
        assert stage is not None and not any(part.name.endswith(" ring") for part in stage.body.parts)
        assert not any("ring" in words("en") for words, _ in stage.body.labels)


def test_the_lane_of_the_delay_has_its_bead_at_the_delay_and_an_unstable_deck_says_so() -> None:
    for delay, lost in ((0.0, False), (2.5, False), (6.0, True)):
        stage = outcome(bars="late", delay=delay).stage
        assert stage is not None
        x = stage.x[3].tolist()
        poses = stage.body.pose(x, 1.0)
        begin, end = (poses[f"lane {name}"].position[0] for name in ("start", "end"))
        assert (poses["lane bead"].position[0] - begin) / (end - begin) == pytest.approx(delay / 10)
        assert stage.body.labels[1][0]("en") == ("two SISO loops: unstable" if lost else "two SISO loops")
        assert (poses["lower bar"].scale[2] == pytest.approx(1.05 * 3.6)) == lost
        caption = next(f.caption("en") for f in LESSON.figures(outcome(bars="late", delay=delay)) if f.id == "stage_velocity")
        assert ("lower deck is unstable" in caption) == lost and ("on the lower deck" in caption) != lost
    plain = outcome().stage
    assert plain is not None and not any(part.name.startswith("lane") for part in plain.body.parts)


def bars_of(**values: object) -> tuple[dict[str, float], list[str], list[float]]:
    """Lengths of the bars in shares of a full one, their numbers, and the lengths of the bars without control."""
    stage = LESSONS["showdown"].compute(LESSONS["showdown"].apply(LESSONS["showdown"].start(), values)).stage
    assert stage is not None and stage.xhat is not None
    x, ghost = stage.x[5].tolist(), stage.body.pose(stage.xhat[5].tolist(), 1.0)
    poses = stage.body.pose(x, 1.0)
    long, bare = ({floor: each[f"{floor} bar"].scale[2] / 3.6 for floor in ("upper", "lower")} for each in (poses, ghost))
    return long, [words for words, _, _ in stage.body.marks(x, x, 1.0).words], list(bare.values())


def test_the_bars_of_the_stage_are_the_predicted_velocities_and_reductions() -> None:
    """Areas under the densities, summed here by the trapezium rule: a full bar is 200 µm/s, or 60 dB."""
    study = outcome().study
    f = study.f
    densities = {player: study.spectra[k].density for k, player in enumerate(("open", "siso", "lqe", "recursive", "decoupled"))}

    def rms(player: str, column: int, low: float, high: float) -> float:
        inside = np.flatnonzero((f >= low) & (f <= high))
        return float(np.sqrt(np.trapezoid(densities[player][inside, column], f[inside])))
    for bars, low, high in (("band", 0.5, 3.0), ("whole", 0.0, np.inf)):
        long, words, bare = bars_of(bars=bars)
        found = [rms(player, 0, low, high) for player in ("lqe", "siso")]
        assert [long["upper"], long["lower"]] == pytest.approx([max(each / 200, 0.01) for each in found], rel=0.02)
        assert [float(each.removesuffix(" µm/s")) for each in words] == pytest.approx(found, rel=0.02)
        assert bare == pytest.approx([rms("open", 0, low, high) / 200] * 2, rel=0.02)
    long, words, _ = bars_of(bars="reduction")
    found = [20 * np.log10(rms("open", 1, 0.5, 3.0) / rms(player, 1, 0.5, 3.0)) for player in ("lqe", "siso")]
    assert [long["upper"], long["lower"]] == pytest.approx([each / 60 for each in found], rel=0.02)
    assert [float(each.removesuffix(" dB")) for each in words] == pytest.approx(found, rel=0.02)


def test_an_unstable_loop_has_no_predicted_bar() -> None:
    long, words, _ = bars_of(bars="whole", delay=8.0)
    assert words[1] == "\N{EM DASH}" and long["lower"] == pytest.approx(0.01) and words[0].endswith("µm/s")


def test_what_acts_on_the_decks_is_named_on_both_and_only_then() -> None:
    """Delay, another damping and friction each stand at both decks with their size; friction only where the ground lets it act."""
    def tags(**values: object) -> list[str]:
        stage = LESSONS["showdown"].compute(LESSONS["showdown"].apply(LESSONS["showdown"].start(), values)).stage
        assert stage is not None
        return [words("en") for words, _ in stage.body.labels[2:-2]]

    assert tags() == [] == tags(friction=5.0)
    assert tags(delay=5.0) == 2 * ["delay 5 ms"]
    assert tags(damping=-90.0) == 2 * ["damping −90 %"]
    assert tags(friction=5.0, ground="shaped") == 2 * ["friction 5 mN"]


def test_a_filter_for_a_noise_a_hundred_times_too_large_reduces_the_rotation_less() -> None:
    """The full LQG below, the decoupled one above, both with shorter bars; the recall shows the full LQG above."""
    right, wrong = (bars_of(play="lqe", v=v, bars="reduction")[0] for v in (1e-10, 1e-8))
    assert wrong["upper"] < 0.3 * right["upper"] and wrong["lower"] == right["lower"]
    right, wrong = (bars_of(play="decoupled", sensor=1e-12, v=v, bars="reduction") for v in (1e-12, 1e-10))
    assert wrong[0]["lower"] < 0.75 * right[0]["lower"] and wrong[0]["upper"] < 0.95 * right[0]["upper"]
    assert [float(each.removesuffix(" dB")) for each in (right[1][1], wrong[1][1])] == pytest.approx([32.4, 22.1], abs=0.1)
