"""Zenoh peers with the settings of rmw_zenoh: they find each other by the gossip of their router only."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import zenoh


@contextmanager
def peer(router: str, silent_to: str | None = None) -> Iterator[zenoh.Session]:
    """Yield a session with the settings of a ROS 2 node.

    Args:
        router: Endpoint of its router.
        silent_to: Session that receives no tokens of the peer, like a router to which peers of Zenoh 1.8 return.
    """
    settings: dict[str, Any] = {
        "mode": "peer",
        "connect": {"endpoints": [router], "timeout_ms": -1, "exit_on_failure": False},
        "listen": {"endpoints": ["tcp/127.0.0.1:0"]},
        "scouting": {
            "multicast": {"enabled": False},
            "gossip": {
                "enabled": True,
                "multihop": False,
                "target": {"router": ["router", "peer"], "peer": ["router"]},
                "autoconnect": {"router": [], "peer": ["router", "peer"]},
                "autoconnect_strategy": {"peer": {"to_router": "always", "to_peer": "greater-zid"}},
            },
        },
        "adminspace": {"enabled": True},
    }
    if silent_to is not None:
        settings["access_control"] = _withholding(silent_to)
    session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    try:
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]


def _withholding(session: str) -> dict[str, Any]:
    """Return access control that withholds tokens from one session."""
    rule = {
        "id": "tokens",
        "messages": ["liveliness_token"],
        "flows": ["egress"],
        "permission": "deny",
        "key_exprs": ["**", "@ros2_lv/**"],
    }
    return {
        "enabled": True,
        "default_permission": "allow",
        "rules": [rule],
        "subjects": [{"id": "router", "zids": [session]}],
        "policies": [{"rules": ["tokens"], "subjects": ["router"]}],
    }
