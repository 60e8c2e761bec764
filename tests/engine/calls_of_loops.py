"""Right calls of the rooms in which a loop is closed and run: feedback, simulation, sampled, network."""

from __future__ import annotations

from typing import Any

import numpy as np
from call_parts import I2, ONE, A, B, C, of

from observer_lab import engine
from observer_lab.engine import (
    Belief,
    KalmanFilter,
    Link,
    NetworkScenario,
    Plant,
    Scenario,
    compensator,
    dlqe,
    lqe,
    lqr,
    noisy_loop,
    sensitivity,
    simulate,
    simulate_network,
)
from observer_lab.engine.feedback import reference_gain
from observer_lab.engine.simulation import Gear


def feedback(plant: Plant) -> dict[str, dict[str, Any]]:
    K, L = lqr(A, B, I2, ONE).gain, lqe(A, B, C, ONE, ONE).gain
    controller = compensator(plant, K, L)
    noise = {"G": B, "W": ONE, "V": ONE}
    loop = noisy_loop(plant, controller, **noise)
    f = np.array([0.1, 1.0])
    return {
        "closed_loop": {"plant": plant, "K": K, "L": L, "model": plant},
        "compensator": {"plant": plant, "K": K, "L": L},
        "integral_action": {"plant": plant, "K": K, "rate": 1.0, "N": reference_gain(plant, K)},
        "loop_margins": {"plant": plant, "controller": controller},
        "lqg": {"plant": plant, "Q": I2, "R": ONE, "W": ONE, "V": ONE, "G": B},
        "noisy_loop": {"plant": plant, "controller": controller, **noise},
        "recover": {"plant": plant, "K": K, "W": ONE, "V": ONE, "q": 10.0, "G": B},
        "reference_gain": {"plant": plant, "K": K},
        "recover_at_output": {"plant": plant, "L": L, "Q": I2, "R": ONE, "q": 10.0},
        "sensitivity": {"plant": plant, "controller": controller},
        "state_feedback_margins": {"plant": plant, "K": K},
        "to_tf": {"plant": plant},
        **of(loop, "NoisyLoop", outputs={"T": ONE}, inputs={"T": ONE}, watching={"T": I2}, only={"disturbances": 1.0, "sensors": 0.5},
              psd={"frequency": f, "rows": I2, "ground": f}, parts={"frequency": f, "rows": I2, "ground": f},
              response={"frequency": f, "rows": I2}, variance={"rows": I2}, joint={"rows": I2}, cost={"Q": I2, "R": ONE}),
        **of(noisy_loop(plant, None, B, ONE), "NoisyLoop", sampled={"dt": 0.1}),
        **of(sensitivity(plant, controller), "Sensitivity", at={"omega": f}, along={"i": 0}, corner={"omega": f, "count": 1},
             own={"i": 0}),
    }


def simulation(plant: Plant) -> dict[str, dict[str, Any]]:
    K, L = np.array([[1.0, 1.0]]), np.array([[3.0], [2.0]])
    scenario = Scenario(plant, K, L, x0=[1, 0], horizon=0.2, u_max=1.0)
    run = simulate(scenario)
    noisy = {"reference": np.zeros((21, 1)), "u_min": -2.0, "u_max": [2.0], "fed": "applied", "W": ONE, "V": ONE, "G": B, "seed": 1}
    return {
        "Scenario": {"plant": plant, "K": K, "L": L, "model": plant, "x0": [1, 0], "xhat0": [0, 0], "horizon": 0.2, "dt": 0.01,
                     "sampled": True, "state_feedback": False, **noisy, "delay": 0.02, "impulses": ((0.1, [1, 0]),)},
        "autonomous_error": {"run": run}, "separation_meter": {"run": run},
        "emulated_gain": {"plant": plant, "L": L, "dt": 0.1},
        "disturbances_of": {"scenario": scenario},
        "simulate": {"scenario": scenario},
        "Gear": {"angle": 0, "speed": 1, "inner": 0.5, "outer": 0.5, "load": [0, -1], "gap": 0.01, "sensor": "inner", "step": 0.001},
        "simulate_geared": {"scenario": scenario, "gear": Gear(0, 1, 0.5, 0.5, [0, -1], gap=0.01)},
        "simulate_recovery": {"scenario": scenario, "x_index": 0, "x_values": [-1, 1], "e_index": 1, "e_values": [0, 1],
                              "threshold": 0.1, "bound": 100.0, "slice_seconds": 0.01},
        "simulate_starts": {"scenario": scenario, "starts": np.ones((3, 4))},
        "simulate_until": {"scenario": scenario, "looks": [0.1], "enough": lambda x: bool(abs(x).max() > 1e3)},
        "starts_of": {"s": scenario, "x_index": 0, "x_values": np.ones(2), "e_index": 1, "e_values": np.ones(3)},
        "Run.index": {"self": run, "time": 0.1},
    }


