"""Analyse the closed loop: compensators, sensitivity, margins, spectra, LQG, LTR."""

from .door import (
    ClosedLoop,
    Lqg,
    Sensitivity,
    TransferFunction,
    closed_loop,
    compensator,
    loop_margins,
    lqg,
    noisy_loop,
    recover,
    recover_at_output,
    sensitivity,
    state_feedback_margins,
    to_tf,
)
from .loop_spectrum import NoisyLoop
from .ltr import Recovered
from .margins import ChannelMargins, DiskMargin, LoopMargins, MultiMargins

__all__ = [
    "ChannelMargins",
    "ClosedLoop",
    "DiskMargin",
    "LoopMargins",
    "Lqg",
    "MultiMargins",
    "NoisyLoop",
    "Recovered",
    "Sensitivity",
    "TransferFunction",
    "closed_loop",
    "compensator",
    "loop_margins",
    "lqg",
    "noisy_loop",
    "recover",
    "recover_at_output",
    "sensitivity",
    "state_feedback_margins",
    "to_tf",
]
