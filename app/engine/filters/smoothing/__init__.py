"""Estimates from a whole record: the smoother, and the moving horizon with constraints."""
