"""Play rounds in batches, and record them: `python -m tests.chaos --rounds 500`.

The journal has a line of JSON for each round: its seed, the time that it took, and its violations. Rounds whose
seeds are in it are not played again, so that an interrupted batch is resumed by the same command.

Exit status: 0 no violation in any recorded round, 1 some violations.
"""

from __future__ import annotations

import argparse
import json
import shutil
import signal
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

from tests.chaos.oracle import violations
from tests.chaos.plan import draw
from tests.chaos.play import play
from tests.chaos.stage import staged

BATCH = 25  # rounds with one lab


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m tests.chaos", description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=25, metavar="N", help="number of rounds (default: 25)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the first round (default: 0)")
    parser.add_argument(
        "--journal", type=Path, default=Path("out/chaos.jsonl"), metavar="FILE", help="default: out/chaos.jsonl"
    )
    parser.add_argument("--seconds", type=float, default=float("inf"), help="begin no round after this time")
    parser.add_argument("--keep", action="store_true", help="keep the files of rounds with violations")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that the lab is stopped, too
    options.journal.parent.mkdir(parents=True, exist_ok=True)
    known = _read(options.journal)
    wanted = [seed for seed in range(options.seed, options.seed + options.rounds) if seed not in known]
    end = time.monotonic() + options.seconds
    for first in range(0, len(wanted), BATCH):
        if time.monotonic() < end:
            _batch(wanted[first : first + BATCH], options.journal, end, keep=options.keep)
    known = _read(options.journal)
    bad = {seed: found for seed, found in known.items() if found}
    print(f"{len(known)} rounds recorded in {options.journal}, {len(bad)} with violations")
    for seed, found in sorted(bad.items()):
        print(f"  seed {seed}: {'; '.join(found)}")
    return 1 if bad else 0


def _batch(seeds: list[int], journal: Path, end: float, *, keep: bool) -> None:
    folder = Path(tempfile.mkdtemp(prefix="chaos-"))
    is_bad = False
    try:
        with staged(folder) as stage:
            for seed in seeds:
                if time.monotonic() > end:
                    return
                drawn, began = draw(seed), time.monotonic()
                found = violations(play(drawn, stage, folder / f"round_{seed}"))
                is_bad |= bool(found)
                took = round(time.monotonic() - began, 1)
                with journal.open("a") as file:
                    faults = [asdict(fault) for fault in drawn.faults]
                    file.write(
                        json.dumps({"seed": seed, "took": took, "violations": found, "faults": faults}) + "\n"
                    )
                print(f"seed {seed}: {took} s, {'; '.join(found) or 'ok'}", flush=True)
    finally:
        if keep and is_bad:
            print(f"kept: {folder}")
        else:
            shutil.rmtree(folder, ignore_errors=True)


def _read(journal: Path) -> dict[int, list[str]]:
    """Return the rounds in a journal, without an incomplete last line."""
    found = {}
    for line in journal.read_text().splitlines() if journal.exists() else ():
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        found[entry["seed"]] = entry["violations"]
    return found


if __name__ == "__main__":
    sys.exit(main())
