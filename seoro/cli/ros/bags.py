"""`seoro ros bag`: record topics into a bag, and play bags."""

from __future__ import annotations

import argparse
import math
import sys
from datetime import datetime
from pathlib import Path
from typing import Final

import anyio

from seoro.bridges.ros2.recording import Playback, Recording, bag_folder, open_bag, play, record
from seoro.cli.bag_command import show_bag
from seoro.cli.exit_status import Exit
from seoro.cli.ros.system import connected
from seoro.cli.ros.values import count_of
from seoro.concurrency.background import background

PATIENCE: Final = 2.0  # [s] before missing topics are reported


async def record_topics(options: argparse.Namespace) -> int:
    """Record until Ctrl-C or for a duration, then print the contents of the bag."""
    folder: Path = options.output or bag_folder(Path(), at=datetime.now())
    begun = False
    async with connected(options) as node:
        recorder = record(
            node,
            folder,
            options.names,
            pattern=options.pattern or ("" if options.names or not options.all else ".*"),
            hidden=options.all,
            use_sim_time=options.use_sim_time,
            storage=options.storage,
            compression=options.compression,
            on_note=_note,
        )
        try:
            async with recorder as recording, background() as tasks:
                begun = True
                tasks.start_soon(_report_missing, recording)
                await recording.wait_complete()
                print(f"recording to {folder}; Ctrl-C ends it", file=sys.stderr)
                await anyio.sleep(options.duration or math.inf)
        finally:  # Ctrl-C is the usual end
            if begun:
                show_bag(open_bag(folder))
    return Exit.PASSED


async def play_bag(options: argparse.Namespace) -> int:
    """Play a bag to its end."""
    bag = open_bag(options.bag)
    async with connected(options) as node:
        topics = tuple(node.resolve(name) for name in options.topic)
        playback = Playback(topics, options.rate, options.start_offset, options.clock)
        published = await play(node, bag, playback, on_note=_note)
    for name, count in published.items():
        print(f"{name}: {count_of(count, 'message')}")
    return Exit.PASSED


async def _report_missing(recording: Recording) -> None:
    await anyio.sleep(PATIENCE)
    if recording.missing:
        _note(f"waiting for {', '.join(recording.missing)}")


def _note(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
