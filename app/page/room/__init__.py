"""Show a lecture to a room: one page packed once for all followers, votes and counts."""
