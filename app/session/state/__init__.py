"""Hold, validate, encode and restore the state of a tab."""
