"""Decide who may connect, and hand connections to the processes that serve them."""
