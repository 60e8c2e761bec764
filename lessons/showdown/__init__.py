"""Hold the modules of lesson 13, comparison of five controllers."""
