"""Every public call of the engine with one call that is right: what nonsense is fed to, argument by argument.

`calls()` maps "room.name" to the call and its arguments, all by name; `ANSWERS` are the records that calls give back and
that nobody makes by hand. Whoever adds a public name adds it here.
"""

from __future__ import annotations

import importlib
import io
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from app import engine
from app.engine import (
    Belief,
    KalmanFilter,
    Link,
    NetworkScenario,
    Plant,
    Scenario,
    compensator,
    dlqe,
    functional_observer,
    lqe,
    lqr,
    noisy_loop,
    sensitivity,
    simulate,
    simulate_network,
    to_control,
    to_json,
    to_mat,
    unknown_input_observer,
)
from app.engine.simulation import Gear

ROOMS = ("systems", "structure", "design", "feedback", "simulation", "filters", "observers", "sampled", "network")
ANSWERS = frozenset({
    "systems.Balance", "structure.Canonisation", "structure.Controllability", "structure.CoprimeFactors", "structure.Dominance",
    "structure.Gramians", "structure.KalmanDecomposition", "structure.Mixing", "structure.Mode", "structure.Observability",
    "structure.StableSplit", "structure.Truncation", "design.Diophantine", "design.DiscreteFilter", "design.Optimal",
    "design.Placement", "design.StartingGain", "feedback.ChannelMargins", "feedback.ClosedLoop", "feedback.DiskMargin",
    "feedback.LoopMargins", "feedback.Lqg", "feedback.MultiMargins", "feedback.NoisyLoop", "feedback.Recovered",
    "feedback.Sensitivity", "feedback.TransferFunction", "filters.Correction", "filters.Corrections", "filters.ErrorParts",
    "filters.FilterTrial", "filters.InnovationTest", "filters.Ladder", "filters.RootBelief", "filters.Sample", "filters.Schedule",
    "filters.SquaredError", "filters.Track", "filters.Whiteness", "observers.Attempt", "observers.BilinearForm",
    "observers.BilinearObserver", "observers.BilinearRun", "observers.Decoupling", "observers.Existence", "observers.FaultBank",
    "observers.FunctionalObserver", "observers.FunctionalRun", "observers.Perturbations", "observers.ResidualGenerator",
    "observers.RobustObserver", "observers.UnknownInputObserver", "sampled.MechanicsResponse", "sampled.MonteCarlo",
    "sampled.ResponseMeasures", "sampled.SampledController", "sampled.SampledLoop", "sampled.SampledLqg", "sampled.SampledRun",
    "sampled.Trial", "network.CriticalLoss", "network.NetworkRun", "simulation.GearedRun", "simulation.RecoveryMap", "simulation.Run",
    "structure.Coupling", "systems.Spectrum",
})
NO_CALLS = frozenset({  # kinds of error, names of types, words, and kinds of filter that others are made of
    "systems.EngineError", "systems.PoleError", "systems.RiccatiError", "systems.ShapeError", "systems.Map", "systems.Poles",
    "systems.phrase", "observers.Norm", "filters.LinearFilter", "filters.NonlinearFilter",
})

A, B, C = np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
I2, ONE = np.eye(2), np.eye(1)


def public() -> dict[str, Any]:
    """Everything public, by "room.name"."""
    return {f"{room}.{name}": getattr(module, name) for room in ROOMS
            for module in [importlib.import_module(f"app.engine.{room}")] for name in module.__all__}


@cache
def calls() -> dict[str, dict[str, Any]]:
    """Arguments by name of one right call of each public name, methods as "room.Class.method"."""
    return {f"{room}.{name}": arguments for room, table in _tables().items() for name, arguments in table.items()}


def _tables() -> dict[str, dict[str, dict[str, Any]]]:
    plant = Plant(A, B, C)
    dplant = engine.systems.discretise(plant, 0.1)
    return {"systems": _systems(plant, dplant), "structure": _structure(plant), "design": _design(plant),
            "feedback": _feedback(plant), "simulation": _simulation(plant), "filters": _filters(plant, dplant),
            "observers": _observers(plant), "sampled": _sampled(plant), "network": _network(dplant)}


