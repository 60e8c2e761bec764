"""Loops with sampled controllers and real hardware, one run or many."""
