"""Hold the modules of lesson 17, fault detection and isolation."""