def sampled(plant: Plant) -> dict[str, dict[str, Any]]:
    s = engine.sampled
    K, L = lqr(A, B, I2, ONE).gain, lqe(A, B, C, ONE, ONE).gain
    controller = s.sampled_controller(compensator(plant, K, L), 0.1)
    hardware = s.Hardware(limit=5.0, bandwidth=20.0)
    wide = Plant(A, np.hstack([B, B]), C)
    ground = Plant([[-1.0]], [[1.0]], [[1.0]])
    loop = s.sampled_loop(wide, controller, [0], hardware=hardware, W=ONE, V=ONE)
    response = s.mechanics_response(loop, [0.1, 1.0])
    estimator = KalmanFilter.from_plant(plant, ONE, ONE, dt=0.1)
    designed = s.sampled_lqg(plant, I2, ONE, ONE, ONE, 0.1)
    t = np.arange(20) * 0.1
    return {
        "Hardware": {"limit": 5.0, "bandwidth": 20.0, "order": 2, "walk": 0.1, "ramp": 0.1, "step": 0.1, "delay": 0.01},
        "coil_driver": {"hardware": hardware, "coils": 2},
        "loop_density": {"loop": loop, "mechanics": response},
        "mechanics_response": {"loop": loop, "frequency": [0.1, 1.0]},
        "recursive_controller": {"estimator": estimator, "K": K, "start": Belief([0, 0], I2), "steps": 10, "told": "applied"},
        "response_measures": {"t": t, "y": np.exp(-t), "u": np.ones((20, 1)), "band": 0.1, "final": 0.0},
        "sampled_controller": {"controller": compensator(plant, K, L), "dt": 0.1, "method": "hold"},
        "sampled_cost": {"plant": plant, "Q": I2, "R": ONE, "dt": 0.1},
        "sampled_loop": {"plant": wide, "controller": controller, "controls": [0], "hardware": hardware, "W": ONE, "V": ONE,
                         "shaping": ground, "disturbances": B, "outputs": I2},
        "sampled_lqg": {"plant": plant, "Q": I2, "R": ONE, "W": ONE, "V": ONE, "dt": 0.1, "G": B},
        "simulate_trial": {"loop": loop, "steps": 12, "seed": 1, "start": np.zeros(loop.n), "disturbance": np.zeros((12, 1)),
                           "kicks": ((2, [1.0, 0.0]),)},
        "simulate_trials": {"loop": loop, "runs": 2, "seconds": 4.0, "seed": 1, "segment": 16, "together": 2},
        "thin_root": {"Q": I2},
        "trial_draws": {"loop": loop, "steps": 5, "seed": 1},
        "welch_expectation": {"loop": loop, "length": 16},
        "SampledLoop.closed": {"self": loop, "k": 0},
        **of(designed, "SampledLqg", controller_with={"M": designed.filter.steady.filter_gain}, schedule={"P0": I2, "steps": 5},
              draw={"steps": 5, "seed": 1, "process": I2, "readings": ONE}, loop={"process": I2, "readings": ONE},
              run={"x0": [1, 0], "w": np.zeros((5, 2)), "v": np.zeros((5, 1)), "gains": designed.schedule(I2, 5), "xhat0": [0, 0],
                   "truth": designed.plant}),
    }


def network(dplant: Plant) -> dict[str, dict[str, Any]]:
    n = engine.network
    model = {"A": dplant.A, "C": C, "Q": I2, "R": ONE}
    K = np.array([[1.0, 1.0]])
    scenario = {"plant": dplant, "K": K, "Q": I2, "R": ONE, "P0": I2, "x0": [1, 0], "steps": 12, "sensor": Link(loss=0.1),
                "actuator": Link(delay=1), "on_loss": "zero", "told": "asked", "order": "arrival", "ahead": 1,
                "jumps": np.zeros((12, 2)), "seed": 1}
    run = simulate_network(NetworkScenario(**scenario))
    M = dlqe(dplant.A, I2, C, I2, ONE).filter_gain
    heard = np.array([1, 0, 1])
    return {
        "Link": {"loss": 0.1, "delay": 1, "jitter": 2},
        "Link.draw": {"self": Link(loss=0.1), "steps": 5, "rng": np.random.default_rng(0)},
        "NetworkScenario": scenario,
        "newest_packet_age": {"arrivals": np.array([0, 2, -1])},
        "critical_loss": {"A": 1.2 * dplant.A, "C": C},
        "CriticalLoss.bounded": {"self": n.critical_loss([[1.2]], [[1]]), "loss": 0.1},
        "delayed_loop": {"plant": dplant, "K": K, "M": M, "delay": 2, "told": "asked", "ahead": 1},
        "intermittent_covariances": {**model, "P0": I2, "heard": heard}, "intermittent_steps": {**model, "P0": I2, "heard": heard},
        "lossy_growth": {"A": 1.2 * dplant.A, "C": C, "loss": 0.1, "steps": 50},
        "mare": {**model, "loss": 0.1},
        "mean_bounds": {**model, "P0": I2, "loss": [0.1, 0.2], "steps": 5},
        "mean_lower_limit": {"A": dplant.A, "Q": I2, "loss": 0.1},
        "mean_square_growth": {"plant": dplant, "K": K, "loss": 0.1, "on_loss": "zero"},
        "corrected_covariance": {"P": I2, "C": C, "R": ONE},
        "network_meter": {"run": run, "promised": n.promised_error(run)},
        "promised_error": {"run": run},
        "riccati_step": {"P": I2, **model, "heard": 1.0},
        "simulate_network": {"s": NetworkScenario(**scenario)},
        "spectral_radius": {"matrix": A},
    }
