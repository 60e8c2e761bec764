"""Check what a browser says that it has stored for this tab."""

from __future__ import annotations

from ...text import read_outside_json

Window = tuple[object, object, object]


def check_browser_memory(value: object) -> tuple[str | None, str, bool, str, str | None, str | None, Window | None]:
    """What a browser answered, whatever it is: what this tab kept, the token in its address bar and whether it has put it there,
    the page's address, what the tab before it kept, the designs under names, and its window, whose numbers nobody has judged."""
    try:
        said = read_outside_json(value) if isinstance(value, str) else None
    except ValueError:
        said = None
    match said:
        case [str() | None as kept, str(token), bool(known), str(home), str() | None as earlier, str() | None as shelf, *window]:
            match window:
                case [[across, up, night]]:
                    return kept, token, known, home, earlier, shelf, (across, up, night)
            return kept, token, known, home, earlier, shelf, None
    return None, "", False, "", None, None, None
