"""Hold the modules of lesson 12, weakly observable states and model reduction."""
