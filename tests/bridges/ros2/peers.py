"""Peers of Zenoh as rmw_zenoh's sessions are: they learn of each other from the gossip of their router only."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

import zenoh


@contextmanager
def peer(router: str) -> Iterator[zenoh.Session]:
    """A session with the settings of a node of ROS 2."""
    settings = {
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
    }
    session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    try:
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]
