"""What the pure parts of the house say in English, told in Chinese.

The engine knows one language. Each table beside this file maps its sentences, `{}` standing for a value, to Chinese
ones, where `{}` or `{1}` takes the same values up again. A value that is itself a known sentence or phrase is
translated too; numbers, names and symbols carry over. A test walks the source and finds every sentence that is missing
here, and every one that nobody says any more.
"""

from .match import TABLES, chinese, recognise, told
from .unexpected import kind_of

__all__ = ["TABLES", "chinese", "kind_of", "recognise", "told"]
