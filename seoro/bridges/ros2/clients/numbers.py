"""The 16 bytes by which a goal is known, which whoever sends it draws.

Those of seoro's goals say so, and by which session they were sent: a goal whose session is gone has nobody who is
answerable for it. Others draw theirs at random.
"""

from __future__ import annotations

import hashlib
import secrets
from typing import Final

MARK: Final = b"seoro"
SESSION: Final = 6  # bytes that stand for a session
DRAWN: Final = 16 - len(MARK) - SESSION


def new_number(session: str) -> bytes:
    """A number for a goal of a session of seoro's."""
    return MARK + digest(session) + secrets.token_bytes(DRAWN)


def sender_of(number: bytes) -> bytes | None:
    """The digest of the session that has sent a goal; None if it was none of seoro's."""
    return number[len(MARK) : len(MARK) + SESSION] if number.startswith(MARK) else None


def digest(session: str) -> bytes:
    """What stands for a session in the numbers of its goals.

    Args:
        session: As Zenoh calls it.
    """
    return hashlib.blake2b(session.encode(), digest_size=SESSION).digest()
