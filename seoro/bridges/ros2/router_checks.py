"""Checks of the router of a ROS 2 system: connected peers whose nodes it does not announce.

Routers of Zenoh 1.9 and newer miss the announcements of peers of Zenoh 1.8 and older that were started before
them; see `silent_peers`.
"""

from __future__ import annotations

import json
import re
from typing import Any, Final

from seoro.bridges.session import AsyncSession, SessionError

ANSWER_TIMEOUT: Final = 2.0  # [s]
FIRST_DEAF: Final = (1, 9)  # version of routers that miss such peers
REMEDY: Final = (
    "restart these nodes, or run `rmw_zenohd` of their distribution, or `seoro router` on their machine"
)
_VERSION: Final = re.compile(r"v?(\d+)\.(\d+)\.")


async def hidden_peers(session: AsyncSession) -> str:
    """Describe the peers of the router whose ROS 2 nodes are not announced; empty without any.

    Routers of seoro announce such nodes, and do not serve the administration space that is read here.
    """
    try:
        answers = await session.query_others("@/*/router", b"", ANSWER_TIMEOUT)
        tokens = await session.list_tokens("@ros2_lv/**", ANSWER_TIMEOUT)
    except SessionError:
        return ""
    announced = {session.identity, *(token.split("/")[2] for token in tokens)}
    for router in map(_read, answers):
        hidden = [peer for peer in _peers(router) if peer not in announced]
        version = _VERSION.match(str(router.get("version", "")))
        if hidden and version is not None and (int(version[1]), int(version[2])) >= FIRST_DEAF:
            return (
                f"the router (Zenoh {version[1]}.{version[2]}) has {len(hidden)} connected "
                f"{'peer' if len(hidden) == 1 else 'peers'} without visible ROS 2 nodes; since Zenoh 1.9, "
                "routers miss nodes of Zenoh 1.8 (Kilted) that started earlier"
            )
    return ""


def _read(answer: bytes) -> dict[str, Any]:
    try:
        found = json.loads(answer)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def _peers(router: dict[str, Any]) -> list[str]:
    """Return the Zenoh IDs of the peers of a router."""
    sessions = router.get("sessions")
    if not isinstance(sessions, list):
        return []
    return [str(each.get("peer")) for each in sessions if isinstance(each, dict) and each.get("whatami") == "peer"]
