"""Describe five controllers on one platform as code: plant, controllers, hardware, results."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.engine.sampled import SampledLoop, trial_draws
from observer_lab.plants.platform.channels import T_u, T_y
from observer_lab.plants.platform.lqg_weights import GROUND_UNIT, S_Y, Weights, coils, ground

from .controllers import DT, OPEN_LOOP, ORDER, SCALES, channel, channel_filter, full, reduced, sampled_design, siso_pair
from .friction import friction_of
from .simulation import BAND_HZ, GROUND_STEP_M, RUN_SAMPLES, TOUCH_JUMP, ground_filter, loop_of, plant_of
from .study import Study

NOT_IN_SCRIPT = "The long computation, and the way of the recursive gain to its settled value"
WILD = 1e6  # growth over the run beyond which it magnifies rounding too far to be found again
CHANNEL_NAMES = ("vertical", "rotation", "horizontal")


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    world, w = study.world, Weights()
    plant, outputs = plant_of(world.parameters)
    whole, own, sampled, filter8 = reduced(), siso_pair(d["pair"]), sampled_design(d["v"]), ground_filter()
    hardware, made = world.hardware, full(d["v"])
    loop = loop_of(world, study.five[0])
    shown = [ShownValue(f"stable['{name}']", m[f"{name}_stable"], 1.0) for name in ORDER]
    for i, name in enumerate(ORDER):
        if not study.spectra[i].stable:
            continue
        density, response = study.spectra[i].density, study.responses[i]
        shown += [ShownValue(f"velocity_density['{name}']", density[:, :5]), ShownValue(f"force_density['{name}']", density[:, 5:]),
                  ShownValue(f"rms['{name}']", [m[f"{name}_{one}_rms"] for one in CHANNEL_NAMES]),
                  ShownValue(f"band_db['{name}']", [m[f"{name}_{one}_band_db"] for one in CHANNEL_NAMES], 1.0),
                  ShownValue(f"peak_db['{name}']", [m[f"{name}_{one}_peak_db"] for one in CHANNEL_NAMES], 1.0),
                  ShownValue(f"worst_db['{name}']", m[f"{name}_worst_db"], 1.0), ShownValue(f"forces['{name}']", study.forces[i]),
                  ShownValue(f"peak_force['{name}']", m[f"{name}_peak_force"]), ShownValue(f"energy['{name}']", m[f"{name}_energy"])]
        if response is not None:
            shown.append(ShownValue(f"velocity['{name}']", response.velocity))
    if "filters_apart_db" in m:
        shown.append(ShownValue("filters_apart_db", m["filters_apart_db"], 1.0))
    chosen = loop_of(world, study.five[ORDER.index(d["play"])])
    held = RUN_SAMPLES * np.log(chosen.radius) < np.log(WILD)
    if held:
        shown += [ShownValue("x", study.run[1]), ShownValue("u", study.run[2])]
    if held or d["play"] != OPEN_LOOP:
        shown.append(ShownValue("ghost", study.ghost))
    kick = min(round(d["kick"] / DT), RUN_SAMPLES - 1) if d["kick"] >= 0 else -1
    return Code(
        ("showdown",),
        (
            GivenValue("A", plant.A, "the platform as it is: dx/dt = A x + B u + G (ground), y = C x + v"),
            GivenValue("B", coils(plant).B),
            GivenValue("G", ground(plant)),
            GivenValue("C", plant.C),
            GivenValue("read", outputs, "what is looked at: vertical, rotation, horizontal, left and right vertical velocity"),
            GivenValue("T_y", T_y[:3], "readings to vertical, rotation, horizontal"),
            GivenValue("T_u", T_u, "common, differential, horizontal to coils"),
            GivenValue("A8", whole.A, "the model of all LQGs: the platform in eight balanced states, in the page's signs"),
            GivenValue("B8", coils(whole).B),
            GivenValue("G8", ground(whole)),
            GivenValue("C8", whole.C),
            *(
                GivenValue(f"{name}{key}", value, f"the {word} channel alone: two balanced states" if name == "A" else "")
                for index, (key, word) in enumerate(zip("vth", CHANNEL_NAMES, strict=True))
                for name, value in (
                    *zip("ABC", (channel(index)[0].A, channel(index)[0].B, channel(index)[0].C), strict=True),
                    ("G", channel(index)[1]),
                )
            ),
            GivenValue("scales", np.array(SCALES), "of each channel: its unit of velocity in m/s, and coils that share its force"),
            GivenValue("alpha", w.alpha_q, "the cost: alpha (y / unit)^2 + price u^2"),
            GivenValue("weights", w.alpha_q * np.square(S_Y)),
            GivenValue("price", w.alpha_r),
            GivenValue("v", d["v"], "assumed intensity of each sensor's noise"),
            GivenValue("ground", GROUND_UNIT, "m^2 s, intensity of white ground"),
            GivenValue("A_siso", own.A, "the two SISO loops, y to u"),
            GivenValue("B_siso", own.B),
            GivenValue("C_siso", own.C),
            GivenValue("D_siso", np.asarray(own.D)),
            GivenValue("K_page", -made.C, "the gains of the page, which are computed again below"),
            GivenValue("L_page", made.B),
            GivenValue("Kd_page", sampled.K),
            GivenValue("M_page", sampled.filter.steady.filter_gain),
            *(
                given
                for index, key in enumerate("vth")
                for given in (GivenValue(f"K{key}_page", channel(index)[2]), GivenValue(f"L{key}_page", channel_filter(index, d["v"])))
            ),
            GivenValue("h", DT, "s, the computer's period"),
            GivenValue("sensor", d["sensor"], "true intensity of each sensor's noise"),
            GivenValue("shaped", world.shaped, "the ground falls as 1/f^2: white noise of intensity 1 through this filter"),
            GivenValue("A_ground", filter8.A),
            GivenValue("B_ground", filter8.B),
            GivenValue("C_ground", filter8.C),
            GivenValue("order", 0 if np.isinf(hardware.bandwidth) else hardware.order, "of the coil drivers, 0: ideal"),
            GivenValue("bandwidth", hardware.bandwidth, "Hz"),
            GivenValue("delay", hardware.delay, "s"),
            GivenValue("limit", hardware.limit, "N"),
            GivenValue("walk", hardware.walk, "how far the zero of a sensor walks in a second"),
            GivenValue("step", hardware.step, "of the converter: noise of step^2/12 in the spectra"),
            GivenValue("friction", friction_of(d), "N, the largest friction of each guide; only the run on the stage has it"),
            GivenValue("guide_at", world.parameters.a, "m from the middle: the vertical springs, where guides rub"),
            GivenValue("guide_height", world.parameters.h, "m from the middle up: the centre of mass"),
            GivenValue("coil_at", world.parameters.b, "m: the vertical coils"),
            GivenValue(
                "jump_root",
                loop.jump[loop.x.start : loop.mechanics.stop, : _ways(loop.jump, loop.mechanics)],
                "a root of the covariance that the ground adds over a sample; there are many, this is the page's",
            ),
            GivenValue("frequency", study.f, "Hz"),
            GivenValue("band", BAND_HZ, "Hz, of the suppression"),
            GivenValue("test", d["test"]),
            GivenValue("touch", TOUCH_JUMP, "jump of the states of the platform"),
            GivenValue("ground_step", GROUND_STEP_M, "m"),
            GivenValue("kick_at", kick, "the sample of one more touch, -1: never"),
            GivenValue("play", d["play"], "who is on the stage"),
            GivenValue("seed", int(d["seed"])),
        ),
        tuple(shown),
        NOT_IN_SCRIPT + ("" if held else ", and the run on the stage, whose loop is unstable and magnifies rounding"),
        _normal(loop, int(d["seed"])),
    )


def _normal(loop: SampledLoop, seed: int) -> tuple[GivenValue, ...]:
    """The normal numbers of the run on the stage."""
    ground, sensors, walk = trial_draws(loop, RUN_SAMPLES, seed)
    return (GivenValue("normal_ground", ground), GivenValue("normal_v", sensors),
            GivenValue("normal_walk", walk if walk.shape[1] else np.zeros((0, 4)), "of the walking zeros"))


def _ways(jump: np.ndarray, part: slice) -> int:
    """Ways of the ground's noise; those of a walking zero stand behind them."""
    return int(np.flatnonzero(np.any(jump[part] != 0, axis=0)).max(initial=-1)) + 1
