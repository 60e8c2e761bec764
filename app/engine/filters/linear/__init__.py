"""Filters of linear plants: Kalman, in its forms, with coloured noise, and what a gain costs."""
