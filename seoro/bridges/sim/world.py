"""The simulated world, its cameras and its snapshots; see `Simulation`, `Cameras` and `Snapshots`."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.model_files import ModelFiles
from seoro.bridges.models import ModelNotFound, ModelPath
from seoro.bridges.sim.requests import NodeAddress, Requests, twist_message
from seoro.bridges.sim.rules import check_pose
from seoro.bridges.wire.limits import MAX_REQUEST
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D, Position3D, Velocity6D
from seoro.runtime.contracts.backends import WARNING
from seoro.runtime.contracts.sensors import Image

PROP = "prop://"  # scheme of copies of props of the world, which only the node knows
SPAWN_TIMEOUT = 60.0  # [s]
MAX_MODEL = MAX_REQUEST - (1 << 16)  # [bytes]; a request has some more
PICTURE_TIMEOUT = 30.0  # [s] of the machine's clock; the first picture loads the renderer
SNAPSHOT_TIMEOUT = 120.0  # [s] of the machine's clock
MAX_REPLAY = 86_400.0  # [s] added for engines that replay the simulation
SUFFIX = ".snapshot"
MEDIA_TYPE = "application/vnd.seoro.snapshot"
MAX_KEPT = 100
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


class WorldRequests(Requests):
    """The capabilities `Simulation`, `Cameras` and `Snapshots` of a node; snapshots become artifacts of the run.

    Args:
        address: Address of the node.
        models: Search path of models to spawn.
    """

    features: wire.SimulatorFeatures

    def __init__(self, address: NodeAddress, models: ModelPath) -> None:
        super().__init__(address)
        self._models = models
        self._snapshots: dict[str, wire.Snapshot] = {}

    async def spawn_entity(self, name: str, model: str, pose: Pose3D, *, allow_renaming: bool = False) -> str:
        """See `Simulation`."""
        spawned = await self.ask(wire.SPAWN_ENTITY, self._entity(name, model, pose, allow_renaming))
        self._report_warnings(spawned)
        return spawned.name

    async def named_poses(self) -> Mapping[str, Pose3D]:
        """See `NamedPoses`."""
        found = await self.ask(wire.GET_NAMED_POSES, wire.TagsFilter())
        return {named.name: named.pose for named in found.poses}

    async def spawn_entities(self, entities: Sequence[tuple[str, str, Pose3D]]) -> None:
        """See `Simulation`."""
        texts = tuple(self._entity(name, model, pose, allow_renaming=False) for name, model, pose in entities)
        answer = await self.ask(wire.SPAWN_ENTITIES, wire.SpawnEntities(entities=texts), SPAWN_TIMEOUT)
        refused = [result for result in answer.results if result.code != wire.Result.OK]
        if refused:
            more = f"; {len(refused) - 1} others of {len(texts)} as well" if len(refused) > 1 else ""
            raise BackendRefused(
                f"'{refused[0].name}' was not spawned: {refused[0].message}{more}", refused[0].code
            )
        for result in {result.warnings: result for result in answer.results}.values():  # those of each model once
            self._report_warnings(result)

    def _report_warnings(self, spawned: wire.Spawned | wire.SpawnOutcome) -> None:
        for warning in spawned.warnings:
            self._on_event(WARNING, {"message": f"{spawned.name}: {warning}"})

    def _entity(self, name: str, model: str, pose: Pose3D, allow_renaming: bool) -> wire.SpawnEntity:
        found = ModelFiles("") if model.startswith(PROP) else self._read(model)
        return wire.SpawnEntity(
            name=name,
            uri=model,
            resource_string=found.text,
            files=tuple(wire.NamedFile(path=path, data=data) for path, data in found.files.items()),
            initial_pose=pose,
            allow_renaming=allow_renaming,
        )

    def _read(self, model: str) -> ModelFiles:
        try:
            found = self._models.read(model)
        except ModelNotFound as error:
            raise BackendRefused(str(error), wire.SpawnResult.NO_RESOURCE) from error
        if not found.text:
            raise BackendRefused(f"the model '{model}' is empty", wire.SpawnResult.NO_RESOURCE)
        if found.size > MAX_MODEL:
            raise BackendRefused(
                f"the model '{model}' has {found.size} bytes with its meshes; expected at most {MAX_MODEL}: "
                "simplify its meshes, or make it a prop of the world",
                wire.SpawnResult.NO_RESOURCE,
            )
        return found

    async def relative_pose(self, frame: str, parent_frame: str, distance: float) -> Pose3D:
        """See `Simulation`."""
        request = wire.RelativePose(frame=frame, parent_frame=parent_frame, distance=distance)
        found = await self.ask(wire.GET_RELATIVE_POSE, request)
        pose = Pose3D(found.position, found.orientation)
        check_pose(self.name, f"the pose of '{frame:.100}' in '{parent_frame:.100}'", pose)
        return pose

    async def delete_entity(self, name: str) -> None:
        """See `Simulation`."""
        await self.ask(wire.DELETE_ENTITY, wire.EntityName(name=name))

    async def entities(self) -> tuple[str, ...]:
        """See `Simulation`."""
        return (await self.ask(wire.GET_ENTITIES, wire.EntityFilter())).names

    async def set_entity_state(self, name: str, pose: Pose3D, velocity: Velocity6D) -> None:
        """See `Simulation`."""
        request = wire.SetEntityState(name=name, pose=pose, twist=twist_message(velocity))
        await self.ask(wire.SET_ENTITY_STATE, request)

    async def step_simulation(self, steps: int) -> None:
        """See `Simulation`."""
        await self.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=steps))

    async def reset_simulation(self) -> None:
        """See `Simulation`. The clock of the simulator is that of the run, so it is not reset."""
        scope = wire.ResetScope.STATE | wire.ResetScope.SPAWNED
        await self.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=scope))

    # ------------------------------------------------------------ cameras

    async def spawn_camera(self, name: str, pose: Pose3D, fov: float, width: int, height: int) -> str:
        """See `Cameras`."""
        request = wire.SpawnCamera(name=name, pose=pose, fov=fov, width=width, height=height)
        return (await self.ask(wire.SPAWN_CAMERA, request)).name

    async def cameras(self) -> tuple[str, ...]:
        """See `Cameras`."""
        return (await self.ask(wire.GET_CAMERAS, wire.Empty())).names

    async def place_camera(self, name: str, pose: Pose3D) -> None:
        """See `Cameras`."""
        await self.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=name, pose=pose))

    async def aim_camera(self, name: str, target: Position3D) -> None:
        """See `Cameras`."""
        await self.ask(wire.AIM_CAMERA, wire.AimCamera(name=name, target=target))

    async def follow_entity(self, name: str, entity: str, offset: Position3D) -> None:
        """See `Cameras`."""
        request = wire.FollowEntity(name=name, entity=entity, offset=offset)
        await self.ask(wire.FOLLOW_ENTITY, request)

    async def delete_camera(self, name: str) -> None:
        """See `Cameras`."""
        await self.ask(wire.DELETE_ENTITY, wire.EntityName(name=name))

    async def take_picture(self, name: str) -> Image:
        """See `Cameras`."""
        found = await self.ask(wire.GET_CAMERA_IMAGE, wire.EntityName(name=name), PICTURE_TIMEOUT)
        return Image(found.time, found.width, found.height, found.data)

    # ------------------------------------------------------------ snapshots

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
        self.features = await self.ask(wire.RESTORE_STATE, request, SNAPSHOT_TIMEOUT + replay)

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
