"""Describe the solid parts of each plant for the 3-D stage."""
