"""The loop closed: compensators, sensitivity, margins, spectra, LQG and its recovery."""
