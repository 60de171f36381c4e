"""A process that writes a bag endlessly: `python -m tests.bridges.ros2.recording.talker FOLDER LIMIT STORAGE`.

A limit [bytes] of the file size simulates a full disk.
"""

import asyncio
import itertools
import resource
import sys
import time
from pathlib import Path

from seoro.bridges.ros2.recording.writer import write_bag
from tests.bridges.ros2.recording.bags import CHATTER, add, text

SIZE = 20_000  # [bytes] of a message
BURST = 25  # messages


async def main(folder: Path, limit: int, storage: str) -> None:
    """Write numbered messages, and print their number."""
    if limit:
        sys.dont_write_bytecode = True  # compiled modules would be cut off, too
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    filling = "x" * SIZE
    async with write_bag(folder, storage=storage) as writer:
        add(writer, CHATTER)
        for number in itertools.count():
            writer.write(CHATTER.name, text(f"{number} {filling}"), time.time_ns())
            if number % BURST == 0:
                sys.stdout.write(f"{number}\n")
                sys.stdout.flush()
                await asyncio.sleep(0.002)


if __name__ == "__main__":
    asyncio.run(main(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3]))
