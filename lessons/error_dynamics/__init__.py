"""Hold the modules of lesson 2, dynamics of the estimation error."""
