"""Kalman filters, linear and not, one or many at once, and whether they are consistent."""
