"""Tell the installed version of Observer Lab."""

from __future__ import annotations

from functools import lru_cache
from importlib import metadata


@lru_cache(maxsize=1)
def version() -> str:
    """The version that is installed, "source" where none is."""
    try:
        return metadata.version("observer-lab")
    except metadata.PackageNotFoundError:
        return "source"
