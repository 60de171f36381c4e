"""Who is revoked, as the list in a folder of keys says; read again when it changes."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from seoro.changes import Changes
from seoro.keys.errors import InvalidKeys

if TYPE_CHECKING:
    from seoro.keys.folder import Keys
    from seoro.keys.revocation import Revocations

PERIOD: Final = 0.5  # [s] in which it is looked whether the list has changed

log = logging.getLogger(__name__)


class Revoked:
    """The list of those who are revoked.

    Args:
        keys: The folder of these has the list.

    Raises:
        InvalidKeys: It has none that holds.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        self._stamp = keys.folder.revoked_stamp()
        self._list = self._read()
        self._changes = Changes()

    def current(self) -> Revocations:
        """The list."""
        return self._list

    async def wait_for_change(self, known: Revocations) -> None:
        """Wait until others are revoked than in a list, or other names are known."""
        await self._changes.wait_for(lambda: not self._list.lets_as(known))

    async def follow(self) -> None:
        """Read the list when it changes; does not end. One that does not hold, or is older, changes nothing."""
        while True:
            await asyncio.sleep(PERIOD)
            stamp = self._keys.folder.revoked_stamp()
            if stamp == self._stamp:
                continue
            self._stamp = stamp
            try:
                self._use(self._read())
            except InvalidKeys as error:
                log.error("%s; the list before it holds", error)

    def take(self, data: bytes) -> None:
        """Have a list that somebody has brought, and keep it in the folder.

        Raises:
            InvalidKeys: It does not hold, or there is a later one.
        """
        from seoro.keys.files import write_public  # noqa: PLC0415 - only where there are keys
        from seoro.keys.revocation import parse_list  # noqa: PLC0415 - the same

        self._use(parse_list(data, self._keys.authority))
        write_public(self._keys.folder.revoked, data)

    def _read(self) -> Revocations:
        from seoro.keys.revocation import read_list  # noqa: PLC0415 - only where there are keys

        return read_list(self._keys.folder.revoked, self._keys.authority)

    def _use(self, found: Revocations) -> None:
        if found.number < self._list.number:
            raise InvalidKeys(f"the list of revoked keys has the number {found.number}, after {self._list.number}")
        self._list = found
        self._changes.tell()
