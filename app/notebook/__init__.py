"""Show a lesson in a notebook, `Lab("kalman")`, or write its observer as code by `write_device`."""

from .device_code import write_device
from .widget import Lab

__all__ = ["Lab", "write_device"]
