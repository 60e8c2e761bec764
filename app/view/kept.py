"""What a browser says that it kept, judged: it has been out of our hands."""

from __future__ import annotations

import json


def kept(value: object) -> tuple[str | None, str, bool, str]:
    """What a browser answered, whatever it is."""
    try:
        said = json.loads(value) if isinstance(value, str) else None
    except (ValueError, RecursionError):
        said = None
    match said:
        case [str() | None as kept, str(token), bool(known), str(home)]:
            return kept, token, known, home
    return None, "", False, ""
