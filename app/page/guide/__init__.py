"""Show a lesson scene by scene: one card, at most three knobs, at most two figures."""
