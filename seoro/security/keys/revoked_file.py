"""List of revoked certificates in a folder of keys, as clients read it."""

from __future__ import annotations

import logging
import time
from typing import Final

from seoro.security.keys.certificates import Identity
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import Keys
from seoro.security.keys.revocation import Revocations, read_list

PERIOD: Final = 0.5  # [s] between two looks at the file
_NOBODY: Final = Revocations(0)

log = logging.getLogger(__name__)


class RevokedFile:
    """The list of revoked certificates in a folder of keys; read again when it changes.

    Args:
        keys: The keys in this folder.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        self._list = keys.revoked
        self._stamp: tuple[int, int, int] | None = None
        self._next = float("-inf")  # [s] of the monotonic clock, when to look again

    def current(self) -> Revocations:
        """Return the list; an empty one if the folder has none.

        A file that becomes invalid, older or missing later changes nothing.

        Raises:
            InvalidKeys: The file is invalid, and no valid one was read before.
        """
        now = time.monotonic()
        if self._keys.revoked is None and now >= self._next:
            self._read()
            self._next = now + PERIOD
        return self._list or _NOBODY

    def check(self, identity: Identity) -> None:
        """Check that an identity is not revoked.

        Raises:
            InvalidKeys: The identity is revoked, or the list is invalid.
        """
        if self.current().contains(identity.serial):
            raise InvalidKeys(f"{identity} is revoked", help=f"listed in `{self._keys.folder.revoked}`")

    def _read(self) -> None:
        stamp = self._keys.folder.revoked_stamp()
        if stamp is None or stamp == self._stamp:
            return
        try:
            found = read_list(self._keys.folder.revoked, self._keys.authority)
            if self._list is not None and found.number < self._list.number:
                raise InvalidKeys(
                    f"outdated list of revoked keys: number {found.number}, expected {self._list.number} or higher"
                )
        except InvalidKeys as error:
            if self._list is None:
                raise
            log.error("%s; using the previous list", error)
        else:
            self._list = found
        self._stamp = stamp
