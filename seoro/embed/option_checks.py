"""Checks that the options of a run are valid and consistent, before anything starts."""

from __future__ import annotations

import math
from typing import get_args

from seoro.embed.options import ClockName, Lab, Options, Simulator, pose_rate
from seoro.errors import UsageError

MAX_SEED = 2**63 - 1  # fits into messages of simulators


def check_options(options: Options) -> tuple[ClockName, float]:
    """Check the options of a run.

    Returns:
        Clock of the run, and rate of its simulator.
    """
    if options.seed is not None and not 0 <= options.seed <= MAX_SEED:
        raise UsageError(f"invalid seed {options.seed}: expected 0 to {MAX_SEED}")
    if not 0 <= options.grace < math.inf:
        raise UsageError(f"invalid grace {options.grace}: expected seconds from 0")
    if options.clock not in (None, *get_args(ClockName)):
        raise UsageError(f"unknown clock '{options.clock}'", help=f"clocks: {', '.join(get_args(ClockName))}")
    if options.ros is not None and options.clock == "virtual":
        raise UsageError("the clock 'virtual' is impossible with a ROS 2 system", help="leave out `--clock`")
    if options.scans > pose_rate(options):
        found = f"invalid rate of scans {options.scans:g}: expected 0 to {pose_rate(options):g}, the rate of poses"
        raise UsageError(found, help="scans are recorded with poses, in traces that are kept")
    if options.bag is not None:
        return _check_bag(options)
    if options.lab is not None:
        return _check_lab(options, options.lab)
    if options.simulator is not None:
        return _check_simulator(options, options.simulator)
    if options.clock == "sim":
        raise UsageError("the clock 'sim' needs a simulator", help="add `--sim mujoco`")
    return options.clock or "real", math.inf


def _check_bag(options: Options) -> tuple[ClockName, float]:
    if options.simulator is not None or options.lab is not None or options.ros is not None:
        raise UsageError(
            "a bag contradicts a simulator, a lab and a ROS 2 system: nothing can be sent into the past",
            help="leave out all but one of them",
        )
    _check_clock(options, "sim", "a bag")
    return "sim", math.inf


def _check_simulator(options: Options, simulator: Simulator) -> tuple[ClockName, float]:
    _check_clock(options, "sim", "a simulator")
    if simulator.snapshot is not None and simulator.world is not None:
        raise UsageError("a world contradicts a snapshot, which has its own", help="leave out one of them")
    named = [each for each in (simulator.name, simulator.endpoint) if each is not None]
    if len(named) > 1 or not (named or simulator.snapshot):
        raise UsageError("expected either the name of a simulator or its endpoint")
    return "sim", simulator.rate


def _check_lab(options: Options, given: Lab) -> tuple[ClockName, float]:
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file, for runs that have one

    if options.simulator is not None:
        raise UsageError("a simulator contradicts a lab", help="leave out one of them")
    lab = read_lab(given.file)
    if lab.bag is not None and options.ros is not None:
        raise UsageError(
            "recorded robots contradict a ROS 2 system: nothing can be sent into the past",
            help="leave out `--ros`, or use a lab file with running robots",
        )
    if lab.is_recorded:
        _check_clock(options, "sim", "a bag")
        return "sim", math.inf if given.rate is None else given.rate
    clock: ClockName = "real" if lab.simulator is None else "sim"
    _check_clock(options, clock, "robots" if lab.simulator is None else "a simulator")
    if not lab.bridges:
        rate = math.inf if given.rate is None else given.rate
        return clock, rate
    if given.rate not in (None, 1.0):
        raise UsageError(
            f"invalid rate {given.rate:g}: expected 1, since the lab has real robots",
            help="leave out `--rate`",
        )
    return clock, 1.0


def _check_clock(options: Options, clock: ClockName, run: str) -> None:
    if options.clock not in (None, clock):
        raise UsageError(f"the clock '{options.clock}' is impossible with {run}", help="leave out `--clock`")
