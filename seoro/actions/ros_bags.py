"""Actions of `osc.ros` that record and play bags."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

from seoro.actions.reports import meanwhile
from seoro.actions.ros_support import failing, system_of, telling
from seoro.runtime.actions import action
from seoro.runtime.context import ActionContext
from seoro.runtime.ros_system import Ros2System

NAME = "rosbag2"
CLOSING = 10.0  # [s] that it may take to write what has arrived


@action("bag_record", anywhere=Ros2System)
async def bag_record(
    ctx: ActionContext,
    topics: Sequence[str],
    timestamp_suffix: bool,
    hidden_topics: bool,
    storage: str,
    use_sim_time: bool,
) -> None:
    """Begin to record topics, and wait until all of them are there; the recording ends with the run."""
    name = f"{NAME}_{datetime.now():%Y_%m_%d-%H_%M_%S}" if timestamp_suffix else NAME
    folder = ctx.reserve_output(name, "recorded topics")
    recording = system_of(ctx).recording(
        folder,
        topics,
        lambda text: ctx.relay([text]),
        storage=storage,
        hidden=hidden_topics,
        use_sim_time=use_sim_time,
    )
    with failing():
        kept = await ctx.keep(recording, CLOSING)
        with telling(ctx, lambda: ", ".join(kept.value.missing)):
            await meanwhile(ctx, kept.value.wait_complete())


@action("bag_play", anywhere=Ros2System, files=("source",))
async def bag_play(
    ctx: ActionContext,
    source: str,
    topics: Sequence[str],
    publish_clock: bool,
    publish_clock_rate: float,
    start_offset: float,
) -> None:
    """Play a bag to its end."""
    place = ctx.place_of(source)
    playing = system_of(ctx).play(
        place,
        topics,
        lambda text: ctx.relay([text]),
        start_offset=start_offset,
        clock_rate=publish_clock_rate if publish_clock else None,
    )
    with failing(place, ctx.file.parent / source):
        await meanwhile(ctx, playing)
