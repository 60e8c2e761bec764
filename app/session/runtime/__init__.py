"""Queue, schedule and watch the work of the tabs."""
