"""A scenario with a library in the folder beside it."""

from pathlib import Path
from typing import Protocol

import pytest

from seoro.embed import Scenario, check_file

GARDEN = """import osc.types
actor gardener
action gardener.water:
    plant: string
    litres: float = 1.5
modifier patiently:
    duration: time
"""
MAIN = "import osc.garden\n\nscenario main:\n    tom: gardener\n    do tom.water('rose')\n"


class Check(Protocol):
    def __call__(self, files: dict[str, str], import_python: bool = True) -> Scenario: ...


@pytest.fixture
def check_files(tmp_path: Path) -> Check:
    """Checks `main.osc` among files by their paths."""

    def check(files: dict[str, str], import_python: bool = True) -> Scenario:
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return check_file(tmp_path / "main.osc", import_python=import_python)

    return check


class CheckGarden(Protocol):
    def __call__(self, python: str | None) -> list[tuple[str, str]]: ...


@pytest.fixture
def check_garden(check_files: Check) -> CheckGarden:
    """Codes and texts of the messages about the library `garden` with this Python module, or none."""

    def check(python: str | None) -> list[tuple[str, str]]:
        files = {"main.osc": MAIN, "seoro.libraries/garden.osc": GARDEN}
        if python is not None:
            files["seoro.libraries/garden.py"] = f"from seoro import *\n\n{python}\n"
        return [(found.code, f"{found.message}\n{found.help}") for found in check_files(files).checked.diagnostics]

    return check
