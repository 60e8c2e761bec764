"""Describe figures and the stage as records."""
