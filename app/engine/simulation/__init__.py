"""Runs of a loop: scenarios, disturbances, saturation, batches and maps of recovery."""
