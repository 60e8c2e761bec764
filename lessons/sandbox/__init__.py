"""Hold the modules of lesson 19, analyses of the user's own plant."""
