"""Zenoh's configuration of sessions."""

from __future__ import annotations

from typing import Any, Final

LOOPBACK: Final = "tcp/127.0.0.1:0"  # a free port
LEASE: Final = 15_000  # [ms] longest silence of a peer; a dead one is noticed by the end of its connection
PATIENCE: Final = 1_000_000  # [us] longest wait of a message for room on the link
# Number of batches of 64 KiB in the send queue, the most that Zenoh allows. Zenoh's two by default overflow if a
# laser scanner of 1,000 scans a second has to wait 20 ms for a processor.
SEND_QUEUE: Final = 16
LARGEST: Final = 64 << 20  # [bytes], size limit of messages; those of all verbs are lower (`wire.MAX_MESSAGE`)


def session_settings(
    listen: str | None,
    connect: str | None,
    *,
    patient: bool = True,
    gossip: bool = False,
    as_peer: bool = False,
    largest: int = LARGEST,
) -> dict[str, Any]:
    """Return the configuration of a session; see `Session` for the arguments. `connect` is an address.

    Both ends have the same lease for silent peers.
    """
    meets_peers = gossip and listen is None
    queue: dict[str, Any] = {"size": {"data": SEND_QUEUE}}
    if patient:
        # Answers have the congestion control of their requests: they are dropped after a wait. Unlimited waits
        # would let a blocked peer block the event loop. With Zenoh's own limit of 50 ms, busy machines lose one
        # large answer in a hundred.
        drop = {"wait_before_drop": PATIENCE, "max_wait_before_drop_fragments": PATIENCE}
        queue["congestion_control"] = {"drop": drop}
    link: dict[str, Any] = {"tx": {"lease": LEASE, "queue": queue}}
    if patient:
        link["rx"] = {"max_message_size": largest}
    return {
        "mode": "router" if listen else "peer" if as_peer or meets_peers else "client",
        "listen": {"endpoints": [listen] if listen else [LOOPBACK] if meets_peers else []},
        "connect": {
            "endpoints": [connect] if connect else [],
            "timeout_ms": 1000,
            "exit_on_failure": True,
            "retry": {"period_init_ms": 100, "period_max_ms": 500},
        },
        "scouting": {
            "multicast": {"enabled": False},
            "gossip": {
                "enabled": gossip,
                "multihop": False,
                "target": {"router": ["router", "peer"], "peer": ["router"]},
                "autoconnect": {"router": [], "peer": ["peer"] if gossip else []},
                # By default one of two peers connects; peers of other machines cannot.
                "autoconnect_strategy": {"peer": {"to_router": "always", "to_peer": "always"}},
            },
            "delay": 20,
        },
        "timestamping": {"enabled": True},
        "transport": {"shared_memory": {"enabled": False}, "link": link},
    }
