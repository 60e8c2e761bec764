"""Gains: pole placement, Riccati equations, LQR and LQE, Diophantine equations, scalar controllers."""
