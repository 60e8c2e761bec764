"""Carry out what a person asks of a tab."""
