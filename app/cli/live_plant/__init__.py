"""Run a design beside a plant whose lines come in."""
