"""Right calls of the rooms in which a plant is described, looked into and given gains: systems, structure, design."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import scipy.signal
from call_parts import I2, ONE, A, B, C, ones, rhs, same, slope

from observer_lab import engine
from observer_lab.engine import Plant, to_control, to_json, to_mat
from observer_lab.engine.systems import discretise


def systems(plant: Plant, dplant: Plant) -> dict[str, dict[str, Any]]:
    rng = np.random.default_rng(0)
    square = {"A": A, "B": B, "C": C, "D": np.zeros((1, 1))}
    return {
        "Plant": {**square, "dt": 0.1, "state_names": ("a", "b"), "input_names": ("u",), "output_names": ("y",),
                  "units": (("a", "m"),), "name": "p", "notes": ("n",)},
        "Flow": {"rhs": rhs, "step": 0.1, "parts": 2, "slope": slope},
        "NonlinearPlant": {"n": 1, "m": 0, "p": 1, "rhs": rhs, "slope": slope, "output": same, "output_slope": ones, "name": "q"},
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
        "held_scan": {"Phi": np.eye(4) / 2, "Gamma": np.ones((4, 1)), "inputs": np.ones((30, 1)), "z0": np.ones(4)},
        "invariant_zeros": square,
        "match_poles": {"a": [-1, -2], "b": [-2, -1]},
        "modal_coordinates": {"A": A, "B": B, "C": C},
        "move_pole": {"poles": [-1, -2], "index": 0, "to": -3 + 0j, "axis_snap": 0.1, "fixed": (1,)},
        "pair_conjugates": {"poles": [-1 + 1j, -1 - 1j], "rtol": 1e-9, "floor": 1.0},
        "natural_scale": {"A": A, "B": B, "C": C},
        "state_scale": {"A": A, "B": B, "C": C},
        "pole_text": {"pole": -1 + 2j},
        "process_noise": {"M": A, "G": B, "W": ONE, "duration": 0.1, "steps": 5, "rng": rng},
        "psd": {"series": rng.standard_normal((64, 1)), "fs": 10.0, "segment": 16, "window": "hann"},
        "root": {"covariance": I2},
        "settled_covariance": {"A": A / 5, "G": B, "dt": 0.1},
        "slopes": {"f": rhs, "x": np.ones((1, 3)), "u": np.zeros((0, 1)), "name": "f", "rows": 1},
        "sorted_poles": {"A": A},
        "stable_poles": {"A": A, "dt": 0.1},
        "is_stable": {"A": A, "dt": 0.1},
        "step_covariance": {"A": A, "intensity": I2, "duration": 0.1},
        "step_matrices": {"M": A, "duration": 0.1},
        "symmetric": {"matrix": A},
        "transmission_zeros": {"plant": plant},
    }


def plant_files(plant: Plant) -> dict[str, dict[str, Any]]:
    file = io.BytesIO()
    to_mat(plant, file)
    path = Path(tempfile.mkdtemp()) / "plant.json"
    path.write_text(to_json(plant), encoding="utf-8")
    return {
        "from_control": {"system": to_control(plant)},
        "from_json": {"text": to_json(plant)},
        "from_mat": {"source": file.getvalue()},
        "from_scipy": {"system": scipy.signal.lti(A, B, C, [[0.0]])},
        "load_plant": {"path": path},
        "read_content": {"name": "plant.json", "data": to_json(plant).encode()},
        "read_plant": {"name": "plant.json", "data": to_json(plant).encode()},
        "reduced_to": {"plant": plant, "most": 1},
        "to_control": {"plant": plant}, "to_json": {"plant": plant}, "to_mat": {"plant": plant, "path": io.BytesIO()},
    }


def structure(plant: Plant) -> dict[str, dict[str, Any]]:
    response = np.array([[[2, 0.5j], [0.3, 1 + 1j]]] * 3)
    square = Plant(np.diag([-1.0, -2.0]), I2, [[1, 0.2], [0.1, 1]])
    names = ("controllability", "observability", "kalman_decomposition")
    alone = ("controllability_matrix", "coprime_factors", "gramians", "hankel_singular_values", "observability_matrix", "split_stable")
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


def design(plant: Plant) -> dict[str, dict[str, Any]]:
    channel = engine.design.rational([1], [1, 1])
    shape = engine.design.LoopShape(2.0)
    estimate = {"A": A, "G": B, "C": C, "W": ONE, "V": ONE, "N": ONE / 2}
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
        "observer_gain": {"A": A, "C": C, "poles": [-1, -2], "sizes": [1.0, 2.0]},
        "place": {"A": A, "B": B, "poles": [-1, -2], "sizes": [1.0, 2.0]},
        "polynomial_roots": {"polynomial": [1, 3, 2]},
        "rational": {"numerator": [1], "denominator": [1, 1]},
        "realise": {"zeros": [-1], "poles": [-2, -3], "gain": 2.0},
        "series": {"last": channel, "first": channel},
        "shift_observer": {"A": A, "C": C, "L": engine.observer_gain(A, C, [-4, -5]).gain, "before": [-4, -5], "after": [-4, -6]},
        "shift_poles": {"A": A, "B": B, "K": engine.place(A, B, [-3, -4]).gain, "before": [-3, -4], "after": [-3, -5]},
        "starting_feedback": {"plant": plant, "eager": 2.0}, "starting_observer": {"plant": plant, "eager": 2.0},
        "typical_rate": {"plant": plant},
    }


def aliases(plant: Plant) -> dict[str, dict[str, Any]]:
    regulate = {"A": A, "B": B, "Q": I2, "R": ONE, "S": np.zeros((2, 1))}
    return {
        **{name: {"plant": plant} for name in ("ctrb", "obsv", "hsvd", "poles", "zeros")},
        "acker": {"A": A, "B": B, "poles": [-1, -2]}, "c2d": {"plant": plant, "Ts": 0.1, "method": "tustin"},
        "d2c": {"plant": discretise(plant, 0.1), "method": "zoh"},
        "care": regulate, "dare": regulate, "lyap": {"A": A, "Q": I2, "C": None, "E": I2},
        "dlyap": {"A": A / 5, "Q": I2, "C": I2, "E": None},
        "estim": {"plant": plant, "L": np.ones((2, 1)), "sensors": [0], "known": [0]},
        "kalman": {"plant": plant, "Qn": ONE, "Rn": ONE, "Nn": ONE / 2, "type": "delayed"},
        "gram": {"plant": plant, "type": "c"}, "ss": {"A": A, "B": B, "C": C, "D": np.zeros((1, 1)), "dt": 0.1},
        "tf": {"num": [1.0], "den": [1.0, 2.0], "dt": 0.1},
    }
