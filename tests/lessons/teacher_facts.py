"""The numbers in the notes for teachers: on which design each is read, and from which metric."""

from __future__ import annotations

from typing import Any

Fact = tuple[str, dict[str, Any], dict[str, str]]  # lesson; knobs that differ from the start; what the notes print, by metric
DOYLE: dict[str, Any] = {"case": "doyle"}
MIXED: dict[str, Any] = {"mix": "best", "f_low": 2.0, "f_high": 10.0}
HEARD: dict[str, Any] = {"delay": 2.0, "told": "ahead"}

PLAIN: tuple[Fact, ...] = (
    ("virtual-sensor", {"plant": "chip-runaway"}, {"copy_core_error": "83.2", "least_trust": "0.0295"}),
    ("virtual-sensor", {"air_error": 40.0, "trust": 0.3}, {"case_error": "0.37", "core_error": "0.15"}),
    ("virtual-sensor", {"air_error": 40.0, "trust": 1.0}, {"case_error": "0.11", "core_error": "0.43"}),
    ("virtual-sensor", {"observer_poles": (-4 - 0.5j, -4 + 0.5j)}, {"largest_guess": "114"}),
    ("error-dynamics", {"method": "printed"}, {"slowest_observer": "0.63", "error_moved": "0.92"}),
    ("error-dynamics", {"method": "numbers", "l1": 2.5, "l2": -1.25}, {"slowest_observer": "0.382"}),
    ("observability", {}, {"rank": "2"}),
    ("observability", {"left": 0.2}, {"rank": "6"}),
    ("observability", {"plant": "many", "count": 20.0}, {"rank": "7", "weakest": "0.46"}),
    ("separation", {"delay": 60.0}, {"separation_meter": "0.45"}),
    ("separation", {"stiffness_error": 13.0}, {"separation_meter": "0.10"}),
    ("separation", {"limited": True, "u_max": 0.5}, {"separation_meter": "0.48"}),
    ("separation", {}, {"largest_input": "0.96"}),
    ("duality", {"method": "weights", "mirror": False, "w": 40.0, "v": 10.0}, {"L1": "2.17", "L2": "0.36"}),
    ("duality", {"method": "weights", "mirror": False, "w": 4.0, "v": 1.0}, {"L1": "2.17", "L2": "0.36"}),
    ("hidden-modes", {}, {"hidden_rate": "0.5"}),
    ("hidden-modes", {"plant": "unseen-stable"}, {"error_rate": "0.25"}),
    ("hidden-modes", {"plant": "unmoved-unstable"}, {"state_rate": "0.5"}),
    ("saturation", {"fed": "applied"}, {"clipped_for": "0.34"}),
    ("saturation", {}, {"stopped_at": "0.76", "ceiling": "19"}),
    ("saturation", {"fed": "applied", "angle0": 8.0, "error0": 12.0}, {"comes_home": "0", "known_comes_home": "1"}),
    ("saturation", {"u_max": 8.0}, {"comes_home": "1", "clipped_for": "0"}),
    ("noise", {}, {"velocity_rms": "0.73", "peak": "2.13"}),
    ("noise", {"speed": 10.0}, {"velocity_rms": "2.12", "peak": "4.35"}),
    ("noise", {"speed": 0.3}, {"velocity_rms": "0.162"}),
    ("noise", {"speed": 1.0}, {"velocity_rms": "0.117"}),
    ("noise", {"w": 0.4, "v": 0.004}, {"kalman_speed": "3.17"}),
    ("kalman", {}, {"nis_mean": "3.79", "nees_mean": "61"}),
    ("kalman", {"q": 20.0, "r": 0.47}, {"nis_mean": "3.87"}),
    ("record", {"data": "masses", "order": 5}, {"deviation": "0.68"}),
    ("record", {"data": "masses", "order": 4}, {"deviation": "0.019"}),
    ("record", {"data": "masses"}, {"mean_nis": "0.87"}),
    ("record", {"data": "furnace"}, {"fit": "83", "mean_nis": "9.77"}),
    ("record", {"factor": 100.0}, {"mean_nis": "0.26"}),
    ("lqg", {**DOYLE, "gain": 1.03}, {"stable": "1"}),
    ("lqg", {**DOYLE, "gain": 1.05}, {"stable": "0"}),
    ("lqg", {**DOYLE, "q": 1000.0, "sigma": 1000.0, "recovery": 6.0}, {"phase_deg": "75"}),
    ("lqg", {}, {"J": "904"}),
    ("lqg", {"beta_r": 1.0}, {"J": "0.069"}),
    ("decoupling", {}, {"rotation": "88", "vertical": "93.5"}),
    ("decoupling", {"lower": 2.0}, {"rotation": "27.5"}),
    ("decoupling", {"lower": 5.0}, {"rotation": "19.6"}),
    ("decoupling", MIXED, {"J_plain": "2.43", "J": "0.032", "rotation": "9.3"}),
    ("decoupling", {"horizontal": "poles", "pitch": True}, {"rightmost": "6.1"}),
    ("decoupling", {"vertical": "shaped", "gain_v": 31250.0}, {"vertical": "93.5"}),
    ("weak-states", {}, {"rank_controllability": "4", "rank_observability": "4"}),
    ("weak-states", {"tolerance": 1e-6, "clock": 0.005}, {"rank_controllability": "10", "rank_observability": "10"}),
    ("weak-states", {"order": 6.0}, {"error": "0.108"}),
    ("weak-states", {"order": 5.0}, {"error": "86"}),
    ("showdown", {}, {"siso_vertical_band_db": "21.5", "lqe_vertical_band_db": "20.1", "siso_vertical_rms": "100",
                      "lqe_vertical_rms": "25"}),
    ("showdown", {"sensor": 1e-14}, {"siso_vertical_band_db": "50", "siso_rotation_band_db": "42", "siso_horizontal_band_db": "46",
                                     "lqe_vertical_band_db": "23", "lqe_rotation_band_db": "22", "lqe_horizontal_band_db": "19"}),
    ("showdown", {"delay": 4.2}, {"siso_stable": "0", "lqe_stable": "1"}),
    ("showdown", {"pair": "published"}, {"siso_stable": "0"}),
    ("nonlinear", {}, {"nees_ukf": "0.96", "nis_ekf": "1.4"}),
    ("robust-observer", {"pole": (-5 + 0j,)}, {"J": "118"}),
    ("robust-observer", {"pole": (-10 + 0j,)}, {"J": "333"}),
    ("robust-observer", {"pole": (-5 / 3 + 0j,)}, {"J": "4.22", "worst_gain": "0.874"}),
    ("robust-observer", {"pole": (-1.3 + 0j,)}, {"J": "14.1", "worst_gain": "0.820"}),
    ("robust-observer", {"example": "2", "w12": 1.2}, {"J": "46.65"}),
    ("robust-observer", {"example": "2", "w12": 0.0}, {"J": "42.40"}),
    ("robust-observer", {"example": "3"}, {"J": "12.5", "worst_gain": "0.913"}),
    ("robust-observer", {"example": "3", "free": -42.0}, {"J": "54.5", "worst_gain": "0.867"}),
    ("bilinear-observer", {"problem": "three-fitting"}, {"pole": "24.4"}),
    ("bilinear-observer", {"gain": "printed"}, {"pole": "5.02"}),
    ("bilinear-observer", {"form": "filtered", "tau": 0.02}, {"half_error": "0.097"}),
    ("bilinear-observer", {"form": "filtered", "tau": 0.01}, {"half_error": "0.049"}),
    ("bilinear-observer", {"noise": 0.01}, {"noise_rms": "0.33"}),
    ("bilinear-observer", {"noise": 0.01, "form": "filtered", "tau": 0.02}, {"noise_rms": "0.15"}),
    ("bilinear-observer", {}, {"A*": "6.468", "B*": "2.532"}),
    ("fault-diagnosis", {}, {"delay": "0.46", "right_verdict": "1", "between": "25.3"}),
    ("fault-diagnosis", {"place": "HR"}, {"delay": "0.48", "right_verdict": "1"}),
    ("fault-diagnosis", {"place": "u1"}, {"right_verdict": "0"}),
    ("fault-diagnosis", {"place": "u1", "loss": 100.0, "loop": "open", "force": 0.0}, {"right_verdict": "0"}),
    ("network", {"delay": 2.0}, {"separation_meter": "0", "loop_radius": "1.14"}),
    ("network", {"delay": 2.0, "told": "asked"}, {"separation_meter": "14"}),
    ("network", HEARD, {"loop_radius": "0.41"}),
    ("arm", {"cancel": False}, {"droop": "7.14"}),
    ("arm", {"load_state": False}, {"droop": "15.5", "angle_belief": "3.01"}),
    ("arm", {"gap": 1.0}, {"false_load": "0.11", "apart": "0.5"}),
    ("arm", {"gap": 1.0, "observer_poles": (-30 - 10j, -30 + 10j, -30 + 0j)}, {"false_load": "0.51"}),
    ("arm", {}, {"holding": "0.98"}),
    ("sandbox", {"limited": True}, {"separation_meter": "0.072"}),
    ("sandbox", {"sensor": 0.02, "belief": 0.05}, {"nis_expected": "3.02"}),
)
SHARES: tuple[Fact, ...] = (  # printed as per cent
    ("bilinear-observer", {"problem": "three"}, {"defect": "19.9"}),
    ("weak-states", {"order": 8.0}, {"gap": "0.0025"}),
    ("network", {}, {"critical": "69.4"}),
    ("network", {"case": "cart-pendulum"}, {"critical": "71.0"}),
    ("network", {"case": "cart-pendulum", "stretch": 0.6}, {"critical": "81.4"}),
)
TINY: tuple[Fact, ...] = (  # printed as so many times 10⁻⁵
    ("weak-states", {}, {"sigma9": "8.85"}),
    ("weak-states", {"kp": 18000.0}, {"sigma9": "8.82"}),
)
FACTS = ((1.0, PLAIN), (0.01, SHARES), (1e-5, TINY), (1e-4, (("weak-states", {"h": 0.03}, {"sigma9": "1.88"}),)),
         (1e-6, (("observability", {"plant": "pair", "gap": 1e-5}, {"weakest": "7.1"}),)))
# settings of knobs; in the remarks what a pencil finds and what a figure says in words
GIVEN: dict[str, tuple[str, ...]] = {
    "virtual-sensor": ("0.3", "0.5", "0.02", "0.05"),  # θ; 0.5 of the poles
    "error-dynamics": ("0.5", "1.5", "0.75", "2.5", "1.25", "2.618", "2.37"),  # the other root, 3 − 0.382 and 3 − 0.63
    "observability": ("0.2",),
    "separation": ("0.5",),
    "hidden-modes": ("2.2",),  # in the caption of "the motion of both blocks together"
    "noise": ("0.3",),
    "kalman": ("0.05", "0.47", "0.01"),
    "lqg": ("1.03", "1.05", "1.04", "1.00088"),  # 1 + 1/(df)
    "weak-states": ("0.03",),
    "robust-observer": ("1.3", "1.2"),
    "fault-diagnosis": ("0.02",),
    "network": ("0.6",),
    "nonlinear": ("0.2",),
    "showdown": ("4.2", "0.1"),  # 20.07 − 19.97 dB
    "arm": ("1.5",),
    "bilinear-observer": ("0.01",),
    "sandbox": ("0.29", "0.30", "0.02", "0.05"),  # 0.30 in the first row of the verdicts
}
