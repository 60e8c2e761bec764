"""Hold the modules of lesson 14, extended and unscented Kalman filters."""
