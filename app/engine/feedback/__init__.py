"""Analyse the closed loop: compensators, sensitivity, margins, spectra, LQG, LTR."""

from ..systems.gates.room_gates import with_gates
from .compensator import ClosedLoop, TransferFunction, closed_loop, compensator, to_tf
from .loop_spectrum import NoisyLoop, noisy_loop
from .lqg import Lqg, Recovered, lqg, recover, recover_at_output
from .margins import ChannelMargins, DiskMargin, LoopMargins, MultiMargins, loop_margins, state_feedback_margins
from .reference import IntegralAction, integral_action, reference_gain
from .sensitivity import Sensitivity, sensitivity

__all__ = [
    "ChannelMargins",
    "ClosedLoop",
    "DiskMargin",
    "IntegralAction",
    "LoopMargins",
    "Lqg",
    "MultiMargins",
    "NoisyLoop",
    "Recovered",
    "Sensitivity",
    "TransferFunction",
    "closed_loop",
    "compensator",
    "integral_action",
    "loop_margins",
    "lqg",
    "noisy_loop",
    "recover",
    "recover_at_output",
    "reference_gain",
    "sensitivity",
    "state_feedback_margins",
    "to_tf",
]

with_gates(globals())
