"""Projects with scenario files, and what pytest makes of them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

# A pytest run in this process removes the modules that it imported. Modules of seoro in use must not be among
# them, nor Zenoh, which cannot be imported twice.
import seoro.bridges.launch
import seoro.pytest_plugin.collector
import seoro.runtime.choose.choose  # noqa: F401

HEADER = "import osc.types\nimport osc.helpers\n"
CONFIGURATION = (
    "[pytest]\naddopts = --strict-markers -p no:hypothesispytest\nfilterwarnings = error\n"
    "markers = smoke: some\nasyncio_default_fixture_loop_scope = function\nasyncio_mode = auto\n"
)

Project = Callable[..., pytest.Pytester]


@pytest.fixture
def project(pytester: pytest.Pytester) -> Project:
    """Writes files: `project(main="...", other="...")` are `main.osc` and `other.osc`, below the header."""
    pytester.makefile(".ini", pytest=CONFIGURATION)

    def write(header: str = HEADER, **files: str) -> pytest.Pytester:
        for name, text in files.items():
            path = pytester.path / f"{name}.osc"
            path.write_text(header + text)
        return pytester

    return write
