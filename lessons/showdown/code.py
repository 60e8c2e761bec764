"""Five controllers in one world as code: the platform, what each controller is made of, the hardware, and what the page shows."""

from __future__ import annotations

import numpy as np

from app.engine.sampled import SampledLoop, trial_draws
from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome
from app.plants.platform_channels import T_u, T_y
from app.plants.platform_lqg import GROUND_UNIT, S_Y, Weights, coils, ground

from .friction import friction_of
from .players import DT, OPEN, ORDER, SCALES, channel, channel_filter, full, reduced, sampled_design, siso_pair
from .study import Study
from .world import BAND, PUSH, RUN, STEP, ground_filter, loop_of, plant_of

UNSAID = "The long computation, and the way of the recursive gain to its settled value"
WILD = 1e6  # growth over the run beyond which it magnifies rounding too far to be found again
CHANNELS = ("vertical", "rotation", "horizontal")


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    world, w = study.world, Weights()
    plant, outputs = plant_of(world.parameters)
    whole, own, sampled, filter8 = reduced(), siso_pair(d["pair"]), sampled_design(d["v"]), ground_filter()
    hardware, made = world.hardware, full(d["v"])
    loop = loop_of(world, study.five[0])
    shown = [Shown(f"stable['{name}']", m[f"{name}_stable"], 1.0) for name in ORDER]
    for i, name in enumerate(ORDER):
        if not study.spectra[i].stable:
            continue
        density, response = study.spectra[i].density, study.responses[i]
        shown += [Shown(f"velocity_density['{name}']", density[:, :5]), Shown(f"force_density['{name}']", density[:, 5:]),
                  Shown(f"rms['{name}']", [m[f"{name}_{one}_rms"] for one in CHANNELS]),
                  Shown(f"band_db['{name}']", [m[f"{name}_{one}_band_db"] for one in CHANNELS], 1.0),
                  Shown(f"peak_db['{name}']", [m[f"{name}_{one}_peak_db"] for one in CHANNELS], 1.0),
                  Shown(f"worst_db['{name}']", m[f"{name}_worst_db"], 1.0), Shown(f"forces['{name}']", study.forces[i]),
                  Shown(f"peak_force['{name}']", m[f"{name}_peak_force"]), Shown(f"energy['{name}']", m[f"{name}_energy"])]
        if response is not None:
            shown.append(Shown(f"velocity['{name}']", response.velocity))
    if "filters_apart_db" in m:
        shown.append(Shown("filters_apart_db", m["filters_apart_db"], 1.0))
    chosen = loop_of(world, study.five[ORDER.index(d["play"])])
    held = RUN * np.log(chosen.radius) < np.log(WILD)
    if held:
        shown += [Shown("x", study.run[1]), Shown("u", study.run[2])]
    if held or d["play"] != OPEN:
        shown.append(Shown("ghost", study.ghost))
    kick = min(round(d["kick"] / DT), RUN - 1) if d["kick"] >= 0 else -1
    return Code(("showdown",), (
        Given("A", plant.A, "the platform as it is: dx/dt = A x + B u + G (ground), y = C x + v"), Given("B", coils(plant).B),
        Given("G", ground(plant)), Given("C", plant.C),
        Given("read", outputs, "what is looked at: vertical, rotation, horizontal, left and right vertical velocity"),
        Given("T_y", T_y[:3], "readings to vertical, rotation, horizontal"), Given("T_u", T_u, "common, differential, horizontal to coils"),
        Given("A8", whole.A, "the platform as all LQGs believe it: eight balanced states, in the page's signs"),
        Given("B8", coils(whole).B), Given("G8", ground(whole)), Given("C8", whole.C),
        *(Given(f"{name}{key}", value, f"the {word} channel alone: two balanced states" if name == "A" else "")
          for index, (key, word) in enumerate(zip("vth", CHANNELS, strict=True))
          for name, value in (*zip("ABC", (channel(index)[0].A, channel(index)[0].B, channel(index)[0].C), strict=True),
                              ("G", channel(index)[1]))),
        Given("scales", np.array(SCALES), "of each channel: its unit of velocity in m/s, and coils that share its force"),
        Given("alpha", w.alpha_q, "the cost: alpha (y / unit)^2 + price u^2"), Given("weights", w.alpha_q * np.square(S_Y)),
        Given("price", w.alpha_r), Given("v", d["v"], "believed intensity of each sensor's noise"),
        Given("ground", GROUND_UNIT, "m^2 s, intensity of white ground"),
        Given("A_siso", own.A, "the two SISO loops, y to u"), Given("B_siso", own.B), Given("C_siso", own.C),
        Given("D_siso", np.asarray(own.D)),
        Given("K_page", -made.C, "the gains of the page, which are computed again below"), Given("L_page", made.B),
        Given("Kd_page", sampled.K), Given("M_page", sampled.filter.steady.filter_gain),
        *(given for index, key in enumerate("vth") for given in (
            Given(f"K{key}_page", channel(index)[2]), Given(f"L{key}_page", channel_filter(index, d["v"])))),
        Given("h", DT, "s, the computer's period"), Given("sensor", d["sensor"], "true intensity of each sensor's noise"),
        Given("shaped", world.shaped, "the ground falls as 1/f^2: white noise of intensity 1 through this filter"),
        Given("A_ground", filter8.A), Given("B_ground", filter8.B), Given("C_ground", filter8.C),
        Given("order", 0 if np.isinf(hardware.bandwidth) else hardware.order, "of the coil drivers, 0: ideal"),
        Given("bandwidth", hardware.bandwidth, "Hz"), Given("delay", hardware.delay, "s"), Given("limit", hardware.limit, "N"),
        Given("walk", hardware.walk, "how far the zero of a sensor walks in a second"),
        Given("step", hardware.step, "of the converter: noise of step^2/12 in the spectra"),
        Given("friction", friction_of(d), "N, the most that each guide holds; the run on the stage alone knows it"),
        Given("guide_at", world.parameters.a, "m from the middle: the vertical springs, where guides rub"),
        Given("guide_height", world.parameters.h, "m from the middle up: the centre of mass"),
        Given("coil_at", world.parameters.b, "m: the vertical coils"),
        Given("jump_root", loop.jump[loop.x.start:loop.mechanics.stop, :_ways(loop.jump, loop.mechanics)],
              "a root of the covariance that the ground adds over a sample, of which there are many: the page's"),
        Given("frequency", study.f, "Hz"), Given("band", BAND, "Hz, of the suppression"), Given("test", d["test"]),
        Given("touch", PUSH, "jump of the states of the platform"), Given("ground_step", STEP, "m"),
        Given("kick_at", kick, "the sample of one more touch, -1: never"), Given("play", d["play"], "who is on the stage"),
        Given("seed", int(d["seed"])),
    ), tuple(shown), UNSAID + ("" if held else ", and the run on the stage, whose loop is unstable and magnifies rounding"),
                _normal(loop, int(d["seed"])))


def _normal(loop: SampledLoop, seed: int) -> tuple[Given, ...]:
    """The normal numbers of the run on the stage."""
    ground, sensors, walk = trial_draws(loop, RUN, seed)
    return (Given("normal_ground", ground), Given("normal_v", sensors),
            Given("normal_walk", walk if walk.shape[1] else np.zeros((0, 4)), "of the walking zeros"))


def _ways(jump: np.ndarray, part: slice) -> int:
    """Ways of the ground's noise; those of a walking zero stand behind them."""
    return int(np.flatnonzero(np.any(jump[part] != 0, axis=0)).max(initial=-1)) + 1
