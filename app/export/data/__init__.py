"""Write the curves and numbers of a design as tables."""
