"""State that all areas of the pages share."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from anyio.abc import TaskGroup

from seoro.client import Client
from seoro.lab.reading import Lab
from seoro.ui.feeds import Feeds
from seoro.ui.own_runs import OwnRuns
from seoro.ui.places import Places
from seoro.ui.registry import RunRegistry
from seoro.ui.rights import Rights
from seoro.ui.scenario_files import ScenarioFiles


@dataclass(frozen=True)
class Site:
    """State that all areas of the pages share.

    Args:
        folders: Folders with runs, scenarios and campaigns; absolute.
        state: Folder for runs that the site starts, in the folder for the state of this user.
        keys: Folder of keys; None for that of the environment or of the user.
        places: Executors.
        runs: Known runs, by id.
        feeds: Traces of viewed runs.
        scenarios: Scenario files below the folders.
        tasks: Task group that lasts as long as the site.
        lab: Lab file, if any.
        is_demo: Whether the site shows its own examples.
        rights: Rights of its users.
        own_runs: Runs in child processes of the site.
    """

    folders: tuple[Path, ...]
    state: Path
    keys: Path | None
    places: Places
    runs: RunRegistry
    feeds: Feeds
    scenarios: ScenarioFiles
    tasks: TaskGroup
    lab: Lab | None = None
    is_demo: bool = False
    rights: Rights = field(default_factory=Rights)
    own_runs: OwnRuns = field(default_factory=OwnRuns)

    def client(self) -> Client:
        """Return an open client of the executors.

        Raises:
            BackendUnreachable: No executor was reached yet; the message has the reason.
        """
        return self.places.client()

    def start_soon(self, function: Callable[..., Coroutine[Any, Any, Any]], *arguments: Any) -> None:
        """Start a background task, which is cancelled at the end of the site."""
        self.tasks.start_soon(function, *arguments)
