"""Test the innovations of a filter: mean, whiteness and size against its covariances."""
