"""Model the three-degree-of-freedom vibration-isolation platform."""
