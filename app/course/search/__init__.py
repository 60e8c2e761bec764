"""Find lessons, scenes, terms and functions by the words that people type."""
