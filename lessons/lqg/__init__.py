"""Hold the modules of lesson 10, LQG control."""
