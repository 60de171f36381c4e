"""Snapshots of the simulated world; see `Snapshots`."""

from __future__ import annotations

import re

from seoro.bridges import wire
from seoro.bridges.sim.requests import NodeAddress, Requests
from seoro.errors import BackendRefused

SNAPSHOT_TIMEOUT = 120.0  # [s] of the machine's clock
MAX_REPLAY = 86_400.0  # [s] added for engines that replay the simulation
SUFFIX = ".snapshot"
MEDIA_TYPE = "application/vnd.seoro.snapshot"
MAX_KEPT = 100
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


class SnapshotRequests(Requests):
    """The capability `Snapshots` of a node. Saved snapshots become artifacts of the run."""

    _features: wire.SimulatorFeatures

    def __init__(self, address: NodeAddress) -> None:
        super().__init__(address)
        self._snapshots: dict[str, wire.Snapshot] = {}

    async def save_snapshot(self, name: str) -> None:
        """See `Snapshots`."""
        if not _NAME.fullmatch(name):
            raise BackendRefused(
                f"invalid name '{name}' of a snapshot: expected at most 64 letters, digits, '_', '-' and '.', "
                "beginning with a letter or digit",
                wire.Result.OPERATION_FAILED,
            )
        if len(self._snapshots) >= MAX_KEPT and name not in self._snapshots:
            raise BackendRefused(
                f"too many snapshots in this run: at most {MAX_KEPT} are kept; reuse names",
                wire.Result.OPERATION_FAILED,
            )
        self._snapshots[name] = await self.ask(wire.SAVE_STATE, wire.Empty(), SNAPSHOT_TIMEOUT)

    async def restore_snapshot(self, name: str, seed: int | None) -> None:
        """See `Snapshots`."""
        if name not in self._snapshots:
            known = ", ".join(sorted(self._snapshots)) or "none"
            raise BackendRefused(f"unknown snapshot '{name}' (saved in this run: {known})", wire.Result.NOT_FOUND)
        await self._restore(
            wire.RestoreState(snapshot=self._snapshots[name], purpose=wire.Purpose.REWIND, seed=seed)
        )

    async def _restore(self, request: wire.RestoreState) -> None:
        # Some engines replay the simulation up to the snapshot. Its time comes from a file, and may be NaN.
        replay = min(max(0.0, request.snapshot.time), MAX_REPLAY)
        self._features = await self.ask(wire.RESTORE_STATE, request, SNAPSHOT_TIMEOUT + replay)

    def saved_snapshots(self) -> tuple[wire.Artifact, ...]:
        """Return the saved snapshots as artifacts."""
        return tuple(
            wire.Artifact(
                name=name + SUFFIX,
                media_type=MEDIA_TYPE,
                description=f"The simulation as it was at {snapshot.time:.3f} s, to begin other runs from",
                data=wire.encode(snapshot),
            )
            for name, snapshot in self._snapshots.items()
        )