def _systems(plant: Plant, dplant: Plant) -> dict[str, dict[str, Any]]:
    rng = np.random.default_rng(0)
    file = io.BytesIO()
    to_mat(plant, file)
    path = Path(tempfile.mkdtemp()) / "plant.json"
    path.write_text(to_json(plant), encoding="utf-8")
    square = {"A": A, "B": B, "C": C, "D": np.zeros((1, 1))}
    return {
        "Plant": {**square, "dt": 0.1, "state_names": ("a", "b"), "input_names": ("u",), "output_names": ("y",),
                  "units": (("a", "m"),), "name": "p"},
        "Flow": {"rhs": _rhs, "step": 0.1, "parts": 2, "slope": _slope},
        "NonlinearPlant": {"n": 1, "m": 0, "p": 1, "rhs": _rhs, "slope": _slope, "output": _same, "output_slope": _ones, "name": "q"},
        "affine_scan": {"Phi": A, "forcing": np.zeros((30, 2)), "z0": np.ones(2), "steps": 30},
        "all_stable": {"poles": np.array([-1.0, -2.0]), "dt": 0.1},
        "amplitude_response": {**square, "omega": [1.0, 2.0], "dt": 0.1},
        "frequency_response": {**square, "omega": [1.0, 2.0], "dt": 0.1},
        "as_covariance": {"value": I2, "name": "P", "size": 2},
        "as_matrix": {"value": I2, "name": "P"},
        "balance": square,
        "check_poles": {"poles": [-1.0, -2.0], "count": 2},
        "continuous_of": {"plant": dplant},
        "discretise": {"plant": plant, "dt": 0.1},
        "each_column": {"one": lambda x, u: x},
        "from_control": {"system": to_control(plant)},
        "from_json": {"text": to_json(plant)},
        "from_mat": {"source": file.getvalue()},
        "held_scan": {"Phi": np.eye(4) / 2, "Gamma": np.ones((4, 1)), "inputs": np.ones((30, 1)), "z0": np.ones(4)},
        "invariant_zeros": square,
        "load_plant": {"path": path},
        "match_poles": {"a": [-1, -2], "b": [-2, -1]},
        "modal_coordinates": {"A": A, "B": B, "C": C},
        "move_pole": {"poles": [-1, -2], "index": 0, "to": -3 + 0j, "axis_snap": 0.1, "fixed": (1,)},
        "natural_scale": {"A": A, "B": B, "C": C},
        "state_scale": {"A": A, "B": B, "C": C},
        "pole_text": {"pole": -1 + 2j},
        "process_noise": {"M": A, "G": B, "W": ONE, "duration": 0.1, "steps": 5, "rng": rng},
        "psd": {"series": rng.standard_normal((64, 1)), "fs": 10.0, "segment": 16, "window": "hann"},
        "read_matrix": {"name": "plant.json", "data": b'{"F": [[2.0]]}', "key": "F"},
        "read_plant": {"name": "plant.json", "data": to_json(plant).encode()},
        "root": {"covariance": I2},
        "settled_covariance": {"A": A / 5, "G": B, "dt": 0.1},
        "slopes": {"f": _rhs, "x": np.ones((1, 3)), "u": np.zeros((0, 1)), "name": "f", "rows": 1},
        "sorted_poles": {"A": A},
        "stable_poles": {"A": A, "dt": 0.1},
        "step_covariance": {"A": A, "intensity": I2, "duration": 0.1},
        "step_matrices": {"M": A, "duration": 0.1},
        "symmetric": {"matrix": A},
        "to_control": {"plant": plant}, "to_json": {"plant": plant}, "to_mat": {"plant": plant, "path": io.BytesIO()},
        "transmission_zeros": {"plant": plant},
    }


