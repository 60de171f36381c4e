"""Monitor of the list of revoked keys: reads the file again when it changes."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from seoro.concurrency.condition import Condition
from seoro.security.keys.errors import InvalidKeys

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys
    from seoro.security.keys.revocation import Revocations

PERIOD: Final = 0.5  # [s] between two checks of the file

log = logging.getLogger(__name__)


class RevocationMonitor:
    """Current list of revoked keys, from a folder of keys.

    Args:
        keys: Keys whose folder contains the list.

    Raises:
        InvalidKeys: The list is missing or invalid.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        self._stamp = keys.folder.revoked_stamp()
        self._list = self._read()
        self._changes = Condition()

    def current(self) -> Revocations:
        """Return the newest valid list."""
        return self._list

    async def wait_for_change(self, known: Revocations) -> None:
        """Wait until the list differs from `known` in revoked keys or names."""
        await self._changes.wait_for(lambda: not self._list.has_same_access(known))

    async def watch(self) -> None:
        """Read the list whenever it changes; does not return. Invalid and older lists are logged and ignored."""
        while True:
            await asyncio.sleep(PERIOD)
            stamp = self._keys.folder.revoked_stamp()
            if stamp == self._stamp:
                continue
            self._stamp = stamp
            try:
                self._use(self._read())
            except InvalidKeys as error:
                log.error("%s; using the previous list", error)

    def install(self, data: bytes) -> None:
        """Use a newer list, and write it into the folder.

        Raises:
            InvalidKeys: The list is invalid, or older than the current one.
        """
        from seoro.security.keys.files import write_public  # noqa: PLC0415 - only where there are keys
        from seoro.security.keys.revocation import parse_list  # noqa: PLC0415 - the same

        self._use(parse_list(data, self._keys.authority))
        write_public(self._keys.folder.revoked, data)

    def _read(self) -> Revocations:
        from seoro.security.keys.revocation import read_list  # noqa: PLC0415 - only where there are keys

        return read_list(self._keys.folder.revoked, self._keys.authority)

    def _use(self, found: Revocations) -> None:
        if found.number < self._list.number:
            raise InvalidKeys(
                f"outdated list of revoked keys: number {found.number}, expected {self._list.number} or higher"
            )
        self._list = found
        self._changes.notify_all()
