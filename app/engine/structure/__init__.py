"""What a plant is made of: observability, controllability, decomposition, Gramians, dominance."""
