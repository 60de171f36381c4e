"""A browser for reports."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from seoro.cli.report_command import write_file
from seoro.runtime.execution.outputs import TRACE
from tests.chromium import launched, problems_of
from tests.report.traces import records, write

if TYPE_CHECKING:
    from playwright.async_api import Browser, Page


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browser() -> AsyncIterator[Browser]:
    async with launched() as browser:
        yield browser


class Opened:
    """A report in a browser.

    Args:
        page: The page.
        problems: Errors of the page, and requests that left it.
    """

    def __init__(self, page: Page, problems: list[str]) -> None:
        self.page = page
        self.problems = problems

    async def tab(self, name: str) -> str:
        """Open a tab; returns its text."""
        await self.page.get_by_role("tab", name=name, exact=True).click()
        return await self.page.get_by_role("tabpanel").inner_text()

    async def set_time(self, time: float) -> None:
        field = self.page.get_by_label("Time in seconds")
        await field.fill(str(time))
        await field.press("Enter")


@pytest_asyncio.fixture(loop_scope="module")
async def open_report(browser: Browser) -> AsyncIterator[Callable[..., Awaitable[Opened]]]:
    opened: list[Page] = []

    async def open_file(path: Path, *, width: int = 1280, dark: bool = False, script: bool = True) -> Opened:
        page = await browser.new_page(
            viewport={"width": width, "height": 800},
            color_scheme="dark" if dark else "light",
            java_script_enabled=script,
        )
        opened.append(page)
        problems = problems_of(page)
        page.on("request", lambda request: None if request.url == path.as_uri() else problems.append(request.url))
        await page.goto(path.as_uri())
        if script:
            await page.locator("html[data-ready]").wait_for(state="attached")
        return Opened(page, problems)

    yield open_file
    for page in opened:
        await page.close()


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a run that fails."""
    folder = tmp_path_factory.mktemp("out")
    write(folder, records())
    write_file(str(folder / TRACE), folder, folder / "report.html")
    return folder / "report.html"
