"""Provide the command line `observer-lab`."""

from .entry import main

__all__ = ["main"]
