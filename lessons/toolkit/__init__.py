"""What many lessons share: knobs, gains, boards, figures, formulas and fair tasks, each in its module."""
