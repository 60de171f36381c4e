"""Quota of blobs: the owner and size of each blob, in the order of last use.

Blobs are kept to avoid sending them again; an accepted run no longer needs them. Blobs from before a restart of
the executor have no owner.
"""

from __future__ import annotations


class BlobQuota:
    """Owners of blobs, and the total size of each owner."""

    def __init__(self) -> None:
        self._blobs: dict[str, dict[str, int]] = {}  # by submitter: sizes [bytes] by hash, last used last
        self._owners: dict[str, str] = {}  # by hash
        self._sizes: dict[str, int] = {}  # of all of a submitter [bytes]

    def size(self, owner: str) -> int:
        """Return the size of all blobs of an owner [bytes]."""
        return self._sizes.get(owner, 0)

    def oldest(self, owner: str) -> str:
        """Return the hash of the least recently used blob of an owner, who has at least one."""
        return next(iter(self._blobs[owner]))

    def is_owned_by(self, owner: str, digest: str) -> bool:
        """Whether a blob has this owner."""
        return self._owners.get(digest) == owner

    def announced_size(self, digest: str) -> int | None:
        """Return the size of a blob as announced by its owner [bytes]; None without an owner."""
        owner = self._owners.get(digest)
        return None if owner is None else self._blobs[owner][digest]

    def add(self, owner: str, digest: str, size: int) -> None:
        """Assign a blob of a size [bytes] to an owner, in place of any other."""
        self.drop(digest)
        self._owners[digest] = owner
        self._blobs.setdefault(owner, {})[digest] = size
        self._sizes[owner] = self.size(owner) + size

    def use(self, digest: str) -> None:
        """Mark a blob as used now."""
        if digest in self._owners:
            blobs = self._blobs[self._owners[digest]]
            blobs[digest] = blobs.pop(digest)

    def drop(self, digest: str) -> None:
        """Remove a blob from the quota of its owner."""
        owner = self._owners.pop(digest, None)
        if owner is not None:
            self._sizes[owner] -= self._blobs[owner].pop(digest)
