"""Run a lesson at many designs, seeds or plants, with the same bits on every executor."""
