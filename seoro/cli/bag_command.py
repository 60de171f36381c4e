"""`seoro bag`: what is in a bag of ROS 2."""

from __future__ import annotations

import argparse
import json
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seoro.cli.exits import Exit
from seoro.errors import InvalidUse

if TYPE_CHECKING:
    from seoro.bridges.ros2.recording import Bag, BagTopic

EXAMPLES = """examples:
  seoro bag out/rosbag2_2026_05_31-16_04_05
  seoro bag drive.mcap --json
  seoro bag out/drive --mend      # after its recorder was killed: write its index and metadata.yaml

exit status: 0, also when the bag is cut off; 2 if it is no bag"""

_SECOND = 1_000_000_000  # [ns]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "bag", metavar="BAG", type=Path, help="a folder as rosbag2 makes it, or a file (.mcap or .db3)"
    )
    parser.add_argument("--mend", action="store_true", help="make MCAP files whole that end in the middle")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if find_spec("mcap") is None or find_spec("rosbags") is None:
        raise InvalidUse("bags need mcap and rosbags", help="install them with: pip install 'seoro[ros2]'")
    from seoro.bridges.ros2.recording import mend_bag, open_bag  # noqa: PLC0415 - slow to load, and optional

    bag = mend_bag(options.bag) if options.mend else open_bag(options.bag)
    if options.json:
        print(json.dumps(_summary(bag), indent=2, ensure_ascii=False))
    else:
        show_bag(bag)
    return Exit.PASSED


def show_bag(bag: Bag) -> None:
    """Print what is in a bag."""
    extent, seconds = bag.extent, _duration(bag)
    begun = f", from {datetime.fromtimestamp(extent.start / _SECOND):%Y-%m-%d %H:%M:%S}" if extent.count else ""
    print(f"{bag.path}: {extent.count:,} messages, {seconds:.3f} s{begun}")
    rows = [_row(topic, seconds) for topic in sorted(bag.topics.values(), key=lambda topic: topic.name)]
    widths = [max(len(row[column]) for row in rows) for column in range(4)] if rows else []
    for name, type_name, count, rate in rows:
        print(f"  {name:{widths[0]}}  {type_name:{widths[1]}}  {count:>{widths[2]}}  {rate:>{widths[3]}}")
    for name, text in bag.notes.items():
        for line in text.splitlines():
            print(f"  {name}: {line}")
    if bag.is_cut_off:
        print("it ends in the middle, as its recorder was killed or still writes; `--mend` makes it whole")


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
