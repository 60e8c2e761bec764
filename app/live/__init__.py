"""Read the lines of a running plant, estimate beside it, and simulate one."""
