"""Right calls of the rooms in which something is estimated: filters, observers."""

from __future__ import annotations

from typing import Any

import numpy as np
from call_parts import I2, ONE, A, B, C, expand, of, ones, rhs, same, slope

from observer_lab import engine
from observer_lab.engine import Belief, KalmanFilter, Plant, functional_observer, lqe, unknown_input_observer


def filters(plant: Plant, dplant: Plant) -> dict[str, dict[str, Any]]:
    rng = np.random.default_rng(1)
    f = engine.filters
    nu, y, P = rng.standard_normal((80, 1)), rng.standard_normal((12, 1)), np.eye(2) / 2
    linear = {"A": dplant.A, "B": dplant.B, "C": dplant.C, "Q": I2, "R": ONE, "D": np.zeros((1, 1)), "dt": 0.1,
              "source": KalmanFilter.from_plant(plant, ONE, ONE, dt=0.1).source}
    bent = {"f": rhs, "h": same, "Q": ONE, "R": ONE}
    turned = {"y_minus": f.angles([0]), "x_minus": f.angles([0]), "x_plus": np.add}
    moments = {"t": np.arange(12) / 10, "R": ONE, "gate": 0.999}
    timed = {**moments, "Q": ONE}
    kf, ekf, ukf = KalmanFilter(**linear), f.ExtendedKalmanFilter(**bent), f.UnscentedKalmanFilter(**bent)
    belief, one = Belief([0, 0], I2), Belief([0], ONE)
    start = f.Beliefs.alike([0.0], ONE, 3)
    steering = f.Steering("ekf", np.zeros((1, 1)), np.ones(1))
    bending = engine.systems.NonlinearPlant(1, 0, 1, rhs, slope, same, ones)
    experiment = {"flow": rhs, "output": same, "Q": ONE, "R": ONE, "x0": np.ones((1, 3)), "start": start,
                  "inputs": np.zeros((4, 1)), "filters": {"ekf": ekf}, "steering": steering, "kicks": ((1, np.ones(1)),)}
    schedule = kf.schedule(belief, 12)
    noise = f.AdcNoise(1.0, 1.0, 0.1, 0.1)
    L = lqe(A, B, C, ONE, ONE).gain
    parts = f.error_parts(plant, L, B, ONE, ONE)
    spread = {"alpha": 1.0, "beta": 2.0, "kappa": 0.0}
    return {
        "AdcNoise": {"sigma": 1.0, "corner": 1.0, "lowest": 0.1, "dt": 0.1, "step": 0.1},
        **of(noise, "AdcNoise", density={"frequency": [1.0]}, draw={"steps": 3, "channels": 2, "rng": rng}, quantise={"y": y}),
        "Belief": {"mean": [0, 0], "covariance": I2},
        "Beliefs": {"mean": np.zeros((1, 3)), "covariance": np.ones((3, 1, 1)), "points": np.zeros((1, 3, 3))},
        "Beliefs.alike": {"self": f.Beliefs, "mean": [0.0], "covariance": ONE, "runs": 3},
        "Experiment": experiment,
        "ExtendedKalmanFilter": {**bent, "f_expand": expand, "h_expand": expand, **turned, "iterations": 2},
        "KalmanFilter": linear, "SquareRootFilter": linear,
        "LinearisedFilter": {**bent, **turned, "x_rest": np.zeros(1), "u_rest": np.zeros(0)},
        "PrintedUnscentedFilter": {**bent, **turned, **spread}, "UnscentedKalmanFilter": {**bent, **turned, **spread},
        "angles": {"rows": [0]},
        "MultipleModelFilter": {"filters": (kf, KalmanFilter(**{**linear, "Q": 4 * I2})), "switching": [[0.9, 0.1], [0.2, 0.8]]},
        **of(f.MultipleModelFilter((kf, kf), [[0.9, 0.1], [0.2, 0.8]]), "MultipleModelFilter",
             run={"start": belief, "y": y, "u": np.zeros((12, 1)), "probabilities": [0.5, 0.5]}),
        "Steering": {"by": "ekf", "gain": np.zeros((1, 1)), "u_max": np.ones(1)},
        "KalmanFilter.from_plant": {"self": KalmanFilter, "plant": plant, "W": ONE, "V": ONE, "dt": 0.1, "G": B},
        **of(kf, "KalmanFilter", predict={"belief": belief, "u": [0.0]}, correct={"belief": belief, "y": [1.0], "u": [0.0]},
              update={"belief": belief, "y": [1.0], "u": [0.0]}, short_update={"belief": belief, "y": [1.0], "u": [0.0]},
              schedule={"start": belief, "steps": 12, "seen": np.ones((12, 1), dtype=bool)},
              run={"start": belief, "y": y, "u": np.zeros((12, 1)), "schedule": schedule, "t": None, "R": None, "gate": None}),
        **of(KalmanFilter(**linear), "SquareRootFilter",
              run={"start": belief, "y": y, "u": np.zeros((12, 1)), "schedule": None, **moments}),
        **of(ekf, "ExtendedKalmanFilter", predict={"belief": one, "u": [], "t": 1.0, "dt": 0.1},
              correct={"belief": one, "y": [1.0], "u": [], "t": 1.0}, update={"belief": one, "y": [1.0], "u": []},
              run={"start": one, "y": y, "u": None, **timed}),
        **of(ukf, "UnscentedKalmanFilter", predict={"belief": one, "u": [], "t": 1.0, "dt": 0.1},
              correct={"belief": one, "y": [1.0], "u": [], "t": 1.0}, update={"belief": one, "y": [1.0], "u": []},
              run={"start": one, "y": y, "u": None, **timed}),
        "ParticleFilter": {**bent, "particles": 20},
        **of(f.ParticleFilter(**bent, particles=20), "ParticleFilter", run={"start": one, "y": y, "u": None, "rng": rng}),
        "h_infinity": {"A": A, "G": B, "C": C, "W": ONE, "V": ONE, "gamma": 2.0, "Z": C},
        "moving_horizon": {"model": kf, "y": y, "u": np.zeros((12, 1)), "start": belief, "lower": [-1.0, -1.0], "upper": [1.0, 1.0],
                           "horizon": 3},
        "smooth": {"model": kf, "track": kf.run(belief, y)},
        "as_record": {"value": y, "name": "y", "columns": 1, "rows": 12},
        "chi2_band": {"dof": 2, "count": 10, "level": 0.95},
        "predict": {"A": A, "Q": I2, "mean": np.zeros(2), "P": P},
        "correct": {"C": C, "R": ONE, "mean": np.zeros(2), "P": P, "y": np.ones(1)},
        "error_parts": {"plant": plant, "L": L, "G": B, "W": ONE, "V": ONE},
        "errors_squared": {"e": np.ones((3, 2)), "P": I2},
        "growing_error": {"plant": plant, "L": L, "parts": parts, "V": ONE, "dt": 0.1, "rows": C, "steps": 10},
        "independent_errors": {"Phi": dplant.A, "P": P, "steps": 10, "T": C},
        "innovation_test": {"innovations": nu, "S": ONE, "lags": 5, "level": 0.95},
        "whiteness": {"innovations": nu, "lags": 5, "level": 0.95},
        "joseph": {"P": P, "C": C, "R": ONE, "M": np.ones((2, 1))},
        "short_form": {"P": P, "C": C, "M": np.ones((2, 1))},
        "posterior_bound": {"F": np.array([[A / 4, A / 5]] * 3), "H": np.array([[C, 2 * C]] * 4), "Q": I2, "R": ONE, "P": P,
                            "unknown": "noise"},
        "posterior_covariances": {"A": dplant.A, "C": C, "Q": P, "R": ONE, "P": P, "steps": 3, "form": "short", "gain": np.ones((2, 1)),
                                  "single": True},
        "means_along": {"A": dplant.A, "C": C, "schedule": schedule, "start": np.zeros(2), "known": y, "push": np.zeros((12, 2))},
        "nees": {"x": nu, "xhat": nu + 1, "P": ONE, "level": 0.95, "independent": 20.0},
        "nis": {"innovations": nu, "S": ONE, "level": 0.95},
        "noise_ladder": {"plant": plant, "G": B, "W": ONE, "V": ONE, "ratio": np.array([0.1, 1.0])},
        "sigma_weights": {"n": 2, **spread},
        "simulate_filter": {"plant": plant, "G": B, "W": ONE, "V": ONE, "step": 0.1, "samples": 10, "believed": (1.0, 2.0), "seed": 1,
                            "kick": (0.3, np.ones(2))},
        "simulate_filters": {"e": f.Experiment(**experiment), "rng": rng},
        "slopes_along": {"plant": bending, "step": 0.1, "x": np.ones((1, 3)), "u": np.zeros((0, 3)), "parts": 2},
        "with_coloured_noise": {"plain": kf, "noise": noise},
    }


