"""Serve Observer Lab, an interactive course on state observers and estimate feedback."""
