"""All witnesses of verdict words, those of single lessons before those of every lesson."""

from __future__ import annotations

from verdict_kalman import WITNESSES as KALMAN
from verdict_law import Witness
from verdict_linear import WITNESSES as LINEAR
from verdict_noise import WITNESSES as NOISE
from verdict_nonlinear import WITNESSES as NONLINEAR
from verdict_rest import WITNESSES as REST
from verdict_runs import SOME
from verdict_runs import WITNESSES as RUNS
from verdict_saturation import WITNESSES as SATURATION

WITNESSES: tuple[Witness, ...] = (*KALMAN, *NONLINEAR, *REST, *SATURATION, *SOME, *RUNS, *LINEAR, *NOISE)
