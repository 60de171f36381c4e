"""Loads models of makers into both engines, and counts what loads.

    python benchmarks/foreign_models.py [PACKAGE ...] [--every N]

Packages are Python packages with models; missing ones are skipped. By default: pybullet_data, robosuite,
dm_control and gymnasium_robotics, which are installed for this only, by `pip install --no-deps --target FOLDER
robosuite dm_control gymnasium-robotics`, with FOLDER in PYTHONPATH. Each model is added to an empty world, and
simulated for 0.1 s. MJCF files that MuJoCo itself refuses are not counted: they are parts of other files, or lack
their meshes. Those of pybullet_data are counted, since they are made for PyBullet. Prints a table of counts, and
the reasons of refusals with an example of each. MJCF files without a body, such as floors, are not counted either.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import re
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import islice
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerContext
from pathlib import Path
from typing import NamedTuple, cast

from seoro.bridges.model_files import InvalidModel, gather
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.extents import lowest_point
from sim_nodes.models import parse_bodies
from sim_nodes.physics import BodyState, Scene, UnstablePhysics
from sim_nodes.spawning import placed_bodies

MADE_FOR_PYBULLET = "pybullet_data"
PACKAGES = (MADE_FOR_PYBULLET, "robosuite", "dm_control", "gymnasium_robotics")
SUFFIXES = {".urdf": "URDF", ".sdf": "SDF", ".xml": "MJCF"}
EXTENT = (-20.0, -20.0, 20.0, 20.0)
CLEARANCE = 0.01  # [m] above the floor
DURATION = 0.1  # [s]
LIMIT = 120.0  # [s] for one model
MOST_MODELS = 100  # of one process
LOADED = "loaded"
INCOMPLETE = "MuJoCo refuses the file itself"
EMPTY = "found no shapes besides floors"


class Case(NamedTuple):
    """A model in an engine."""

    package: str
    path: Path
    engine: str


def load(case: Case) -> tuple[str, float]:
    """Load a model into an engine; returns `LOADED`, or the reason why not, and the duration [s]."""
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, sys.stderr.fileno())  # warnings of engines
    start = time.perf_counter()
    try:
        found = gather(case.path)
        bodies = parse_bodies(found.text, found.files)
        engine = ENGINES[case.engine]()
        engine.build(Scene((), (), EXTENT))
        origin = BodyState((0.0, 0.0, 0.0))
        lowest = min(lowest_point(*body) for body in placed_bodies("model", bodies, origin, ()).values())
        state = BodyState((0.0, 0.0, CLEARANCE - lowest))
        for name, (model, place) in placed_bodies("model", bodies, state, ()).items():
            engine.add_body(name, model, place)
        left = round(DURATION * engine.steps_per_second)
        while left > 0:
            left -= engine.step(left)
    except (InvalidModel, RequestRefused) as error:
        whole = case.package == MADE_FOR_PYBULLET or case.path.suffix != ".xml" or _is_whole(case.path)
        reason = str(getattr(error, "message", error))
        if case.path.suffix == ".xml" and reason.startswith(EMPTY):
            return EMPTY, time.perf_counter() - start
        return reason if whole else INCOMPLETE, time.perf_counter() - start
    except UnstablePhysics as error:
        return f"unstable: {error}", time.perf_counter() - start
    except Exception as error:  # counted as a failure of seoro
        return f"FAULT {type(error).__name__}: {error}", time.perf_counter() - start
    return LOADED, time.perf_counter() - start


def _is_whole(path: Path) -> bool:
    """Whether MuJoCo compiles an MJCF file as it is on the disk."""
    import mujoco  # noqa: PLC0415 - in the process of the model

    try:
        mujoco.MjSpec.from_file(str(path)).compile()
    except (ValueError, TypeError):
        return False
    return True


class Worker:
    """Loads models in a process of its own, which may crash or take too long; it is replaced then.

    Args:
        context: Starts processes.
    """

    def __init__(self, context: ForkServerContext) -> None:
        self._context = context
        self._start()

    def load(self, case: Case) -> tuple[str, float]:
        """Load a model; see `load`."""
        if self._count == MOST_MODELS:
            self.stop()
            self._start()
        self._count += 1
        self._pipe.send(case)
        try:
            if self._pipe.poll(LIMIT):
                return cast(tuple[str, float], self._pipe.recv())
            reason = f"takes more than {LIMIT:g} s"
        except (EOFError, ConnectionResetError):
            reason = "FAULT the process crashed"
        self.stop()
        self._start()
        return reason, LIMIT

    def stop(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()
        self._pipe.close()

    def _start(self) -> None:
        self._pipe, there = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(there,))
        self._process.start()
        self._count = 0
        there.close()


def _serve(pipe: Connection) -> None:
    """Load the models of a pipe."""
    while True:
        pipe.send(load(pipe.recv()))


def models_of(package: str) -> Iterator[Path]:
    """Yield the model files of an installed package."""
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        return
    root = Path(spec.origin).parent
    for path in sorted(each for suffix in SUFFIXES for each in root.rglob(f"*{suffix}")):
        if path.suffix != ".xml" or _is_mjcf(path):
            yield path


def _is_mjcf(path: Path) -> bool:
    """Whether an XML file is in MJCF."""
    return "<mujoco" in path.read_text(encoding="utf-8", errors="replace")


def main() -> None:
    """Load all models, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("packages", nargs="*", default=PACKAGES)
    parser.add_argument("--every", type=int, default=1, help="load every Nth model only")
    options = parser.parse_args()
    cases = [
        Case(package, path, engine)
        for package in options.packages
        for path in islice(models_of(package), 0, None, options.every)
        for engine in ENGINES
        if find_spec(engine) is not None
    ]
    context = multiprocessing.get_context("forkserver")
    modules = ["sim_nodes.models.canonical", "sim_nodes.models.meshes", "sim_nodes.models.sdf"]
    engines = sorted({case.engine for case in cases})
    context.set_forkserver_preload([*modules, *(f"sim_nodes.{engine}.engine" for engine in engines)])
    reasons: dict[tuple[str, str, str], Counter[str]] = defaultdict(Counter)
    examples: dict[str, Case] = {}
    slowest: dict[str, tuple[float, Case]] = {}
    worker = Worker(context)
    for done, case in enumerate(cases, 1):
        reason, seconds = worker.load(case)
        kind = re.sub(r"'[^']*'|\"[^\"]*\"|-?\d[\d.e+-]*", "…", reason)
        reasons[case.package, SUFFIXES[case.path.suffix], case.engine][kind] += 1
        examples.setdefault(kind, case)
        print(f"\r{done} of {len(cases)}", end="", file=sys.stderr, flush=True)
        slowest[case.engine] = max(slowest.get(case.engine, (0.0, case)), (seconds, case))
    worker.stop()
    print(f"{'package':<20} {'format':<6} {'engine':<9} {'models':>6} {'loaded':>6} {'share':>6}")
    for (package, form, engine), counts in sorted(reasons.items()):
        total = counts.total() - counts[INCOMPLETE] - counts[EMPTY]
        print(f"{package:<20} {form:<6} {engine:<9} {total:>6} {counts[LOADED]:>6} {counts[LOADED] / total:>6.1%}")
    refused = sum(reasons.values(), Counter())
    incomplete, empty = refused[INCOMPLETE] // len(engines), refused[EMPTY] // len(engines)
    print(
        f"\nnot counted: {incomplete} MJCF files that MuJoCo refuses itself, {empty} without a body\nnot loaded:"
    )
    for kind, count in refused.most_common():
        if kind not in (LOADED, INCOMPLETE, EMPTY):
            print(
                f"{count:>5}  {kind[:150]}\n       such as {examples[kind].path.name} in {examples[kind].engine}"
            )
    for engine, (seconds, case) in sorted(slowest.items()):
        print(f"slowest in {engine}: {case.path.name}, {seconds:.1f} s")


if __name__ == "__main__":
    main()
