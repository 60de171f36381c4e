"""Actions of `osc.cameras`: cameras of a simulator and their pictures.

An actor is the camera of its own name or the camera in its field `source`: one of the world, or one of a robot,
such as `turtlebot4/front`. A camera that is missing in the world is spawned when it is first placed.
"""

from __future__ import annotations

from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.sensors import Cameras
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("camera.place", anywhere=Cameras)
async def place(ctx: ActionContext, camera: Actor, pose: Pose3D) -> None:
    """Place the camera; it looks along the x axis of the pose."""
    cameras, name = ctx.anywhere(Cameras), name_of(camera)
    if name in await ctx.ask(cameras.cameras()):
        await ctx.ask(cameras.place_camera(name, pose))
    else:
        await _spawn(ctx, camera, pose)


@action("camera.look_at", anywhere=Cameras)
async def look_at(ctx: ActionContext, camera: Actor, target: Position3D) -> None:
    """Turn the camera in place so that a point is in the middle of its pictures."""
    await check_exists(ctx, camera)
    await ctx.ask(ctx.anywhere(Cameras).aim_camera(name_of(camera), target))


@action("camera.follow", anywhere=Cameras)
async def follow(ctx: ActionContext, camera: Actor, entity: str, offset: Position3D) -> None:
    """Make the camera follow an entity at an offset along the axes of the map, and look at it."""
    cameras, name = ctx.anywhere(Cameras), name_of(camera)
    if name not in await ctx.ask(cameras.cameras()):
        await _spawn(ctx, camera, Pose3D(offset))
    await ctx.ask(cameras.follow_entity(name, entity, offset))


@action("camera.take_snapshot", anywhere=Cameras)
async def take_snapshot(ctx: ActionContext, camera: Actor, name: str) -> None:
    """Save a picture as `name.png` in the output folder of the run; without a folder, the picture is discarded."""
    await check_exists(ctx, camera)
    source = name_of(camera)
    image = await ctx.ask(ctx.anywhere(Cameras).take_picture(source))
    file = f"{name or source.replace('/', '_')}.png"
    size = f"{image.width} by {image.height} pixels"
    path = ctx.write_output(file, image.png, f"picture of camera '{source}' at {image.time:.2f} s")
    if path is None:
        ctx.log(f"took a picture of '{source}' ({size}); not saved: the run has no output folder (`-o`)")
    else:
        ctx.log(f"took a picture of '{source}' ({size}): {path.name}")


@action("camera.remove", anywhere=Cameras)
async def remove(ctx: ActionContext, camera: Actor) -> None:
    """Delete a camera that this run has spawned."""
    await check_exists(ctx, camera)
    await ctx.ask(ctx.anywhere(Cameras).delete_camera(name_of(camera)))


async def _spawn(ctx: ActionContext, camera: Actor, pose: Pose3D) -> None:
    source = camera.fields["source"]
    if source:
        known = await ctx.ask(ctx.anywhere(Cameras).cameras())
        raise ActionFailed(f"unknown camera '{source}' (cameras: {', '.join(known) or 'none'})")
    fov, width, height = (camera.fields[name] for name in ("fov", "width", "height"))
    assert isinstance(fov, float) and isinstance(width, int) and isinstance(height, int)
    await ctx.ask(ctx.anywhere(Cameras).spawn_camera(name_of(camera), pose, fov, width, height))


async def check_exists(ctx: ActionContext, camera: Actor) -> None:
    """Check that the simulator has a camera.

    Raises:
        ActionFailed: The camera is missing.
    """
    name, known = name_of(camera), await ctx.ask(ctx.anywhere(Cameras).cameras())
    if name not in known:
        raise ActionFailed(
            f"unknown camera '{name}' (cameras: {', '.join(known) or 'none'}); "
            f"spawn it with `{camera.name}.place`, or set `source` to a camera of the world"
        )


def name_of(camera: Actor) -> str:
    """Return the name of an actor's camera in the simulator."""
    source = camera.fields["source"]
    return source if isinstance(source, str) and source else camera.name.replace(".", "_")
