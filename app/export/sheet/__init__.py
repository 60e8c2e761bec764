"""Set a lesson as a printed sheet."""
