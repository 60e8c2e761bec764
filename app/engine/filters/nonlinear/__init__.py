"""Define what nonlinear filters share: one step, a lost sample, a record, many runs."""
