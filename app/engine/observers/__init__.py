"""Observers beyond Luenberger's: functional, robust, bilinear, with unknown inputs, banks for faults."""
