"""What a public call takes: checks of each argument, put in front of what a room gives away."""
