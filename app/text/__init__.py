"""Words: sentences in every language of the lab."""
