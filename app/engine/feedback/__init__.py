"""The loop closed: compensators, sensitivity, margins, spectra, LQG and its recovery."""

from .compensator import ClosedLoop, TransferFunction
from .door import (
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
from .lqg import Lqg
from .ltr import Recovered
from .margins import ChannelMargins, DiskMargin, LoopMargins, MultiMargins
from .sensitivity import Sensitivity

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
