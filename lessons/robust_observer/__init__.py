"""Hold the modules of lesson 15, robust Luenberger observer."""
