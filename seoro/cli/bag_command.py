"""`seoro bag`: show, repair or convert a ROS 2 bag."""

from __future__ import annotations

import argparse
import json
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seoro.cli.arguments import add_option
from seoro.cli.files import write_errors
from seoro.cli.packages import ROS2, require
from seoro.cli.tables import table
from seoro.files.replacing import replacing

if TYPE_CHECKING:
    from seoro.bridges.ros2.recording import Bag, BagTopic

EXAMPLES = """examples:
  seoro bag out/rosbag2_2026_05_31-16_04_05
  seoro bag drive.mcap --json
  seoro bag field/drive --trace drive.jsonl    # then show it as a page: `seoro report drive.jsonl`
  seoro bag out/drive --repair    # after its recorder was killed: write its index and metadata.yaml

exit status: 0, also for a truncated bag; 2 if the bag is missing or invalid"""

_SECOND = 1_000_000_000  # [ns]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("bag", metavar="BAG", type=Path, help="rosbag2 folder, or file (.mcap or .db3)")
    add_option(parser, "--repair", "complete truncated files")
    add_option(
        parser, "--trace FILE", "write a trace of its frames, scans, map, plans and logs, for `seoro report`"
    )
    add_option(parser, "--json", "print JSON")


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    require("`seoro bag`", "ros2", *ROS2)
    from seoro.bridges.ros2.recording import open_bag, repair_bag  # noqa: PLC0415 - slow to load, and optional

    bag = repair_bag(options.bag) if options.repair else open_bag(options.bag)
    if options.trace is not None:
        _write_trace(bag, options.trace)
    elif options.json:
        print(json.dumps(_summary(bag), indent=2, ensure_ascii=False))
    else:
        show_bag(bag)


def _write_trace(bag: Bag, path: Path) -> None:
    """Write the trace of a bag.

    Raises:
        UsageError: The file cannot be written, or a message of the bag is invalid.
    """
    from seoro.bridges.ros2.recording.bag_trace import records_of  # noqa: PLC0415 - slow to load, and optional

    count = 0
    with (
        write_errors(path),
        replacing(path) as partial,
        partial.open("w", encoding="utf-8", newline="\n") as file,
    ):
        for record in records_of(bag):
            file.write(json.dumps(record) + "\n")
            count += 1
    print(f"wrote {path}: {count:,} records")


def show_bag(bag: Bag) -> None:
    """Print the topics, messages and duration of a bag."""
    extent, seconds = bag.extent, _duration(bag)
    begun = f", from {datetime.fromtimestamp(extent.start / _SECOND):%Y-%m-%d %H:%M:%S}" if extent.count else ""
    print(f"{bag.path}: {extent.count:,} messages, {seconds:.3f} s{begun}")
    rows = [_row(topic, seconds) for topic in sorted(bag.topics.values(), key=lambda topic: topic.name)]
    if rows:
        print(table(rows, "  ", right=(2, 3)))
    for name, text in bag.notes.items():
        for line in text.splitlines():
            print(f"  {name}: {line}")
    if bag.is_cut_off:
        print("truncated: its recorder was killed or is still writing; `--repair` completes it")


def _row(topic: BagTopic, seconds: float) -> tuple[str, str, str, str]:
    rate = f"{(topic.count - 1) / seconds:.1f} Hz" if seconds and topic.count > 1 else ""
    return topic.name, topic.type, f"{topic.count:,}", rate


def _summary(bag: Bag) -> dict[str, Any]:
    return {
        "path": str(bag.path),
        "messages": bag.extent.count,
        "start": bag.extent.start,
        "duration": _duration(bag),
        "is_cut_off": bag.is_cut_off,
        "topics": {
            topic.name: {"type": topic.type, "type_hash": topic.type_hash, "messages": topic.count}
            for topic in bag.topics.values()
        },
        "notes": dict(bag.notes),
    }


def _duration(bag: Bag) -> float:
    return (bag.extent.end - bag.extent.start) / _SECOND
