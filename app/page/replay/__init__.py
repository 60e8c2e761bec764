"""Play a run in the page, and record it as a page of its own."""