def observers(plant: Plant) -> dict[str, dict[str, Any]]:
    o = engine.observers
    bilinear = {"A": [[-1, 1], [0, -2]], "B": [[0], [1]], "F": [[0.1, 0], [0, 0]], "C": [[1, 0]]}
    found = o.bilinear_functional_observer(**bilinear, K=[[0, 1]], pole=-5)
    functional = functional_observer(plant, [[1, 1]], 1, poles=[-5])
    three = Plant(np.diag([-1.0, -2.0, -3.0]), np.ones((3, 1)), np.eye(3)[:2])
    E = np.array([[1.0], [0.0], [0.0]])
    model = KalmanFilter(np.diag([0.5, 0.8]), np.ones((2, 1)), I2, I2, I2)
    bank = o.FaultBank(model, tuple(o.residual_generator(model, outputs=[i]) for i in range(2)))
    known = unknown_input_observer(three, E, [-4, -5])
    rho = np.ones((20, 2))
    wrong = o.perturbations(plant, A=[A])
    region = o.Region(-10, -1, 0, 2)
    errors = {"dA": A / 10, "dC": C / 10}
    search = {"plant": plant, "K": [[1, 1]], "wrong": wrong, "norm": 2, "region": region, "max_order": 1, "measure": o.error_index,
              "seed": 1, "worst_condition": 1e4}
    return {
        "BilinearPlant": bilinear,
        "bilinear_functional_observer": {**bilinear, "K": [[0, 1]], "pole": -5},
        "simulate_bilinear": {"plant": found.plant, "form": found.without_derivative, "K": found.K, "u": np.sin, "x0": [1, 1],
                              "z0": [0.0], "horizon": 0.2, "dt": 0.01, "noise": np.zeros((21, 1))},
        "Region": {"re_low": -10.0, "re_high": -1.0, "im_low": 0.0, "im_high": 2.0},
        "alarm_probability": {"noncentrality": [1.0], "dof": 2, "false_alarm": 0.01},
        "binomial_band": {"count": 100, "rate": 0.1, "level": 0.99},
        "needed_noncentrality": {"dof": 2, "false_alarm": 0.01, "power": 0.9},
        "residual_threshold": {"dof": 2, "false_alarm": 0.01},
        "window_energy": {"residual": rho, "window": 5}, "window_mean": {"residual": rho, "window": 5},
        "criterion": {"T": functional.T, "L": functional.L, "M": functional.M, "wrong": wrong, "norm": 2},
        "decoupling": {"plant": three, "E": E, "weight": I2},
        "reduced_observer": {"plant": plant, "poles": [-4.0]},
        "ReducedObserver.estimates": {"self": o.reduced_observer(plant, [-4.0]), "w": np.zeros((5, 1)), "y": np.zeros((5, 1)),
                                      "u": np.zeros((5, 1))},
        "unknown_input_observer": {"plant": three, "E": E, "poles": [-4, -5]},
        "UnknownInputObserver.residuals": {"self": known, "plant": three, "E": E},
        "error_index": {"observer": functional, "wrong": wrong},
        "error_transfer": {"observer": functional, "omega": [1.0], **errors},
        "every_entry": {"plant": plant},
        "existence": {"plant": plant, "K": [[1, 1]], "poles": [-5]},
        "functional_observer": {"plant": plant, "K": [[1, 1]], "order": 1, "poles": [-5], "directions": [[1.0]], "W": ONE,
                                "free": None, "wrong": wrong, "norm": 2},
        "isolate": {"alarms": np.ones((5, 2), dtype=bool), "signature": I2.astype(bool)},
        "peak_gain": {"A": A, "B": B, "C": C, "D": np.zeros((1, 1))},
        "perturbations": {"plant": plant, "A": [A], "C": [C], "alpha": 1.0, "beta": [1.0], "gamma": 1.0},
        "perturbed_loop": {"observer": functional, **errors, "dB": B / 10},
        "residual_generator": {"model": model, "name": "r", "outputs": [0, 1], "E": [[1.0], [0.0]]},
        "rlo": search, "rlo_steps": search,
        "simulate_functional": {"observer": functional, "v": np.sin, "x0": [1, 0], "z0": [0.0], "horizon": 0.2, "dt": 0.01, **errors,
                                "dB": B / 10},
        "vertices": {"wrong": wrong, "delta_A": 0.1, "delta_C": ()},
        "worst_error_gain": {"observer": functional, "errors": [(A / 10, C / 10)]},
        **of(bank, "FaultBank", start={"x0": [0, 0], "rng": np.random.default_rng(0)}, response={"z": 1j},
              run={"y": np.ones((6, 2)), "u": np.zeros((6, 1)), "start": bank.start([0, 0])}),
    }
