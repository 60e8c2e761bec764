"""Check what a browser says that it has stored for this tab."""

from __future__ import annotations

from ...text import read_outside_json

Window = tuple[object, object, object]


def check_browser_memory(value: object) -> tuple[str | None, str, bool, str, str | None, str | None, Window | None, str | None]:
    """What a browser answered, whatever it is: what this tab kept, the token in its address bar and whether it has put it there,
    the page's address, what the tab before it kept, the designs under names, its window, whose numbers nobody has judged, and its
    own .zip of lessons."""
    try:
        said = read_outside_json(value) if isinstance(value, str) else None
    except ValueError:
        said = None
    match said:
        case [str() | None as kept, str(token), bool(known), str(home), str() | None as earlier, str() | None as shelf, *rest]:
            match rest:
                case [[across, up, night], *others]:
                    lessons = others[0] if others and isinstance(others[0], str) else None
                    return kept, token, known, home, earlier, shelf, (across, up, night), lessons
            return kept, token, known, home, earlier, shelf, None, None
    return None, "", False, "", None, None, None, None
