"""Hold the modules of lesson 20, geared arm with an unknown load torque."""
