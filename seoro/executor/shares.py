"""Whose blobs are whose: what each submitter has sent, which limits hold for, in the order of its last use.

Blobs are kept to spare sending them again; no run needs them once it was taken. Those that an executor before this
one has taken are nobody's.
"""

from __future__ import annotations


class Shares:
    """What is kept of everybody."""

    def __init__(self) -> None:
        self._blobs: dict[str, dict[str, int]] = {}  # by submitter: sizes [bytes] by hash, last used last
        self._owners: dict[str, str] = {}  # by hash
        self._sizes: dict[str, int] = {}  # of all of a submitter [bytes]

    def size(self, owner: str) -> int:
        """How much is kept of somebody [bytes]."""
        return self._sizes.get(owner, 0)

    def oldest(self, owner: str) -> str:
        """The hash of that of somebody, of whom something is kept, which was used least recently."""
        return next(iter(self._blobs[owner]))

    def is_of(self, owner: str, digest: str) -> bool:
        """Whether a blob is somebody's."""
        return self._owners.get(digest) == owner

    def said_size(self, digest: str) -> int | None:
        """The size of a blob that whoever sends it has said [bytes]; None of one that is nobody's."""
        owner = self._owners.get(digest)
        return None if owner is None else self._blobs[owner][digest]

    def add(self, owner: str, digest: str, size: int) -> None:
        """Somebody sends a blob of a size [bytes]; it is theirs alone."""
        self.drop(digest)
        self._owners[digest] = owner
        self._blobs.setdefault(owner, {})[digest] = size
        self._sizes[owner] = self.size(owner) + size

    def use(self, digest: str) -> None:
        """A blob is used again."""
        if digest in self._owners:
            blobs = self._blobs[self._owners[digest]]
            blobs[digest] = blobs.pop(digest)

    def drop(self, digest: str) -> None:
        """A blob is kept no more."""
        owner = self._owners.pop(digest, None)
        if owner is not None:
            self._sizes[owner] -= self._blobs[owner].pop(digest)
