"""Hold the modules of lesson 16, functional observer of a bilinear plant."""
