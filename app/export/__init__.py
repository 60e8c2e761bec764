"""Figures, data and code that leave the lab: the only package that imports matplotlib."""
