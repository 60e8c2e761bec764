"""Lesson 21: from a record to an observer."""
