"""Define lessons as records: the lesson, its knobs, its figures, its text."""
