"""Hold the modules of lesson 7, input saturation and windup."""
