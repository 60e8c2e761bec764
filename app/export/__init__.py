"""Export figures, data and code: the only package that imports matplotlib."""
