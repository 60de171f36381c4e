"""Goal IDs: 16 bytes, chosen by the client.

IDs of goals of seoro contain a digest of their session, so that goals of a lost session can be canceled. Other
clients choose random IDs.
"""

from __future__ import annotations

import hashlib
import secrets
from typing import Final

MARK: Final = b"seoro"
DIGEST_SIZE: Final = 6  # [bytes]
RANDOM_SIZE: Final = 16 - len(MARK) - DIGEST_SIZE  # [bytes]


def new_goal_id(session: str) -> bytes:
    """Return a new ID for a goal of a session of seoro."""
    return MARK + session_digest(session) + secrets.token_bytes(RANDOM_SIZE)


def decode_sender(goal_id: bytes) -> bytes | None:
    """Return the digest of the session that sent a goal; None for goals of other clients."""
    return goal_id[len(MARK) : len(MARK) + DIGEST_SIZE] if goal_id.startswith(MARK) else None


def session_digest(session: str) -> bytes:
    """Return the digest of a session, given by its Zenoh ID, in the IDs of its goals."""
    return hashlib.blake2b(session.encode(), digest_size=DIGEST_SIZE).digest()
