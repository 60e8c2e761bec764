"""Describe predictions, derivations, exams and typed answers."""
