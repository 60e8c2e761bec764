"""Describe what a device computes at each sample, once, and run it in Python."""

from .bank import bank_routine
from .design import DeviceDesign, design_of_controller, design_of_filter, design_of_run, watching
from .extended import Equations, extended_routine
from .kalman import kalman_routine
from .language import StepError, check_step
from .linear import HELD_READINGS, linear_routine, sampled_observer
from .observer import observer_routine
from .routine import Device, Routine, Table
from .sampling import DeviceError, SampledDesign, sample_design

__all__ = [
    "HELD_READINGS",
    "Device",
    "DeviceDesign",
    "DeviceError",
    "Equations",
    "Routine",
    "SampledDesign",
    "StepError",
    "Table",
    "bank_routine",
    "check_step",
    "design_of_controller",
    "design_of_filter",
    "design_of_run",
    "extended_routine",
    "kalman_routine",
    "linear_routine",
    "observer_routine",
    "sample_design",
    "sampled_observer",
    "watching",
]
