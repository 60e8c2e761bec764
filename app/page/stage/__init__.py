"""Draw the 3-D stage: plant, ghost, pole boards and what a hand can drag."""
