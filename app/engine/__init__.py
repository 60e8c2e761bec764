"""Compute observers and estimate feedback: arrays in, frozen records out.

The names that people need are here, those that python-control shares too; the others are public in their room, as in
`from observer_lab.engine.filters import Track`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .aliases import (
        acker,
        c2d,
        care,
        ctrb,
        d2c,
        dare,
        dlyap,
        estim,
        gram,
        hsvd,
        kalman,
        lyap,
        obsv,
        poles,
        ss,
        tf,
        zeros,
    )
    from .design import dlqe, dlqr, lqe, lqr, observer_gain, place
    from .feedback import (
        closed_loop,
        compensator,
        integral_action,
        loop_margins,
        lqg,
        noisy_loop,
        recover,
        reference_gain,
        sensitivity,
    )
    from .filters import (
        Belief,
        ExtendedKalmanFilter,
        KalmanFilter,
        MultipleModelFilter,
        ParticleFilter,
        SquareRootFilter,
        UnscentedKalmanFilter,
        angles,
        chi2_band,
        correct,
        error_parts,
        h_infinity,
        innovation_test,
        moving_horizon,
        nees,
        nis,
        predict,
        smooth,
    )
    from .identification import identify
    from .network import Link, NetworkScenario, critical_loss, simulate_network
    from .observers import (
        BilinearPlant,
        bilinear_functional_observer,
        functional_observer,
        reduced_observer,
        residual_generator,
        rlo,
        simulate_bilinear,
        simulate_functional,
        unknown_input_observer,
    )
    from .plant_files import from_control, from_json, from_mat, from_scipy, load_plant, to_control, to_json, to_mat
    from .sampled import sampled_loop, sampled_lqg, simulate_trial
    from .simulation import Scenario, autonomous_error, simulate
    from .structure import balanced_truncation, controllability, gramians, hankel_singular_values, kalman_decomposition, observability
    from .systems import EngineError, NonlinearPlant, Plant, PoleError, RiccatiError, ShapeError, frequency_response, psd

__all__ = [
    "Belief",
    "BilinearPlant",
    "EngineError",
    "ExtendedKalmanFilter",
    "KalmanFilter",
    "Link",
    "MultipleModelFilter",
    "NetworkScenario",
    "NonlinearPlant",
    "ParticleFilter",
    "Plant",
    "PoleError",
    "RiccatiError",
    "Scenario",
    "ShapeError",
    "SquareRootFilter",
    "UnscentedKalmanFilter",
    "acker",
    "angles",
    "autonomous_error",
    "balanced_truncation",
    "bilinear_functional_observer",
    "c2d",
    "care",
    "chi2_band",
    "closed_loop",
    "compensator",
    "controllability",
    "correct",
    "critical_loss",
    "ctrb",
    "d2c",
    "dare",
    "dlqe",
    "dlqr",
    "dlyap",
    "error_parts",
    "estim",
    "frequency_response",
    "from_control",
    "from_json",
    "from_mat",
    "from_scipy",
    "functional_observer",
    "gram",
    "gramians",
    "h_infinity",
    "hankel_singular_values",
    "hsvd",
    "identify",
    "innovation_test",
    "integral_action",
    "kalman",
    "kalman_decomposition",
    "load_plant",
    "loop_margins",
    "lqe",
    "lqg",
    "lqr",
    "lyap",
    "moving_horizon",
    "nees",
    "nis",
    "noisy_loop",
    "observability",
    "observer_gain",
    "obsv",
    "place",
    "poles",
    "predict",
    "psd",
    "recover",
    "reduced_observer",
    "reference_gain",
    "residual_generator",
    "rlo",
    "sampled_loop",
    "sampled_lqg",
    "sensitivity",
    "simulate",
    "simulate_bilinear",
    "simulate_functional",
    "simulate_network",
    "simulate_trial",
    "smooth",
    "ss",
    "tf",
    "to_control",
    "to_json",
    "to_mat",
    "unknown_input_observer",
    "zeros",
]

_ROOMS = ("systems", "structure", "plant_files", "design", "simulation", "feedback", "filters", "network", "observers", "sampled",
          "identification", "aliases")


def __getattr__(name: str) -> Any:
    """A name is looked for when it is first used, room by room from the lowest: `import observer_lab.engine` alone loads none."""
    if name in (*_ROOMS, "kernels", "plotting"):
        return import_module(f"{__name__}.{name}")
    if name in __all__:
        for room in map(import_module, (f"{__name__}.{room}" for room in _ROOMS)):
            if name in room.__all__:
                return globals().setdefault(name, getattr(room, name))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_ROOMS})
