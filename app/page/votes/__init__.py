"""Show votes: what a presenter sees of the class, histograms, and planes with poles."""
