"""Keep what a lecture room knows: its page, its votes and how many are here; nothing of any person."""
