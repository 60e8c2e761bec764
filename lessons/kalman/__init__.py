"""Hold the modules of lesson 9, Kalman filter and consistency."""