def _structure(plant: Plant) -> dict[str, dict[str, Any]]:
    response = np.array([[[2, 0.5j], [0.3, 1 + 1j]]] * 3)
    square = Plant(np.diag([-1.0, -2.0]), I2, [[1, 0.2], [0.1, 1]])
    names = ("controllability", "observability", "kalman_decomposition")
    alone = ("coprime_factors", "gramians", "hankel_singular_values", "split_stable")
    return {
        **{name: {"plant": plant, "rtol": 1e-10} for name in names},
        **{name: {"plant": plant} for name in alone},
        "balanced_truncation": {"plant": plant, "order": 1},
        "best_mixing": {"response": response, "channels": (0, 1)},
        "coupling": {"response": response, "channels": (0, 1)},
        "canonise": {"M": A}, "canonise_right": {"M": A},
        "dominance": {"plant": square, "omega": [1.0, 2.0]},
        "dominance_of": {"omega": np.ones(3), "response": response},
        "mixing_matrix": {"a": 0.1, "b": 0.2, "size": 3, "channels": (0, 2)},
        "observability_gramian": {"plant": plant, "horizon": 1.0}, "reachability_gramian": {"plant": plant, "horizon": 1.0},
        "reachable_subspace": {"A": A, "B": B, "rtol": 1e-10}, "unobservable_subspace": {"A": A, "C": C, "rtol": 1e-10},
        "relative_gains": {"response": response},
    }


def _design(plant: Plant) -> dict[str, dict[str, Any]]:
    channel = engine.design.rational([1], [1, 1])
    shape = engine.design.LoopShape(2.0)
    estimate = {"A": A, "G": B, "C": C, "W": ONE, "V": ONE}
    regulate = {"A": A, "B": B, "Q": I2, "R": ONE, "N": np.zeros((2, 1))}
    return {
        "LoopShape": {"gain": 1.0, "lag": (1.0, 0.0), "lead": (1.0, 2.0), "roll_off": 10.0, "order": 2},
        "diagonal_controller": {"channels": [channel, None], "outputs": I2, "inputs": I2, "name": "d"},
        "diophantine": {"A": [1, 2, 1], "B": [1, 3], "desired": [1, 6, 11, 6]},
        "sylvester": {"A": [1, 2, 1], "B": [1, 3], "degree": 3},
        "dlqe": estimate, "lqe": estimate, "dlqr": regulate, "lqr": regulate,
        "in_natural_units": {"plant": plant},
        "loop_shaped": {"shape": shape},
        "negated": {"plant": plant},
        "observer_gain": {"A": A, "C": C, "poles": [-1, -2]}, "place": {"A": A, "B": B, "poles": [-1, -2]},
        "polynomial_roots": {"polynomial": [1, 3, 2]},
        "rational": {"numerator": [1], "denominator": [1, 1]},
        "realise": {"zeros": [-1], "poles": [-2, -3], "gain": 2.0},
        "series": {"last": channel, "first": channel},
        "shift_observer": {"A": A, "C": C, "L": engine.observer_gain(A, C, [-4, -5]).gain, "before": [-4, -5], "after": [-4, -6]},
        "shift_poles": {"A": A, "B": B, "K": engine.place(A, B, [-3, -4]).gain, "before": [-3, -4], "after": [-3, -5]},
        "starting_feedback": {"plant": plant, "eager": 2.0}, "starting_observer": {"plant": plant, "eager": 2.0},
        "typical_rate": {"plant": plant},
    }


def _feedback(plant: Plant) -> dict[str, dict[str, Any]]:
    K, L = lqr(A, B, I2, ONE).gain, lqe(A, B, C, ONE, ONE).gain
    controller = compensator(plant, K, L)
    noise = {"G": B, "W": ONE, "V": ONE}
    loop = noisy_loop(plant, controller, **noise)
    f = np.array([0.1, 1.0])
    return {
        "closed_loop": {"plant": plant, "K": K, "L": L, "model": plant},
        "compensator": {"plant": plant, "K": K, "L": L},
        "loop_margins": {"plant": plant, "controller": controller},
        "lqg": {"plant": plant, "Q": I2, "R": ONE, "W": ONE, "V": ONE, "G": B},
        "noisy_loop": {"plant": plant, "controller": controller, **noise},
        "recover": {"plant": plant, "K": K, "W": ONE, "V": ONE, "q": 10.0, "G": B},
        "recover_at_output": {"plant": plant, "L": L, "Q": I2, "R": ONE, "q": 10.0},
        "sensitivity": {"plant": plant, "controller": controller},
        "state_feedback_margins": {"plant": plant, "K": K},
        "to_tf": {"plant": plant},
        **_of(loop, "NoisyLoop", outputs={"T": ONE}, inputs={"T": ONE}, watching={"T": I2}, only={"disturbances": 1.0, "sensors": 0.5},
              psd={"frequency": f, "rows": I2, "ground": f}, parts={"frequency": f, "rows": I2, "ground": f},
              response={"frequency": f, "rows": I2}, variance={"rows": I2}, joint={"rows": I2}, cost={"Q": I2, "R": ONE}),
        **_of(noisy_loop(plant, None, B, ONE), "NoisyLoop", sampled={"dt": 0.1}),
        **_of(sensitivity(plant, controller), "Sensitivity", at={"omega": f}, along={"i": 0}),
    }


