"""What holds for all tests: helpers' assertions explain themselves, and what takes its time is marked slow."""

from __future__ import annotations

import asyncio
import gc
import logging
import os
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from dealing import dealt
from hypothesis import HealthCheck, Phase, settings
from sampling import WHOLE, left_out, whole

if TYPE_CHECKING:
    from redis_server import RedisServer

HERE = Path(__file__).parent
SLOW = frozenset({"e2e", "wire"})  # folders in which a server or a browser is started; elsewhere a test says so itself

os.environ["OBSERVER_LAB_KERNELS"] = "off"  # no server of a test compiles anything; tests/engine/kernels does
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):  # tests start some forty servers and commands: compiled once, not each time
    sys.dont_write_bytecode = False

LONGEST = 200  # letters of a test's name

# an example that fails is told as it is: to explain it, every line of every example would be traced, at twice the time. None fails
# because it took long: what is slow here is the machine
settings.register_profile("whole", deadline=None, suppress_health_check=[HealthCheck.too_slow],
                          phases=[phase for phase in Phase if phase is not Phase.explain])
settings.register_profile("here", settings.get_profile("whole"), max_examples=30)  # of a law that does not say itself how many
settings.load_profile("here")

pytest.register_assert_rewrite("all_replays", "lesson_checks", "pole_requests", "laws")


def folder_of(item: pytest.Item) -> str:
    """The room of the tests in which a test stands; its file where that is in none."""
    return item.path.relative_to(HERE).parts[0]


def law_of(item: pytest.Item) -> str:
    """The test of which an item is a case: its file within the tests, and its name."""
    return f"{item.path.relative_to(HERE).as_posix()}::{item.name.partition('[')[0]}"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--whole", action="store_true", help="run what the suite samples on all lessons")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not config.getoption("--whole"):
        kept = [item for item in items if not item.get_closest_marker("whole")]
        out = set() if whole() else left_out(kept, law_of)
        kept = [item for k, item in enumerate(kept) if k not in out]
        config.hook.pytest_deselected(items=[*{*items} - {*kept}])
        items[:] = kept
    strange = sorted({item.nodeid.split("[")[0] for item in items if len(item.name) > LONGEST or " at 0x" in item.name})
    if strange:
        raise pytest.UsageError(f"a test's name must be short and the same in every worker; these want ids=: {', '.join(strange)}")
    items[:] = dealt(items, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")), lambda item: (folder_of(item), item.path.name))
    for item in items:
        if folder_of(item) in SLOW:
            item.add_marker(pytest.mark.slow)


@pytest.fixture(autouse=True)
def no_loop_of_a_browser(request: pytest.FixtureRequest) -> Iterator[None]:
    """Outside tests/e2e nothing runs in the event loop that Playwright keeps in this thread for the browser of the session."""
    loop = None if folder_of(request.node) == "e2e" else asyncio._get_running_loop()
    if loop is None:
        yield
        return
    asyncio._set_running_loop(None)
    yield
    asyncio._set_running_loop(loop)


@pytest.fixture(scope="session")
def redis_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RedisServer]:
    """A Redis server of this worker."""
    from redis_server import redis_serving

    with redis_serving(tmp_path_factory.mktemp("redis")) as server:
        yield server


@pytest.fixture(params=["folder", "redis"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Path | str:
    """Where a lecture room is kept that nobody has opened yet: a folder, or a Redis server."""
    if request.param == "folder":
        return tmp_path
    server: RedisServer = request.getfixturevalue("redis_server")
    server.empty()
    return server.address


@pytest.fixture(autouse=True)
def own_outcomes(request: pytest.FixtureRequest) -> Iterator[None]:
    """A test that puts something else in place of a part of the lab shares no outcome with others."""
    if "monkeypatch" not in request.fixturenames:
        yield
        return
    from shared_outcomes import forget

    forget()
    yield
    forget()


def pytest_collection_finish() -> None:
    from shared_outcomes import share

    share()
    gc.freeze()  # thousands of tests and all they import stay to the end: nobody needs to look whether they are garbage


def pytest_configure(config: pytest.Config) -> None:
    named = config.getoption("keyword") or any("::" in word for word in config.args)
    if named or config.getoption("--whole"):  # who names tests gets all of their cases
        os.environ[WHOLE] = "1"
    if config.getoption("--whole"):
        settings.load_profile("whole")
    config.pluginmanager.register(NoWarnings(), "no warnings")
    logging.getLogger("asyncio").addHandler(Unheard(logging.ERROR))


class Unheard(logging.Handler):
    """What fails on a server's loop fails nobody's test: it is logged when the task is forgotten. Here it becomes a warning."""

    def emit(self, record: logging.LogRecord) -> None:
        warnings.warn(f"on a server's loop: {record.getMessage()}", stacklevel=1)


class NoWarnings:
    """A run that left a warning has not passed: one of another thread or of another worker cannot fail its own test."""

    def __init__(self) -> None:
        self.heard: list[str] = []

    def pytest_warning_recorded(self, warning_message: warnings.WarningMessage, when: str) -> None:
        if when != "config":  # what plugins of this machine say of each other
            self.heard.append(str(warning_message.message))

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self.heard and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self.heard:
            terminalreporter.write_line(f"{len(self.heard)} warnings: a run with a warning has not passed", red=True)
