"""Snapshots of the simulated world; see `Snapshots` for what the methods do."""

from __future__ import annotations

import re

from seoro.bridges import wire
from seoro.bridges.sim.requests import NodeAddress, Requests
from seoro.errors import BackendRefused

SNAPSHOT_TIMEOUT = 120.0  # [s] of the machine's clock, for the smallest
LONGEST = 86_400.0  # [s] that is waited beyond that
SUFFIX = ".snapshot"
MEDIA_TYPE = "application/vnd.seoro.snapshot"
MAX_KEPT = 100
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


class SnapshotRequests(Requests):
    """The capability `Snapshots` of a node. What was saved is kept here, and is an artifact of the run."""

    _features: wire.SimulatorFeatures

    def __init__(self, address: NodeAddress) -> None:
        super().__init__(address)
        self._snapshots: dict[str, wire.Snapshot] = {}

    async def save_snapshot(self, name: str) -> None:
        """See `Snapshots`."""
        if not _NAME.fullmatch(name):
            raise BackendRefused(
                f"'{name}' cannot name a snapshot: use letters, digits, '_', '-' and '.', at most 64, and a "
                "letter or digit first",
                wire.Result.OPERATION_FAILED,
            )
        if len(self._snapshots) >= MAX_KEPT and name not in self._snapshots:
            raise BackendRefused(
                f"a run keeps {MAX_KEPT} snapshots: save some under names that were used before",
                wire.Result.OPERATION_FAILED,
            )
        self._snapshots[name] = await self.ask(wire.SAVE_STATE, wire.Empty(), SNAPSHOT_TIMEOUT)

    async def restore_snapshot(self, name: str, seed: int | None) -> None:
        """See `Snapshots`."""
        if name not in self._snapshots:
            known = ", ".join(sorted(self._snapshots)) or "none"
            raise BackendRefused(
                f"nothing was saved as '{name}' in this run; saved are {known}", wire.Result.NOT_FOUND
            )
        await self._restore(
            wire.RestoreState(snapshot=self._snapshots[name], purpose=wire.Purpose.REWIND, seed=seed)
        )

    async def _restore(self, request: wire.RestoreState) -> None:
        # Some engines are brought to a state by all that led to it, which takes as long as that took. The time is
        # what a file says, and may be no number.
        led_to_it = min(max(0.0, request.snapshot.time), LONGEST)
        self._features = await self.ask(wire.RESTORE_STATE, request, SNAPSHOT_TIMEOUT + led_to_it)

    def saved_snapshots(self) -> tuple[wire.Artifact, ...]:
        """What was saved, as files."""
        return tuple(
            wire.Artifact(
                name=name + SUFFIX,
                media_type=MEDIA_TYPE,
                description=f"The simulation as it was at {snapshot.time:.3f} s, to begin other runs from",
                data=wire.encode(snapshot),
            )
            for name, snapshot in self._snapshots.items()
        )
