"""Hold the modules of lesson 6, unobservable and uncontrollable modes."""
