"""Hold the modules of lesson 11, decoupled control of the platform."""
