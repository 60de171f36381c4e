"""Start of runs from the form of a scenario."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeVar

import anyio.to_thread
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from seoro.bundle.pack import Bundle
from seoro.client import Client, bundle_of
from seoro.embed.file_settings import with_file_settings
from seoro.embed.options import Leasing, Options, Simulator, options_from
from seoro.embed.scenarios import Scenario, check_file
from seoro.embed.world_settings import split_world
from seoro.errors import CONFLICT, InvalidScenario, SeoroError, UsageError
from seoro.lang.lower.lower import Plans
from seoro.runtime.parameters.parameters import make_entry
from seoro.ui.answers import RequestError, answer, as_request_error, read_object, text_of
from seoro.ui.executors import describe
from seoro.ui.parameters import field_of
from seoro.ui.registry import Known, Run
from seoro.ui.site import Site

SET: Final = "set"  # field with the values of parameters; errors of one name its path
_REAL_TIME: Final = 1.0  # rate of simulators, for viewers
_SEED: Final = 0  # whether values exist does not depend on it

FIELDS: Final = ("place", "file", "scenario", "simulator", "world", "rate", "seed", "timeout", SET)
T = TypeVar("T")


def routes(site: Site) -> list[BaseRoute]:
    """Return the route that starts a run."""

    async def start(request: Request) -> Response:
        run = await start_run(site, await read_object(request, *FIELDS))
        return answer({"run": run.id})

    return [Route("/api/start", start, methods=["POST"])]


async def start_run(site: Site, form: Mapping[str, Any]) -> Run:
    """Start a run from the fields of a form.

    Args:
        site: The site.
        form: Fields `place` and `file`, and those of `prepare`.

    Raises:
        RequestError: A field is invalid; the error names it.
        BackendError: The executor refuses the run, or does not answer.
    """
    with _naming("place"):
        client, executor = site.places.find(text_of(form, "place"))
    path = site.scenarios.path(text_of(form, "file"))
    name, bundle = await anyio.to_thread.run_sync(prepare, path, form)
    await _check_simulator(client, executor, bundle)
    run = await client.submit_bundle(executor, bundle)
    found = describe(run, text_of(form, "place"), name)
    site.runs.update([Known(found, run)])
    return found


def prepare(path: Path, form: Mapping[str, Any]) -> tuple[str, Bundle]:
    """Check a form, and pack its scenario with its files.

    Args:
        path: The scenario file.
        form: Fields: `scenario`, `simulator`, `world`, `rate`, `seed`, `timeout` and `set`, each may be missing.

    Returns:
        The name of the scenario, and the bundle.

    Raises:
        RequestError: A field is invalid; the error names it.
    """
    with _naming("file"):
        scenario = check_file(path, import_python=False, name=text_of(form, "file")).without_errors()
    options = _options(form)
    with _naming("scenario"):
        name = scenario.entry(options.name).name
    settings = _settings(scenario, options)
    if options.simulator is None and settings.simulator is not None:  # named by the file
        options = replace(options, simulator=replace(settings.simulator, rate=_REAL_TIME))
    _check_missing(scenario, settings)
    with _naming(""):
        _check_values(scenario, settings)
        return name, bundle_of(scenario, options)


def _options(form: Mapping[str, Any]) -> Options:
    """Convert the fields of a form."""
    simulator, world = text_of(form, "simulator"), text_of(form, "world")
    rate = _converted(form, "rate", _rate, "a number above 0, or max")
    chosen = None
    if simulator or world or rate is not None:
        chosen = Simulator(simulator or None, world=world or None, rate=_REAL_TIME if rate is None else rate)
    with _naming(""):
        return options_from(
            {
                "name": text_of(form, "scenario") or None,
                "seed": _converted(form, "seed", _whole, "a whole number from 0"),
                "overrides": _overrides(form),
                "simulator": chosen,
                "timeout": _converted(form, "timeout", _number, "seconds above 0"),
                "leasing": Leasing(wait=math.inf),
            }
        )


def _overrides(form: Mapping[str, Any]) -> dict[str, str]:
    found = form.get(SET) or {}
    if not isinstance(found, dict):
        raise RequestError(400, "invalid `set`: expected an object of expressions by path", field=SET)
    for path, text in found.items():
        if not isinstance(text, str):
            raise RequestError(400, f"invalid value of `{path}`: expected an expression", field=path)
    return {path: text.strip() for path, text in found.items() if text.strip()}


def _converted(form: Mapping[str, Any], name: str, convert: Callable[[object], T], expected: str) -> T | None:
    """Convert an optional field; an empty text is a missing one."""
    found = form.get(name)
    if found is None or found == "":
        return None
    try:
        return convert(found)
    except (TypeError, ValueError, OverflowError):
        raise RequestError(400, f"invalid {name}: expected {expected}", field=name) from None


def _whole(value: object) -> int:
    found = int(str(value))
    if found < 0:
        raise ValueError
    return found


def _rate(value: object) -> float:
    return math.inf if value == "max" else _number(value)


def _number(value: object) -> float:
    found = float(str(value))
    if not 0.0 < found < math.inf:
        raise ValueError
    return found


def _settings(scenario: Scenario, options: Options) -> Options:
    """Merge the directives of the file into the options."""
    with _naming(""):
        settings, _ = with_file_settings(scenario, options, "timeout")
    if settings.simulator is not None and settings.simulator.name is None:
        raise RequestError(400, "the world and the rate need a simulator", "choose a simulator", "simulator")
    return settings


def _check_missing(scenario: Scenario, settings: Options) -> None:
    """Check that parameters without a default have a value."""
    with _naming("scenario"):
        missing = Plans(scenario.checked, settings.name).missing_values()
    for path in missing:
        if not any(path == each or path.startswith(f"{each}.") for each in settings.overrides):
            raise RequestError(400, f"missing value of `{path}`", "it has no default", path)


def _check_values(scenario: Scenario, settings: Options) -> None:
    """Check values against the constraints of the scenario."""
    overrides, _ = split_world(settings.overrides)
    plan = scenario.plan(settings.name, overrides, settings.constraints)
    try:
        make_entry(plan, _SEED)
    except UsageError as error:
        if error.code == CONFLICT:  # others may need the Python of the scenario
            raise


async def _check_simulator(client: Client, executor: str, bundle: Bundle) -> None:
    """Check that an executor has the simulator of a bundle."""
    simulator = bundle.manifest.options.simulator
    [status] = await client.describe(executor)
    known = status.info.simulators
    if simulator is not None and simulator.name is not None and known is not None and simulator.name not in known:
        raise RequestError(
            400,
            f"the executor has no simulator `{simulator.name}`",
            f"its simulators: {', '.join(known)}" if known else "install one there: pip install 'seoro[mujoco]'",
            "simulator",
        )


@contextmanager
def _naming(field: str) -> Iterator[None]:
    """Convert errors of a block into those of a field, or of the parameter that they are about."""
    try:
        yield
    except SeoroError as error:
        path = field_of(error)
        found = as_request_error(error, path or field)
        if isinstance(error, InvalidScenario):
            first = error.diagnostics[0]
            span = first.primary.span
            place = "" if path else f"{span.file.name}:{span.line}: "
            raise RequestError(400, f"{place}{first.message}", first.help, found.field) from error
        raise found from error
