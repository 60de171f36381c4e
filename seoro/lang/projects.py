"""Settings of a project: `seoro.toml`, or the table `[tool.seoro]` of `pyproject.toml`.

The project of a scenario is the nearest folder upwards with one of these; `seoro.toml` comes first. Options of the
command line and directives of the scenario file take precedence over settings. Paths are relative to the file with
the settings.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, NamedTuple

from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input
from seoro.lang.diagnostics import near

FILE: Final = "seoro.toml"
PYPROJECT: Final = "pyproject.toml"
TABLE: Final = "tool.seoro"
TEST: Final = "test"  # table of the settings of `seoro test`


class _Unfit(Exception):
    """An invalid value of a setting; the message is the expected one."""


class Setting(NamedTuple):
    """A setting of projects.

    Attributes:
        read: Converts its value, for the folder of the project; raises `_Unfit`.
        meaning: Meaning, for the reference.
        option: Option of the command line with the same meaning; empty without one.
        is_secret: Whether values may contain secrets, and are not shown.
    """

    read: Callable[[Any, Path], Any]
    meaning: str
    option: str = ""
    is_secret: bool = False


def _text(value: Any, _folder: Path) -> str:
    if not isinstance(value, str) or not value:
        raise _Unfit("a text")
    return value


def _texts(value: Any, folder: Path) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise _Unfit("a list of texts")
    return tuple(_text(each, folder) for each in value)


def _path(value: Any, folder: Path) -> Path:
    return Path(os.path.normpath(folder / _text(value, folder)))


def _paths(value: Any, folder: Path) -> tuple[Path, ...]:
    if not isinstance(value, list) or not all(isinstance(each, str) and each for each in value):
        raise _Unfit("a list of paths")
    return tuple(_path(each, folder) for each in value)


def _world(value: Any, folder: Path) -> str:
    from seoro.files.world_names import WorldName  # noqa: PLC0415 - each command loads this module

    name = WorldName.parse(_text(value, folder))
    return name.located(lambda path: _path(str(path), folder))


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise _Unfit("a positive number")
    return float(value)


def _rate(value: Any, _folder: Path) -> float:
    try:
        return math.inf if value == "max" else _number(value)
    except _Unfit:
        raise _Unfit('a positive number, or "max"') from None


def _seconds(value: Any, _folder: Path) -> float:
    try:
        return _number(value)
    except _Unfit:
        raise _Unfit("a positive number of seconds") from None


def _count(value: Any, _folder: Path) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise _Unfit("a whole number from 0")
    return value


def _codes(value: Any, folder: Path) -> frozenset[str]:
    if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
        raise _Unfit('a list of codes, such as ["E0702"]')
    from seoro.lang.explain import codes, near_codes  # noqa: PLC0415 - for this setting only

    for code in value:
        if code not in codes():
            raise _Unfit(near_codes(code) or "codes that `seoro explain` lists")
    return frozenset(value)


SETTINGS: Final[Mapping[str, Setting]] = {
    "simulator": Setting(_text, "simulator of runs that name none: `mujoco` or `pybullet`", "--sim"),
    "world": Setting(_world, "world of the simulator: a name or a file", "--world"),
    "rate": Setting(_rate, 'simulated seconds per second, or `"max"`', "--rate"),
    "model-path": Setting(_paths, "folders to search for models `name://path`", "--model-path"),
    "lab": Setting(_path, "lab file that assigns robots or simulators to actors", "--lab"),
    "timeout": Setting(_seconds, "limit of the wall time of a run [s]", "--timeout"),
    "executor": Setting(_text, "executor for runs; `--local` runs in this process", "--on"),
    "endpoint": Setting(_text, "Zenoh endpoint of executors or of their router", "--executor"),
    "ignore": Setting(_codes, "codes of warnings that `seoro check` and editors leave out", "--ignore"),
    "output": Setting(_path, "folder of results; each scenario has its own folder inside", "--output-dir"),
    "notify": Setting(_texts, "URLs that receive the results of runs and campaigns", "--notify", is_secret=True),
    "libraries": Setting(_paths, "folders with libraries that scenarios import as `osc.NAME`"),
}
TEST_SETTINGS: Final[Mapping[str, Setting]] = {
    "paths": Setting(_paths, "files and folders of tests, if the command line names none"),
    "jobs": Setting(_count, "number of tests at a time", "--jobs"),
    "retries": Setting(_count, "further attempts of a failed test", "--retries"),
    "requirements": Setting(_path, "text file with the names of all requirements, a line each"),
}


class Project(NamedTuple):
    """A project.

    Attributes:
        file: File of the settings.
        values: Settings by key.
        test: Settings of `seoro test` by key.
    """

    file: Path
    values: Mapping[str, Any]
    test: Mapping[str, Any]

    @property
    def folder(self) -> Path:
        """Folder of the project."""
        return self.file.parent


def project_of(path: Path) -> Project | None:
    """Return the project of a file or a folder; None without one.

    Raises:
        UsageError: Settings are invalid.
    """
    full = path.absolute()
    for folder in (full, *full.parents):
        for name in (FILE, PYPROJECT):
            file = folder / name
            try:
                stamp = file.stat()
            except (OSError, ValueError):
                continue
            found = _read(file, stamp.st_mtime_ns, stamp.st_size)
            if found is not None:
                return found
    return None


def settings_around(file: Path | None) -> Mapping[str, Any]:
    """Return the settings of the project of a file; empty without a project.

    Args:
        file: The file; None for text without one, which belongs to the working directory.

    Raises:
        UsageError: A setting is invalid.
    """
    project = project_of(Path.cwd() if file is None else file.absolute().parent)
    return {} if project is None else project.values


@lru_cache(maxsize=64)
def _read(file: Path, _changed: int, _size: int) -> Project | None:
    """Read the settings in a file; None if it has none."""
    try:
        text = read_input(file, Kind.SETTINGS).decode()
        if file.name == PYPROJECT and TABLE not in text:
            return None
        from tomllib import loads  # noqa: PLC0415 - for projects only

        content = loads(text)
    except (OSError, ValueError) as error:
        raise UsageError(f"cannot read the settings of the project in {file}: {error}") from None
    if file.name == PYPROJECT:
        content = content.get("tool", {}).get("seoro")
        if not isinstance(content, dict):
            return None
    test = content.pop(TEST, {})
    if not isinstance(test, dict):
        raise UsageError(f"{_place(file, text, TEST)}: expected a table `{TEST}`, found {test!r}")
    values = dict(_converted(file, text, content, SETTINGS))
    if "lab" in values and "simulator" in values:
        raise UsageError(
            f"{_place(file, text, 'lab')}: `lab` contradicts `simulator`", help="leave out one of them"
        )
    return Project(file, values, dict(_converted(file, text, test, TEST_SETTINGS)))


def _converted(
    file: Path, text: str, content: Mapping[str, Any], settings: Mapping[str, Setting]
) -> Iterator[tuple[str, Any]]:
    for key, value in content.items():
        setting = settings.get(key)
        if setting is None:
            hint = near(key, settings) or f"settings: {', '.join(settings)}"
            raise UsageError(f"{_place(file, text, key)}: unknown setting `{key}`", help=hint)
        try:
            yield key, setting.read(value, file.parent)
        except _Unfit as expected:
            found = "is invalid" if setting.is_secret else f"is {value!r}"
            raise UsageError(f"{_place(file, text, key)}: `{key}` {found}; expected {expected}") from None


def _place(file: Path, text: str, key: str) -> str:
    """Return the place of a key for messages, which tomllib does not have."""
    form = re.compile(rf"\s*(\[.*\b)?{re.escape(key)}\b")
    lines = (number for number, line in enumerate(text.splitlines(), 1) if form.match(line))
    line = next(lines, None)
    return str(file) if line is None else f"{file}:{line}"
