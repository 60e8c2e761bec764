"""Filters and loops over packets that can be lost or late."""
