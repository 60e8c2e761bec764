"""Declare the argument checks of the public calls of `engine.feedback`."""

from __future__ import annotations

from ..systems.argument_checks import covariance, either, gated, instance, matrix, number, optional
from ..systems.plant import Plant
from . import loop_spectrum, ltr, margins
from .compensator import ClosedLoop as ClosedLoop  # records through the door where their module has the name of a call
from .compensator import TransferFunction as TransferFunction
from .compensator import closed_loop as _closed_loop
from .compensator import compensator as _compensator
from .compensator import to_tf as _to_tf
from .lqg import Lqg as Lqg
from .lqg import lqg as _lqg
from .sensitivity import Sensitivity as Sensitivity
from .sensitivity import sensitivity as _sensitivity

_PLANT, _MODEL = instance(Plant), optional(instance(Plant))
_CONTROLLER = either(Plant, matrix())
_STRENGTH = number(0, 1e12)

compensator = gated(plant=_PLANT, K=matrix(), L=matrix())(_compensator)
closed_loop = gated(plant=_PLANT, K=matrix(), L=matrix(), model=_MODEL)(_closed_loop)
to_tf = gated(plant=_PLANT)(_to_tf)
noisy_loop = gated(plant=_PLANT, controller=_MODEL, G=matrix("n q"), W=covariance("q"), V=covariance("p"))(loop_spectrum.noisy_loop)
lqg = gated(plant=_PLANT, Q=covariance("n"), R=covariance("m"), W=covariance(), V=covariance("p"), G=matrix())(_lqg)
recover = gated(plant=_PLANT, K=matrix(), W=covariance(), V=covariance("p"), q=_STRENGTH, G=matrix())(ltr.recover)
recover_at_output = gated(plant=_PLANT, L=matrix(), Q=covariance("n"), R=covariance("m"), q=_STRENGTH)(ltr.recover_at_output)
loop_margins = gated(plant=_PLANT, controller=_CONTROLLER)(margins.loop_margins)
state_feedback_margins = gated(plant=_PLANT, K=matrix())(margins.state_feedback_margins)
sensitivity = gated(plant=_PLANT, controller=_CONTROLLER)(_sensitivity)
