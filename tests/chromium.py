"""Chromium for tests of pages."""

from __future__ import annotations

import os
import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.async_api import Browser, ConsoleMessage, Page

CHROMIUM = os.environ.get("SEORO_CHROMIUM") or shutil.which("chromium")


@asynccontextmanager
async def launched() -> AsyncIterator[Browser]:
    """Launch a browser while the block lasts. Without an installed one, the test is skipped."""
    if CHROMIUM is None or find_spec("playwright") is None:
        pytest.skip("needs Chromium, such as `apt-get install chromium`, and the Python package playwright")
    from playwright.async_api import async_playwright

    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        await browser.close()


def problems_of(page: Page) -> list[str]:
    """Return the list to which errors of a page are added."""
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda message: problems.append(message.text) if _is_problem(message) else None)
    return problems


def _is_problem(message: ConsoleMessage) -> bool:
    """Return whether a message is an error of the page, and not of a request, which the page shows itself."""
    return message.type == "error" and not message.text.startswith(("Failed to load", "WebSocket connection"))


async def violations_of(page: Page) -> list[tuple[str, str]]:
    """Return violations of accessibility that axe finds: rule, and HTML of the first element."""
    axe = pytest.importorskip("axe_playwright_python.base").AXE_FILE_PATH
    if not await page.evaluate("'axe' in window"):
        await page.evaluate(axe.read_text())
    found = await page.evaluate("axe.run()")
    return [(rule["id"], rule["nodes"][0]["html"]) for rule in found["violations"]]
