"""Answer to the field's common names as python-control or MATLAB does: ss, tf, care, gram, kalman, …"""

from ..systems.gates.room_gates import with_gates
from .field_names import acker, care, ctrb, dare, dlyap, gram, hsvd, lyap, obsv, poles, zeros
from .plants import c2d, d2c, estim, kalman, ss, tf

__all__ = [
    "acker",
    "c2d",
    "care",
    "ctrb",
    "d2c",
    "dare",
    "dlyap",
    "estim",
    "gram",
    "hsvd",
    "kalman",
    "lyap",
    "obsv",
    "poles",
    "ss",
    "tf",
    "zeros",
]

with_gates(globals())
