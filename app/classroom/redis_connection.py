"""Connect to the Redis server that keeps a room or a course for several machines."""

from __future__ import annotations

import hashlib
import socket
from typing import Any

PREFIX = "observer-lab:"  # of every key; the number of the database in the address tells rooms apart
WAIT_S = 10.0  # s for a connection or an answer
RETRIES = 5
LEAST_VERSION = (6, 2)  # of the server


class RoomProblem(Exception):
    """A store cannot be opened: one sentence why, without the address, which may hold a password."""


def connect(address: str, option: str = "--room-store") -> Any:
    """A client that several threads may share, for the server that an option names. Raises RoomProblem."""
    try:
        import redis
        from redis.backoff import ExponentialBackoff
        from redis.retry import Retry
    except ImportError as problem:
        raise RoomProblem('Redis needs the package redis; run pip install "observer-lab[redis]".') from problem
    try:
        client = redis.Redis.from_url(
            address, socket_timeout=WAIT_S, socket_connect_timeout=WAIT_S, health_check_interval=30,
            retry=Retry(ExponentialBackoff(cap=1.0, base=0.05), RETRIES),
            retry_on_error=[redis.ConnectionError, redis.TimeoutError])
        version = tuple(int(part) for part in str(client.info("server")["redis_version"]).split(".")[:2])
    except (redis.RedisError, ValueError, OSError) as problem:
        raise RoomProblem(f"The Redis server of {option} cannot be used ({type(problem).__name__}); check that it runs, its address "
                          "and its password.") from None
    if version < LEAST_VERSION:
        raise RoomProblem(f"The Redis server of {option} is too old; it must be version 6.2 or later.")
    return client


def key(*parts: object) -> str:
    """A key of ours."""
    return PREFIX + ":".join(map(str, parts))


def machine_name() -> str:
    """What tells this machine's workers from those of others, without its name."""
    return hashlib.sha256(socket.gethostname().encode()).hexdigest()[:12]
