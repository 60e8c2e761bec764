"""Hold the modules of lesson 5, duality of control and observation."""
