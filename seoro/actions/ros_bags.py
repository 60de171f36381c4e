"""Actions of `osc.ros` that record and play bags."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

from seoro.actions.reports import meanwhile
from seoro.actions.ros_support import as_action_failure, log_missing, system_of
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.functions.actions import action

NAME = "rosbag2"
CLOSING = 10.0  # [s] for writing the last messages


@action("bag_record", anywhere=Ros2System)
async def bag_record(
    ctx: ActionContext,
    topics: Sequence[str],
    timestamp_suffix: bool,
    hidden_topics: bool,
    storage: str,
    use_sim_time: bool,
) -> None:
    """Start recording topics, and wait until all of them are recorded; the recording ends with the run."""
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
    with as_action_failure():
        kept = await ctx.keep(recording, CLOSING)
        with log_missing(ctx, lambda: ", ".join(kept.value.missing)):
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
    path = ctx.resolve_path(source)
    playing = system_of(ctx).play(
        path,
        topics,
        lambda text: ctx.relay([text]),
        start_offset=start_offset,
        clock_rate=publish_clock_rate if publish_clock else None,
    )
    with as_action_failure(path, ctx.file.parent / source):
        await meanwhile(ctx, playing)
