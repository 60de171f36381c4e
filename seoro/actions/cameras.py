"""Actions of `osc.cameras`: cameras of a simulator, and pictures that they take.

An actor is the camera of its own name, or the one that its `source` names: one of the world's, or that of a robot,
such as `turtlebot4/front`. A camera that the world does not have comes into it where it is first put.
"""

from __future__ import annotations

from seoro.errors import ActionFailed
from seoro.runtime.actions import action
from seoro.runtime.capabilities import Cameras
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Pose3D, Position3D
from seoro.runtime.values import Actor


@action("camera.place", anywhere=Cameras)
async def place(ctx: ActionContext, camera: Actor, pose: Pose3D) -> None:
    """Put the camera somewhere; it looks along the x axis of the pose."""
    cameras, name = ctx.anywhere(Cameras), name_of(camera)
    if name in await ctx.ask(cameras.cameras()):
        await ctx.ask(cameras.place_camera(name, pose))
    else:
        await _spawn(ctx, camera, pose)


@action("camera.look_at", anywhere=Cameras)
async def look_at(ctx: ActionContext, camera: Actor, target: Position3D) -> None:
    """Turn the camera where it is, so that a point is in the middle of its pictures."""
    await check_is_there(ctx, camera)
    await ctx.ask(ctx.anywhere(Cameras).aim_camera(name_of(camera), target))


@action("camera.follow", anywhere=Cameras)
async def follow(ctx: ActionContext, camera: Actor, entity: str, offset: Position3D) -> None:
    """Let the camera go with an entity, at an offset along the axes of the map, and look at it."""
    cameras, name = ctx.anywhere(Cameras), name_of(camera)
    if name not in await ctx.ask(cameras.cameras()):
        await _spawn(ctx, camera, Pose3D(offset))
    await ctx.ask(cameras.follow_entity(name, entity, offset))


@action("camera.take_snapshot", anywhere=Cameras)
async def take_snapshot(ctx: ActionContext, camera: Actor, name: str) -> None:
    """Take a picture, and leave it in the output folder of the run as `name.png`; without one, it is not kept."""
    await check_is_there(ctx, camera)
    source = name_of(camera)
    image = await ctx.ask(ctx.anywhere(Cameras).take_picture(source))
    file = f"{name or source.replace('/', '_')}.png"
    size = f"{image.width} by {image.height} pixels"
    path = ctx.leave_file(file, image.png, f"picture of camera '{source}' at {image.time:.2f} s")
    if path is None:
        ctx.log(f"a picture of '{source}' was taken ({size}), and not kept: the run has no output folder (`-o`)")
    else:
        ctx.log(f"a picture of '{source}' was taken ({size}): {path.name}")


@action("camera.remove", anywhere=Cameras)
async def remove(ctx: ActionContext, camera: Actor) -> None:
    """Delete a camera that came into the world by this run."""
    await check_is_there(ctx, camera)
    await ctx.ask(ctx.anywhere(Cameras).delete_camera(name_of(camera)))


async def _spawn(ctx: ActionContext, camera: Actor, pose: Pose3D) -> None:
    source = camera.fields["source"]
    if source:
        known = await ctx.ask(ctx.anywhere(Cameras).cameras())
        raise ActionFailed(f"there is no camera '{source}'; there are {', '.join(known) or 'none'}")
    fov, width, height = (camera.fields[name] for name in ("fov", "width", "height"))
    assert isinstance(fov, float) and isinstance(width, int) and isinstance(height, int)
    await ctx.ask(ctx.anywhere(Cameras).spawn_camera(name_of(camera), pose, fov, width, height))


async def check_is_there(ctx: ActionContext, camera: Actor) -> None:
    """Find out whether the simulator has a camera.

    Raises:
        ActionFailed: It has not.
    """
    name, known = name_of(camera), await ctx.ask(ctx.anywhere(Cameras).cameras())
    if name not in known:
        raise ActionFailed(
            f"there is no camera '{name}': put one somewhere with `{camera.name}.place`, or name one of the "
            f"world's by `source`; there are {', '.join(known) or 'none'}"
        )


def name_of(camera: Actor) -> str:
    """What an actor is called in the simulator."""
    source = camera.fields["source"]
    return source if isinstance(source, str) and source else camera.name.replace(".", "_")
