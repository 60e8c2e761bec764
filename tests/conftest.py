"""What holds for all tests: helpers' assertions explain themselves, and what takes its time is marked slow."""

from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).parent
SLOW = frozenset({"e2e", "wire"})  # folders in which a server or a browser is started; elsewhere a test says so itself

pytest.register_assert_rewrite("lesson_checks", "pole_requests", "laws")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.relative_to(HERE).parts[0] in SLOW:
            item.add_marker(pytest.mark.slow)
