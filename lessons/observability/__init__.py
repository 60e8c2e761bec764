"""Hold the modules of lesson 3, observability."""
