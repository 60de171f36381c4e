"""Permissions of scenarios from the network, which the executor has to allow by name.

Programs that a scenario starts, and Python that it contains or names, have all rights of the executor's user. Both
are found in the text before the scenario runs, and rejected like an invalid scenario. Endpoints on other machines
are rejected at that time, too; files that were not sent when an action opens them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Final

from seoro.actions.processes import RUNNING_PROGRAMS
from seoro.bindings.own_python import own_python
from seoro.bridges.session import is_local
from seoro.embed.options import Options
from seoro.errors import ActionFailed, InvalidScenario, UsageError
from seoro.files.path_mapping import Locate
from seoro.lab.reading import read_lab
from seoro.lang.builtin_libraries import builtin_libraries
from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.libraries import library_files
from seoro.lang.loader import Reader, Sources, Unreadable, read_file
from seoro.lang.plan import Plan
from seoro.lang.source import Span

PYTHON: Final = "python"
NETWORK: Final = "network"
FILES: Final = "files"
CODE: Final = "E0500"
_FILES: Final = "check_data_external"  # runs the Python of a file
PERMISSIONS: Final = {
    PYTHON: "Python in the files of a scenario, or named with `external`",
    FILES: "files of the executor's machine that were not sent",
    NETWORK: "simulators, bridges and ROS 2 systems of other machines",
    **{name: f"the action `{name}`, which starts programs" for name in RUNNING_PROGRAMS},
}


def vet_sources(sources: Sources, allowed: Collection[str]) -> None:
    """Reject a scenario that imports Python without permission.

    Raises:
        InvalidScenario: The scenario imports Python, which is not allowed.
    """
    if PYTHON not in allowed and (found := [_refused(*place, PYTHON) for place in own_python(sources)]):
        raise InvalidScenario(found)


def vet_plan(plan: Plan, allowed: Collection[str]) -> None:
    """Reject a plan that starts programs, or runs the Python of a file, without permission.

    Raises:
        InvalidScenario: An action of the plan is not allowed.
    """
    found = []
    for invocation in plan.action_invocations():
        name = invocation.action.rpartition(".")[2]
        needed = PYTHON if name == _FILES else name
        if needed in PERMISSIONS and needed not in allowed:
            found.append(_refused(invocation.span, f"this executor does not allow `{name}`", needed))
    if found:
        raise InvalidScenario(found)


def vet_endpoints(options: Options, allowed: Collection[str], reach: Collection[str]) -> None:
    """Reject options that connect to other machines without permission.

    Args:
        options: Options of the run.
        allowed: Names of permissions.
        reach: Endpoints that are always allowed.

    Raises:
        UsageError: An endpoint is not allowed.
    """
    for endpoint in _endpoints(options):
        vet_endpoint(endpoint, allowed, reach)


def vet_endpoint(endpoint: str, allowed: Collection[str], reach: Collection[str]) -> None:
    """Reject an endpoint on another machine without permission; see `vet_endpoints`."""
    if NETWORK not in allowed and endpoint not in reach and not is_local(endpoint):
        raise UsageError(
            f"this executor does not allow scenarios to connect to {endpoint}",
            help=f"its operator can allow it: `seoro serve --allow {NETWORK}`, or `reach` in its policy",
        )


def _endpoints(options: Options) -> Iterator[str]:
    """Yield all endpoints that a run connects to."""
    if options.simulator is not None and options.simulator.endpoint is not None:
        yield options.simulator.endpoint
    if options.ros is not None:
        yield options.ros.endpoint
    if options.lab is not None:
        yield from read_lab(options.lab.file).endpoints


def keeping_to(folders: Iterable[Path], locate: Locate, allowed: Collection[str]) -> Locate:
    """Restrict the files that a running scenario may open to some folders.

    Args:
        folders: Folders of the bundle and of the output.
        locate: Maps paths of the sender to those of the bundle.
        allowed: Names of permissions.

    Returns:
        `locate`, which raises `ActionFailed` for files that are not allowed.
    """
    if FILES in allowed:
        return locate
    homes = [folder.resolve() for folder in folders]

    def kept(path: Path) -> Path:
        found = locate(path)
        if not any(found.resolve().is_relative_to(home) for home in homes):
            raise ActionFailed(
                f"this executor does not allow scenarios to read {path}, which was not sent; its operator can "
                f"allow it: `seoro serve --allow {FILES}`"
            )
        return found

    return kept


def _refused(span: Span, what: str, permission: str) -> Diagnostic:
    help_ = f"the operator of the executor can allow it: `seoro serve --allow {permission}`"
    return Diagnostic(Severity.ERROR, CODE, what, Label(span, "not allowed here"), help=help_)


def check_permissions(names: Collection[str]) -> None:
    """Check names of permissions.

    Raises:
        UsageError: A name is unknown.
    """
    for name in names:
        if name not in PERMISSIONS:
            raise UsageError(f"unknown permission '{name}'", help=f"permissions: {', '.join(PERMISSIONS)}")


def reader_of(root: Path) -> Reader:
    """Return a reader for files of a bundle and of installed libraries only.

    Args:
        root: Folder of the bundle.
    """
    home = root.resolve()
    own = _resolved(builtin_libraries())

    @cache
    def installed() -> frozenset[Path]:  # slow, and rarely needed
        return _resolved(library_files(None))

    def read(path: Path) -> str | Unreadable:
        resolved = path.resolve()
        if resolved.is_relative_to(home) or resolved in own or resolved in installed():
            return read_file(path)
        return Unreadable("the file was not sent")

    return read


def _resolved(libraries: Mapping[str, Path]) -> frozenset[Path]:
    return frozenset(file.resolve() for file in libraries.values())
