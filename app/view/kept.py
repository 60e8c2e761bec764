"""What a browser says that it kept, judged: it has been out of our hands."""

from __future__ import annotations

import json


def kept(value: object) -> tuple[str | None, str, bool, str, str | None, str | None]:
    """What a browser answered, whatever it is: what this tab kept, the token in its address bar and whether it has put it there,
    the page's address, what the tab before it kept, and the designs under names."""
    try:
        said = json.loads(value) if isinstance(value, str) else None
    except (ValueError, RecursionError):
        said = None
    match said:
        case [str() | None as kept, str(token), bool(known), str(home), str() | None as earlier, str() | None as shelf]:
            return kept, token, known, home, earlier, shelf
    return None, "", False, "", None, None
