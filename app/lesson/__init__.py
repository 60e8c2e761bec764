"""Lessons as records: the lesson, its knobs, its figures, its prose."""
