"""Show a lesson in a notebook: `from observer_lab.notebook import Lab; Lab("kalman")`."""

from .widget import Lab

__all__ = ["Lab"]
