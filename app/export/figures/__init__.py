"""Draw figure records with matplotlib."""
