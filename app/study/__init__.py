"""Big studies: one lesson at many designs, seeds or plants, through whatever runs them, the same bit for bit."""
