"""Hold the modules of lesson 18, estimation and control over a lossy network."""
