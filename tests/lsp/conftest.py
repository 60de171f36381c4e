"""An editor with a started server."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import pytest_asyncio

from tests.language_servers import Editor


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def editor(tmp_path_factory: Any) -> AsyncIterator[Editor]:
    """Yield an editor whose server has started."""
    made = Editor(tmp_path_factory.mktemp("workspace").resolve())
    await made.start()
    yield made
    await made.stop()
