"""Pages of a served site in Chromium."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from seoro.ui.security import Access
from tests.chromium import problems_of

if TYPE_CHECKING:
    from playwright.async_api import Browser, Locator, Page


class Opened:
    """A page.

    Args:
        page: The page.
        origin: Address of the site.
        problems: Errors of the page, and requests that left the site.
    """

    def __init__(self, page: Page, origin: str, problems: list[str]) -> None:
        self.page = page
        self.origin = origin
        self.problems = problems

    async def go(self, path: str) -> None:
        """Go to a path, as a link does."""
        await self.page.evaluate(
            "path => { history.pushState(null, '', path); dispatchEvent(new Event('popstate')) }", path
        )

    async def tab(self, name: str) -> str:
        """Open a tab of a run; returns its text."""
        await self.page.get_by_role("tab", name=name, exact=True).click()
        return await self.page.get_by_role("tabpanel").inner_text()

    async def width(self) -> int:
        """Return the width of the content [px]."""
        return int(await self.page.evaluate("document.documentElement.scrollWidth"))


@asynccontextmanager
async def opened(browser: Browser, access: Access, *, width: int = 1280, **options: Any) -> AsyncIterator[Opened]:
    """Open the URL of a site in a new context.

    Args:
        browser: Browser.
        access: Address and secrets of the site.
        width: Width of the page [px].
        options: Options of the context.
    """
    origin = access.url.partition("/?")[0]
    context = await browser.new_context(viewport={"width": width, "height": 800}, **options)
    try:
        page = await context.new_page()
        problems = problems_of(page)
        page.on("request", lambda request: _note(problems, request.url, origin))
        await page.goto(access.url)
        await page.locator("html[data-ready]").wait_for(state="attached")
        yield Opened(page, origin, problems)
    finally:
        await context.close()


def _note(problems: list[str], url: str, origin: str) -> None:
    if not url.startswith((f"{origin}/", "data:", "blob:")):
        problems.append(f"request to {url}")


async def shows(place: Locator, text: str) -> None:
    """Wait until a place of the page has a text, on a busy machine, too."""
    from playwright.async_api import expect

    await expect(place).to_contain_text(text, timeout=30_000)
