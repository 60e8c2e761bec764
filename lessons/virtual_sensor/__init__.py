"""Hold the modules of lesson 1, virtual sensor."""
