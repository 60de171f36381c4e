"""A served site with an executor, shared by the tests of a worker."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from anyio.from_thread import start_blocking_portal

from seoro.cli.main import main
from seoro.ui.server import Served, SiteOptions, open_site
from tests.bridges.robot.conftest import all_rails, rails, start_rails
from tests.executors import HELLO, RunningExecutor, executor
from tests.ui.browsing import Browser, opened

__all__ = ["all_rails", "rails", "start_rails"]


@contextmanager
def serving(options: SiteOptions) -> Iterator[Served]:
    """Serve a site in a thread."""
    with start_blocking_portal() as portal, portal.wrap_async_context_manager(open_site(options)) as served:
        yield served


@pytest.fixture(scope="package")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x"), "--jobs", "3") as running:
        yield running


@pytest.fixture(scope="package")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the site."""
    return tmp_path_factory.mktemp("site")


@pytest.fixture(scope="package")
def served(lab: RunningExecutor, folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(SiteOptions((folder,), tmp_path_factory.mktemp("state"), lab.endpoint)) as found:
        yield found


@pytest.fixture
def browser(served: Served) -> Iterator[Browser]:
    with opened(served.access) as found:
        yield found


@pytest.fixture(scope="package")
def hello(folder: Path) -> Path:
    """Folder with the results of a run of this machine."""
    (folder / "hello.osc").write_text(HELLO)
    assert main(["exec", str(folder / "hello.osc"), "-o", str(folder / "results" / "hello")]) == 0
    return folder / "results" / "hello"
