"""Checks of the installation: seoro, its dependencies and its extras."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Final

from seoro import __version__
from seoro.doctor.findings import Finding, failed, ok, warning
from seoro.executor.sandbox import bubblewrap
from seoro.executor.sandbox.kernel_limits import why_unlimited
from seoro.lang.frozen import Value

_NEEDED: Final = ("eclipse-zenoh", "pydantic", "msgpack", "anyio", "cryptography")
SANDBOX: Final = "without a sandbox, runs can use the files, keys and network of the executor's account"
_BYTES: Final = ("B", "KiB", "MiB", "GiB", "TiB")


class Extra(Value):
    """Optional extra of seoro.

    Args:
        name: Name for pip.
        packages: Main packages.
        purpose: Purpose, for messages.
    """

    name: str
    packages: tuple[str, ...]
    purpose: str


EXTRAS: Final[Sequence[Extra]] = (
    Extra("mujoco", ("mujoco",), "the simulator mujoco"),
    Extra("pybullet", ("pybullet",), "the simulator pybullet"),
    Extra("ros2", ("rosbags", "mcap"), "ROS 2"),
    Extra("video", ("av",), "videos of simulators"),
    Extra("solver", ("z3-solver",), "parameters with hard constraints"),
    Extra("lsp", ("pygls",), "the language server"),
)
# Fewer users need these; missing ones are only listed.
MORE_EXTRAS: Final[Sequence[Extra]] = (
    Extra("test", ("pytest", "pytest-xdist", "watchfiles"), "tests"),
    Extra("ui", ("starlette", "uvicorn", "websockets"), "pages"),
    Extra("recording", ("foxglove-sdk",), "recordings for Foxglove"),
    Extra("search", ("cmaes", "optuna", "ribs"), "campaigns that learn"),
    Extra("dask", ("distributed",), "campaigns on clusters"),
    Extra("pandas", ("pandas",), "runs as data frames"),
    Extra("parquet", ("pyarrow",), "trajectories as Parquet"),
    Extra("people", ("pyrvo",), "people that avoid others by ORCA"),
    Extra("coacd", ("coacd",), "concave meshes of props"),
    Extra("robots", ("example-robot-data", "jvrc-description"), "models of robots"),
    Extra("xacro", ("xacro",), "models with macros"),
    Extra("mcp", ("mcp",), "tools for agents"),
)


def check_installation() -> Iterator[Finding]:
    """Yield the findings about the installation."""
    yield ok("seoro", f"{__version__}, Python {platform.python_version()} on {platform.platform(terse=True)}")
    for name in _NEEDED:
        found = _version(name)
        if found is None:
            yield failed(name, "not installed", _pip(name))
        else:
            yield ok(name, found)
    for extra in EXTRAS:
        yield _check_extra(extra)
    yield _more_extras()
    problem = bubblewrap.trouble()
    yield _check_sandbox(problem)
    yield _check_limits(problem)


def _check_sandbox(problem: str) -> Finding:
    if problem:
        return warning("sandbox", f"runs of an executor here are not sandboxed: {problem}", SANDBOX)
    return ok("sandbox", "runs of an executor here are sandboxed by bubblewrap")


def _check_limits(problem: str) -> Finding:
    """Return which limits of memory and processes apply to runs on this machine."""
    by_kernel = "the kernel limits the memory of each process"
    watched = "and the executor checks the whole run twice a second"
    if unlimited := why_unlimited(is_sandboxed=not problem):
        return ok("limits", f"{by_kernel}, but not the number of processes ({unlimited}), {watched}")
    return ok("limits", f"{by_kernel} and the number of processes and threads of a run, {watched}")


def _versions(extra: Extra) -> dict[str, str | None]:
    """Return the versions of the packages of an extra; None where one is not installed."""
    return {name: _version(name) for name in extra.packages}


def _more_extras() -> Finding:
    """Return which of the extras that fewer users need are installed."""
    absent = [extra for extra in MORE_EXTRAS if None in _versions(extra).values()]
    present = [extra.name for extra in MORE_EXTRAS if extra not in absent]
    text = f"installed: {', '.join(present) or 'none'}"
    if absent:
        named = ", ".join(f"{extra.name} ({extra.purpose})" for extra in absent)
        text += f"; not installed: {named}; install one with {_pip('seoro[NAME]')}"
    return ok("more extras", text)


def _check_extra(extra: Extra) -> Finding:
    versions = _versions(extra)
    if missing := [name for name, found in versions.items() if found is None]:
        return warning(
            extra.name,
            f"not installed: {', '.join(missing)} (needed for {extra.purpose})",
            _pip(f"seoro[{extra.name}]"),
        )
    return ok(extra.name, ", ".join(f"{name} {found}" for name, found in versions.items()))


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _pip(name: str) -> str:
    return f"{sys.executable} -m pip install '{name}'"


def in_bytes(size: int) -> str:
    """Format a size in bytes, such as `1.5 GiB`."""
    shown, unit = float(size), 0
    while shown >= 1024.0 and unit < len(_BYTES) - 1:
        shown, unit = shown / 1024.0, unit + 1
    return f"{shown:.0f} {_BYTES[unit]}" if unit == 0 else f"{shown:.1f} {_BYTES[unit]}"
