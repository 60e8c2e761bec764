"""Draw the page: the only package that uses viser."""
