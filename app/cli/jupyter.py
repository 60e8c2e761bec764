"""Tell jupyter-server-proxy how to launch the app for each student of a JupyterHub.

The hub asks who comes; jupyter-server-proxy takes the path `/user/NAME/observer-lab` away, so that the page stands at its root.
Others on the same machine can reach the port too: therefore each server has an access token of its own, which the proxy puts
into every request as a header and which nobody else sees.
"""

from __future__ import annotations

import sys

from ..page.access.tokens import VARIABLE, draw_token
from ..page.web import path_of

ICON = path_of("icon.svg")
START_TIMEOUT_S = 60.0  # s in which the page must answer, on a machine where a whole course starts at once


def launched_by_jupyter() -> dict[str, object]:
    """What jupyter-server-proxy 4 wants to know of a server; `{port}` is filled in there.

    Source: jupyter-server-proxy, "Server process options".
    """
    word = draw_token()
    return {
        "command": [sys.executable, "-P", "-m", "observer_lab", "serve", "--port", "{port}", "--exact-port"],  # -P: not the student's files
        "environment": {VARIABLE: word},
        "request_headers_override": {"Authorization": f"Bearer {word}"},
        "timeout": START_TIMEOUT_S,
        "launcher_entry": {"title": "Observer Lab", "icon_path": str(ICON), "category": "Other"},
    }
