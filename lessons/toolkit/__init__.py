"""Share code among lessons: knobs, gains, boards, figures, formulas, fair tasks."""
