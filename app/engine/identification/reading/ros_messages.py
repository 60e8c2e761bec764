"""Decode messages of ROS 2 in an MCAP file with mcap-ros2-support, of the extra `records`."""

from __future__ import annotations

from typing import Any

__all__ = ["ros_decoder"]


def ros_decoder(encoding: str, schema: Any) -> Any:
    """A function from bytes to a message, None where there is none for this encoding."""
    try:
        from mcap_ros2.decoder import DecoderFactory
    except ImportError:
        return None
    return DecoderFactory().decoder_for(encoding, schema)
