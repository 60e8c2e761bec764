"""LEGACY names of app.text, until every module imports from there."""

from . import NO_WORDS, Text, joined, languages, listed, same, squared, symbol, text, text_in, told, wording

LANGUAGES = languages()
__all__ = ["LANGUAGES", "NO_WORDS", "Text", "joined", "listed", "same", "squared", "symbol", "text", "text_in", "told", "wording"]
