"""Hold the modules of lesson 8, sensor noise and observer speed."""
