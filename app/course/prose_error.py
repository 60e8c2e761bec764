"""Define the error of a text file that does not have the agreed form."""

from __future__ import annotations


class ProseError(ValueError):
    """A lesson's text file, or the glossary, that does not have the agreed form."""
