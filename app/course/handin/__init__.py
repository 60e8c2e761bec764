"""Describe a course: its file, the keys that draw each student's numbers, signed hand-ins and grades."""