def _of(record: Any, name: str, **methods: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Calls of methods of a record, the record itself under "self"."""
    return {f"{name}.{method}": {"self": record, **arguments} for method, arguments in methods.items()}


def _simulation(plant: Plant) -> dict[str, dict[str, Any]]:
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
        "starts_of": {"s": scenario, "x_index": 0, "x_values": np.ones(2), "e_index": 1, "e_values": np.ones(3)},
        "Run.index": {"self": run, "time": 0.1},
    }


def _rhs(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return -x


def _slope(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return -np.ones((x.shape[1], 1, 1))


def _same(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return x


def _ones(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return np.ones((x.shape[1], 1, 1))


def _expand(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return x, np.ones((x.shape[1], 1, 1))


def _filters(plant: Plant, dplant: Plant) -> dict[str, dict[str, Any]]:
    rng = np.random.default_rng(1)
    f = engine.filters
    nu, y, P = rng.standard_normal((80, 1)), rng.standard_normal((12, 1)), np.eye(2) / 2
    linear = {"A": dplant.A, "B": dplant.B, "C": dplant.C, "Q": I2, "R": ONE, "D": np.zeros((1, 1)), "dt": 0.1}
    bent = {"f": _rhs, "h": _same, "Q": ONE, "R": ONE}
    kf, ekf, ukf = KalmanFilter(**linear), f.ExtendedKalmanFilter(**bent), f.UnscentedKalmanFilter(**bent)
    belief, one = Belief([0, 0], I2), Belief([0], ONE)
    start = f.Beliefs.alike([0.0], ONE, 3)
    steering = f.Steering("ekf", np.zeros((1, 1)), np.ones(1))
    experiment = {"flow": _rhs, "output": _same, "Q": ONE, "R": ONE, "x0": np.ones((1, 3)), "start": start,
                  "inputs": np.zeros((4, 1)), "filters": {"ekf": ekf}, "steering": steering, "kicks": ((1, np.ones(1)),)}
    schedule = kf.schedule(belief, 12)
    noise = f.AdcNoise(1.0, 1.0, 0.1, 0.1)
    L = lqe(A, B, C, ONE, ONE).gain
    parts = f.error_parts(plant, L, B, ONE, ONE)
    spread = {"alpha": 1.0, "beta": 2.0, "kappa": 0.0}
    return {
        "AdcNoise": {"sigma": 1.0, "corner": 1.0, "lowest": 0.1, "dt": 0.1, "step": 0.1},
        **_of(noise, "AdcNoise", density={"frequency": [1.0]}, draw={"steps": 3, "channels": 2, "rng": rng}, quantise={"y": y}),
        "Belief": {"mean": [0, 0], "covariance": I2},
        "Beliefs": {"mean": np.zeros((1, 3)), "covariance": np.ones((3, 1, 1)), "points": np.zeros((1, 3, 3))},
        "Beliefs.alike": {"self": f.Beliefs, "mean": [0.0], "covariance": ONE, "runs": 3},
        "Experiment": experiment,
        "ExtendedKalmanFilter": {**bent, "f_expand": _expand, "h_expand": _expand},
        "KalmanFilter": linear, "SquareRootFilter": linear,
        "LinearisedFilter": {**bent, "x_rest": np.zeros(1), "u_rest": np.zeros(0)},
        "PrintedUnscentedFilter": {**bent, **spread}, "UnscentedKalmanFilter": {**bent, **spread},
        "Steering": {"by": "ekf", "gain": np.zeros((1, 1)), "u_max": np.ones(1)},
        "KalmanFilter.from_plant": {"self": KalmanFilter, "plant": plant, "W": ONE, "V": ONE, "dt": 0.1, "G": B},
        **_of(kf, "KalmanFilter", predict={"belief": belief, "u": [0.0]}, correct={"belief": belief, "y": [1.0], "u": [0.0]},
              update={"belief": belief, "y": [1.0], "u": [0.0]}, short_update={"belief": belief, "y": [1.0], "u": [0.0]},
              schedule={"start": belief, "steps": 12, "seen": np.ones((12, 1), dtype=bool)},
              run={"start": belief, "y": y, "u": np.zeros((12, 1)), "schedule": schedule}),
        **_of(ekf, "ExtendedKalmanFilter", predict={"belief": one, "u": []}, correct={"belief": one, "y": [1.0], "u": []},
              update={"belief": one, "y": [1.0], "u": []}, run={"start": one, "y": y, "u": None}),
        **_of(ukf, "UnscentedKalmanFilter", predict={"belief": one, "u": []}, correct={"belief": one, "y": [1.0], "u": []},
              update={"belief": one, "y": [1.0], "u": []}, run={"start": one, "y": y, "u": None}),
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
        "with_coloured_noise": {"plain": kf, "noise": noise},
    }


def _observers(plant: Plant) -> dict[str, dict[str, Any]]:
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
        **_of(bank, "FaultBank", start={"x0": [0, 0], "rng": np.random.default_rng(0)}, response={"z": 1j},
              run={"y": np.ones((6, 2)), "u": np.zeros((6, 1)), "start": bank.start([0, 0])}),
    }


def _sampled(plant: Plant) -> dict[str, dict[str, Any]]:
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
        "welch_expectation": {"loop": loop, "length": 16},
        "SampledLoop.closed": {"self": loop, "k": 0},
        **_of(designed, "SampledLqg", controller_with={"M": designed.filter.steady.filter_gain}, schedule={"P0": I2, "steps": 5},
              draw={"steps": 5, "seed": 1, "process": I2, "readings": ONE}, loop={"process": I2, "readings": ONE},
              run={"x0": [1, 0], "w": np.zeros((5, 2)), "v": np.zeros((5, 1)), "gains": designed.schedule(I2, 5), "xhat0": [0, 0],
                   "truth": designed.plant}),
    }


def _network(dplant: Plant) -> dict[str, dict[str, Any]]:
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
        "age_of": {"arrivals": np.array([0, 2, -1])},
        "critical_loss": {"A": 1.2 * dplant.A, "C": C},
        "CriticalLoss.bounded": {"self": n.critical_loss([[1.2]], [[1]]), "loss": 0.1},
        "delayed_loop": {"plant": dplant, "K": K, "M": M, "delay": 2, "told": "asked", "ahead": 1},
        "intermittent_covariances": {**model, "P0": I2, "heard": heard}, "intermittent_steps": {**model, "P0": I2, "heard": heard},
        "lossy_growth": {"A": 1.2 * dplant.A, "C": C, "loss": 0.1, "steps": 50},
        "mare": {**model, "loss": 0.1},
        "mean_bounds": {**model, "P0": I2, "loss": [0.1, 0.2], "steps": 5},
        "mean_lower_limit": {"A": dplant.A, "Q": I2, "loss": 0.1},
        "mean_square_growth": {"plant": dplant, "K": K, "loss": 0.1, "on_loss": "zero"},
        "measured": {"P": I2, "C": C, "R": ONE},
        "network_meter": {"run": run, "promised": n.promised_error(run)},
        "promised_error": {"run": run},
        "riccati_step": {"P": I2, **model, "heard": 1.0},
        "simulate_network": {"s": NetworkScenario(**scenario)},
        "spectral_radius": {"matrix": A},
    }


def the_call(name: str) -> Callable[..., Any]:
    """The call behind a name of `calls()`; of a method, unbound or bound to its class, the record under "self" left out."""
    room, first, *rest = name.split(".")
    found = getattr(importlib.import_module(f"app.engine.{room}"), first)
    return getattr(calls()[name]["self"], rest[0]) if rest else found
