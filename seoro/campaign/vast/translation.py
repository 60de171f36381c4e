"""Translation of RoboVAST files into campaign files, with notes about all that is not carried over."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from typing import Any, Final

from seoro.campaign.vast.notes import PARTS, Note
from seoro.campaign.vast.schema import Configuration, Search, Variation, VastFile
from seoro.campaign.vast.searches import missing_parameters, search_notes, search_strategy, without_template
from seoro.campaign.vast.values import Range, bounded, listed, literal, own_type, range_of
from seoro.campaign.vast.wrapper import Wrapper
from seoro.lang.frozen import Value

IN_THE_SCENARIO: Final = "write it in the scenario"


class Target(Value):
    """Scenario of a RoboVAST file.

    Args:
        file: Its file, relative to the RoboVAST file.
        name: Name of the scenario.
        types: Types of its parameters, by name.
        required: Names of those without a default.
    """

    file: str
    name: str
    types: Mapping[str, str]
    required: frozenset[str]


class Study(Value):
    """Campaign of a RoboVAST file.

    Args:
        name: Name of its files, without a suffix.
        keys: Content of the campaign file.
        wrapper: Scenario file beside it; None if the scenario itself is run.
    """

    name: str
    keys: Mapping[str, Any]
    wrapper: Wrapper | None = None


class Translation(Value):
    """Campaigns of a RoboVAST file, and notes about the rest."""

    studies: tuple[Study, ...]
    notes: tuple[Note, ...] = field(default=())


def translate(file: VastFile, target: Target, stem: str) -> Translation:
    """Translate a file.

    Args:
        file: The file.
        target: Its scenario.
        stem: Name of the file, without its suffix.
    """
    notes = list(_unsupported_parts(file))
    studies: list[Study] = []
    if file.search is not None:
        studies.append(_of_search(file, file.search, target, stem, notes))
    for index, each in enumerate(file.configuration or ()):
        studies.append(
            _of_configuration(file, each, target, f"{stem}_{each.name}", ("configuration", index), notes)
        )
    return Translation(tuple(studies), tuple(notes))


def _unsupported_parts(file: VastFile) -> Iterator[Note]:
    given = file.model_dump(exclude_unset=True)
    for place, (why, advice) in PARTS.items():
        found: Any = given
        for key in place:
            found = found.get(key) if isinstance(found, dict) else None
        if found and place != ("metadata",):
            yield Note(place, ".".join(place), why, advice)


def _common(file: VastFile, scenario: str, name: str) -> dict[str, Any]:
    keys: dict[str, Any] = {"scenario": scenario}
    if file.execution.timeout is not None:
        keys["timeout"] = file.execution.timeout
    return keys | {"output_dir": f"{name}_results"}


# ---------------------------------------------------------------- batches


def _of_configuration(
    file: VastFile,
    configuration: Configuration,
    target: Target,
    name: str,
    place: Sequence[str | int],
    notes: list[Note],
) -> Study:
    found = _Batch(target, notes)
    for index, parameters in enumerate(configuration.parameters or ()):
        for path, value in parameters.items():
            found.set(path, value, (*place, "parameters", index, path))
    for index, variation in enumerate(configuration.variations or ()):
        found.vary(variation, (*place, "variations", index))
    keys = _common(file, target.file, name)
    if found.runs:
        keys["strategy"] = {"random": found.runs * file.execution.runs, "repeat": file.execution.runs}
    else:
        keys["repeat"] = file.execution.runs
    for key, values in (("vary", found.varied), ("constrain", found.constraints), ("set", found.values)):
        if values:
            keys[key] = values
    return Study(name, keys)


class _Batch:
    """Parameters that a configuration varies or sets."""

    def __init__(self, target: Target, notes: list[Note]) -> None:
        self._target = target
        self._notes = notes
        self.varied: list[str] = []
        self.constraints: list[str] = []
        self.values: dict[str, str] = {}
        self.runs = 0  # of independent draws; 0 for all combinations

    def set(self, name: str, value: object, place: Sequence[str | int]) -> None:
        """Set a parameter."""
        text = literal(value, self._target.types.get(name, ""))
        if text is None:
            self._refuse(name, place, "set")
        else:
            self.values[name] = text

    def vary(self, variation: Variation, place: Sequence[str | int]) -> None:
        """Vary the parameters of an entry."""
        options = variation.options
        match variation.type, options.get("name"):
            case "ParameterVariationList", str(name):
                self._add(name, listed(options.get("values"), self._type(name)), place)
            case "ParameterVariationList", list(names):
                self._add_together([str(name) for name in names], options.get("values"), place)
            case "ParameterVariationDistributionUniform", str(name):
                self._add(name, bounded(options.get("min"), options.get("max"), self._type(name)), place)
                number = options.get("num_variations")
                self.runs = max(self.runs, 1) * (number if isinstance(number, int) else 1)
            case _:
                why = "it computes parameters or files with Python"
                advice = f"{IN_THE_SCENARIO}, or vary a world: see `docs/how-to/worlds.md`"
                self._notes.append(Note(place, variation.type, why, advice))

    def _type(self, name: str) -> str:
        return self._target.types.get(name, "")

    def _add(self, name: str, found: Range | None, place: Sequence[str | int]) -> None:
        if found is None:
            self._refuse(name, place, "vary")
        else:
            self.varied.append(f"{name} in {found.container}")

    def _add_together(self, names: Sequence[str], values: object, place: Sequence[str | int]) -> None:
        """Vary parameters together: a constraint excludes other combinations."""
        if not isinstance(values, list) or not all(
            isinstance(row, list) and len(row) == len(names) for row in values
        ):
            why = f"expected lists of {len(names)} values"
            self._notes.append(Note(place, f"vary {', '.join(names)}", why, "correct the RoboVAST file"))
            return
        columns = [listed([row[index] for row in values], self._type(name)) for index, name in enumerate(names)]
        for name, column in zip(names, columns, strict=True):
            self._add(name, column, place)
        if None not in columns:
            rows = [
                " and ".join(
                    f"{name} == {literal(value, self._type(name))}" for name, value in zip(names, row, strict=True)
                )
                for row in values
            ]
            self.constraints.append(" or ".join(f"({row})" for row in rows))

    def _refuse(self, name: str, place: Sequence[str | int], verb: str) -> None:
        known = self._target.types.get(name)
        why = f"the scenario has no parameter `{name}`" if known is None else f"`{name}` has another type, {known}"
        self._notes.append(
            Note(place, f"{verb} `{name}`", why, f"{IN_THE_SCENARIO}, as a list or a range of this type")
        )


# ---------------------------------------------------------------- searches


def _of_search(file: VastFile, search: Search, target: Target, stem: str, notes: list[Note]) -> Study:
    notes += search_notes(search)
    direct = without_template(search)
    values: dict[str, str] = {}
    for index, parameters in enumerate(search.parameters):
        for name, value in parameters.items():
            text = literal(value, target.types.get(name, ""))
            if text is None:
                place = ("search", "parameters", index, name)
                notes.append(Note(place, f"set `{name}`", "no such parameter or value", IN_THE_SCENARIO))
            else:
                values[name] = text
    typed = {name: range_of(search.search_space[name], target.types.get(name, "")) for name in direct}
    is_wrapped = bool(search.variations) or None in typed.values() or len(direct) < len(search.search_space)
    keys = _common(file, f"{stem}.osc" if is_wrapped else target.file, stem)
    if search.seed is not None:
        keys["seed"] = search.seed
    keys["strategy"] = search_strategy(search, file.execution.runs, notes)
    for each in search.budget:
        if each.time is not None:
            keys["budget"] = f"{each.time:f}s"
    if not is_wrapped:
        keys["vary"] = [f"{name} in {found.container}" for name, found in typed.items() if found is not None]
        return Study(stem, keys | ({"set": values} if values else {}))
    ranges = {name: _own_range(search, name, notes) for name in search.search_space}
    missing = missing_parameters(search, target.required - values.keys() - ranges.keys(), stem, notes)
    return Study(
        stem,
        keys,
        Wrapper(
            name=re.sub(r"\W", "_", stem),
            scenario=target.name,
            file=target.file,
            ranges={name: found for name, found in ranges.items() if found is not None},
            missing={name: "float" if target.types[name] == "string" else target.types[name] for name in missing},
            given=values,
            types=target.types,
        ),
    )


def _own_range(search: Search, name: str, notes: list[Note]) -> Range | None:
    dimension = search.search_space[name]
    found = range_of(dimension, own_type(dimension))
    if found is None:
        place = ("search", "search_space", name)
        notes.append(Note(place, f"vary `{name}`", "its values are neither numbers nor texts", IN_THE_SCENARIO))
    return found
