"""Runs command lines of `seoro` one after another in this process, with the `seoro` that PYTHONPATH names.

Each line of stdin is a JSON list: the arguments and a folder. What the command prints goes to the files `stdout`
and `stderr` of the folder. The answer is a line with the exit status. Of seoro, only the command line is used,
which checkouts of all layouts have.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

COLLECTOR = (200_000, 20, 100)  # thresholds of the garbage collector, as the command sets them
CRASHED = 70  # exit status of a command with an uncaught exception


@contextmanager
def output_in(folder: Path) -> Iterator[None]:
    """Send file descriptors 1 and 2, also those of child processes, to files of a folder while the block lasts."""
    saved = [os.dup(number) for number in (1, 2)]
    for number, name in ((1, "stdout"), (2, "stderr")):
        with (folder / name).open("wb") as file:
            os.dup2(file.fileno(), number)
    try:
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for number, copy in zip((1, 2), saved, strict=True):
            os.dup2(copy, number)
            os.close(copy)


def status_of(arguments: Sequence[str]) -> int:
    """Run a command line and return its exit status."""
    from seoro.cli.main import main

    try:
        return int(main(arguments))
    except SystemExit as exit_:  # argparse
        return exit_.code if isinstance(exit_.code, int) else 1
    except BaseException:
        traceback.print_exc()
        return CRASHED


def main() -> None:
    """Answer until stdin ends."""
    import seoro

    gc.set_threshold(*COLLECTOR)
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    print(json.dumps(str(Path(seoro.__file__).resolve())), file=answers)
    for line in sys.stdin:
        arguments, folder = json.loads(line)
        with output_in(Path(folder)):
            status = status_of(arguments)
        print(status, file=answers)


if __name__ == "__main__":
    main()
