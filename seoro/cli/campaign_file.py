"""Campaign files: the options of `seoro campaign run` as YAML, `seoro campaign run study.yaml`.

Each key is an option, or groups some. So the parser of the command line checks values, and errors have the line.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from seoro.campaign.stopping.grammar import parse_rule
from seoro.campaign.strategies.choice import STRATEGIES
from seoro.cli.arguments import Parser
from seoro.cli.campaign_keys import CampaignKeys, Plain, RateKeys, SimulatorKeys
from seoro.errors import UsageError
from seoro.files.world_names import WORLD_FILES, WorldName
from seoro.files.yaml_lines import Lines, read_settings
from seoro.lang.diagnostics import near
from seoro.lang.frozen import Value

PATHS: Final = ("lab", "params", "from-snapshot", "model-path", "ros-interfaces", "output-dir")
_SIMULATOR: Final = {  # keys of `simulator` by option
    "sim": "name", "connect": "connect", "world": "world", "rate": "rate", "from-snapshot": "snapshot",
    "model-path": "model_path",
}  # fmt: skip
_OF_THE_COMMAND: Final = ("debug", "emit", "help", "keys", "list", "notify", "overwrite", "scenario")
_EXCLUSIVE: Final = (("sim", "lab", "connect"), ("video_follow", "video_camera"))
_MAIN: Final = {"grid": "levels", "pairwise": "strength"}  # option for the value of a strategy, else the runs


class _Option(Value):
    """An option with its value.

    Args:
        place: Place in the file.
        name: Name, without `--`.
        value: Value of the file.
    """

    place: Sequence[str]
    name: str
    value: Plain | list[Plain]

    @property
    def values(self) -> list[Plain]:
        """The value, or the values of a repeatable option."""
        return self.value if isinstance(self.value, list) else [self.value]

    @property
    def words(self) -> list[str]:
        """Words of the command line."""
        if isinstance(self.value, bool):
            return [f"--{self.name}"] if self.value else []
        return [f"--{self.name}={_text(each)}" for each in self.values]


def is_campaign_file(file: str) -> bool:
    """Return whether a file is a campaign file by its name."""
    return Path(file).suffix.lower() in WORLD_FILES


def is_setting(option: str) -> bool:
    """Return whether an option of the command is a key of campaign files, without `--`."""
    return option not in _SIMULATOR and option not in _OF_THE_COMMAND


def use_campaign_file(options: argparse.Namespace) -> None:
    """Replace the options of the command line by those with the settings of its campaign file.

    Args:
        options: Options of `seoro campaign run`, which take precedence.

    Raises:
        UsageError: The file cannot be read or is invalid; the message has the file and the line.
    """
    path = Path(options.file)
    keys, lines = read_settings(path, CampaignKeys)
    scenario = path.parent / keys.scenario
    if not scenario.is_file():
        raise UsageError(f"{lines.at(('scenario',))}: scenario: file not found: {scenario}")
    parser: Parser = options.parser
    settings = list(_once(_located(keys, lines, path.parent), lines))
    for each in settings:
        parser.place = f"{lines.at(each.place)}: "
        _, unknown = parser.parse_known_args([options.file, *each.words])
        if unknown:
            parser.refuse_unknown(unknown)
    parser.place = ""
    words = [word for each in settings if not _is_replaced(each, options) for word in each.words]
    given = options.arguments[options.arguments.index(options.what) + 1 :]
    for name, value in vars(parser.parse_args([*words, *given])).items():
        setattr(options, name, value)
    options.file = str(scenario)


def _is_replaced(option: _Option, options: argparse.Namespace) -> bool:
    """Return whether options of the command line replace one of the file, which the parser would add or refuse."""
    if option.place[0] == "strategy" and option.name not in ("runs", "repeat"):
        return options.strategy is not None
    dest = option.name.replace("-", "_")
    if dest == "set":  # each parameter has its own value
        return False
    value = getattr(options, dest)
    if isinstance(value, list):
        return bool(value)
    group = next((group for group in _EXCLUSIVE if dest in group), ())
    return any(getattr(options, name) is not None for name in group)


def _once(settings: Iterator[_Option], lines: Lines) -> Iterator[_Option]:
    """Yield options, each given by one key."""
    seen: dict[str, _Option] = {}
    for each in settings:
        first = seen.setdefault(each.name, each)
        if first is not each and first.place[0] != each.place[0]:
            raise UsageError(
                f"{lines.at(each.place)}: duplicate option `{each.name}`, first at {lines.at(first.place)}"
            )
        yield each


def _located(keys: CampaignKeys, lines: Lines, folder: Path) -> Iterator[_Option]:
    """Yield the options of a file; paths are relative to its folder."""
    for each in _options(keys, lines):
        if each.name in PATHS and not isinstance(each.value, bool):
            yield _Option(each.place, each.name, [str(folder / str(path)) for path in each.values])
        elif each.name == "world":
            world = WorldName.parse(str(each.value)).located(lambda path: folder / path)
            yield _Option(each.place, each.name, world)
        else:
            yield each


def _options(keys: CampaignKeys, lines: Lines) -> Iterator[_Option]:
    if keys.name is not None:
        yield _Option(("name",), "scenario", keys.name)
    yield from _simulator(keys.simulator)
    yield from _strategy(keys.strategy, lines)
    yield from _rules(keys.until, lines)
    for path, value in keys.set.items():
        yield _Option(("set", path), "set", f"{path}={_text(value)}")
    for name, setting in keys.engine.items():
        yield _Option(("engine", name), _name(name), setting)
    for name, setting in (keys.model_extra or {}).items():
        _refuse_misplaced(name, lines)
        yield _Option((name,), _name(name), setting)


def _simulator(simulator: SimulatorKeys) -> Iterator[_Option]:
    for name, key in _SIMULATOR.items():
        value: Any = getattr(simulator, key)
        if value not in (None, ()):
            yield _Option(("simulator", key), name, list(value) if isinstance(value, tuple) else value)


def _strategy(given: Mapping[str, Plain | None], lines: Lines) -> Iterator[_Option]:
    if not given:
        return
    names = [name for name in given if name in STRATEGIES]
    if len(names) != 1:
        found = " and ".join(f"`{name}`" for name in names or given)
        hint = near(next(iter(given)), STRATEGIES) if not names else ""
        raise UsageError(
            f"{lines.at(('strategy',))}: strategy: expected the name of one strategy, found {found}",
            help=hint or f"strategies: {', '.join(STRATEGIES)}",
        )
    for name, value in given.items():
        if name == names[0]:
            yield _Option(("strategy", name), "strategy", name)
        if value is not None:
            option = _MAIN.get(name, "runs") if name == names[0] else _name(name)
            yield _Option(("strategy", name), option, value)


def _rules(rules: Sequence[str | RateKeys], lines: Lines) -> Iterator[_Option]:
    for rule in rules:
        text = rule if isinstance(rule, str) else rule.text
        try:
            parse_rule(text)
        except UsageError as error:
            raise UsageError(f"{lines.at(('until',))}: {error.message}", help=error.help) from error
        yield _Option(("until",), "until", text)


def _refuse_misplaced(key: str, lines: Lines) -> None:
    """Refuse options that have another place in the file, or none."""
    name = _name(key)
    if is_setting(name):
        return
    if name in _SIMULATOR:
        hint = f"write `simulator: {{{_SIMULATOR[name]}: ...}}`"
    else:
        hint = "name the scenario with `name`" if name == "scenario" else f"add `--{name}` to the command"
    raise UsageError(f"{lines.at((key,))}: unknown key `{key}`", help=hint)


def _name(key: str) -> str:
    return key.replace("_", "-")


def _text(value: Plain) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
