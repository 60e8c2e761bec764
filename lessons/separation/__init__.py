"""Hold the modules of lesson 4, separation principle."""
