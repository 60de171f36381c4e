"""Which options go together, which is said before anything is started."""

from __future__ import annotations

import math
from typing import get_args

from seoro.embed.options import ClockName, Lab, Options, Simulator
from seoro.errors import InvalidUse

MAX_SEED = 2**63 - 1  # goes into messages for simulators


def check_options(options: Options) -> tuple[ClockName, float]:
    """Refuse options that cannot be, before anything is started.

    Returns:
        The clock of the run, and the rate of its simulator.
    """
    if options.seed is not None and not 0 <= options.seed <= MAX_SEED:
        raise InvalidUse(f"a seed is a whole number from 0 to {MAX_SEED}, not {options.seed}")
    if not 0 <= options.grace < math.inf:
        raise InvalidUse(f"the time for a clean-up is a number of seconds from 0, not {options.grace}")
    if options.clock not in (None, *get_args(ClockName)):
        raise InvalidUse(f"there is no clock '{options.clock}'", help=f"clocks: {', '.join(get_args(ClockName))}")
    if options.ros is not None and options.clock == "virtual":
        raise InvalidUse("a ROS 2 system does not wait for the clock 'virtual'", help="leave out `--clock`")
    if options.lab is not None:
        return _check_lab(options, options.lab)
    if options.simulator is not None:
        return _check_simulator(options, options.simulator)
    if options.clock == "sim":
        raise InvalidUse("the clock 'sim' is that of a simulator, and there is none", help="add `--sim mujoco`")
    return options.clock or "real", math.inf


def _check_simulator(options: Options, simulator: Simulator) -> tuple[ClockName, float]:
    _check_clock(options, "sim", "a simulator")
    if simulator.snapshot is not None and simulator.world is not None:
        raise InvalidUse("a snapshot has its own world", help="leave out the other world, or the snapshot")
    named = [each for each in (simulator.name, simulator.endpoint) if each is not None]
    if len(named) > 1 or not (named or simulator.snapshot):
        raise InvalidUse("a simulator is either started by its name or connected to at its endpoint")
    return "sim", simulator.rate


def _check_lab(options: Options, given: Lab) -> tuple[ClockName, float]:
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file, for runs that have one

    if options.simulator is not None:
        raise InvalidUse("a lab has its own simulator", help="leave out the other simulator, or the lab")
    lab = read_lab(given.file)
    clock: ClockName = "real" if lab.simulator is None else "sim"
    _check_clock(options, clock, "robots" if lab.simulator is None else "a simulator")
    if not lab.bridges:
        rate = math.inf if given.rate is None else given.rate
        return clock, rate
    if given.rate not in (None, 1.0):
        raise InvalidUse(
            f"robots move in real time, and the lab has some: the rate is 1, not {given.rate:g}",
            help="leave out `--rate`",
        )
    return clock, 1.0


def _check_clock(options: Options, clock: ClockName, beside: str) -> None:
    if options.clock not in (None, clock):
        raise InvalidUse(f"the clock '{options.clock}' does not go with {beside}", help="leave out `--clock`")
