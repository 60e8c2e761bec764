"""Assertions in the helpers of tests explain themselves as those in the tests do."""

from __future__ import annotations

import pytest

pytest.register_assert_rewrite("lesson_checks", "pole_requests")
