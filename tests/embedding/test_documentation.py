"""The examples of `docs/how-to/embed.md` work."""

import os
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from seoro.embed.options import Options

ROOT = Path(__file__).parents[2]
DOCUMENT = ROOT / "docs" / "how-to" / "embed.md"
SERVICE = ROOT / "examples" / "service" / "service.py"
EXAMPLE = re.compile(r"`([\w.]+\.\w+)`:\n\n```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)

# Runs cells in a running loop, like the ipykernel of a notebook.
NOTEBOOK = """
import asyncio
import sys
from pathlib import Path
from IPython.core.interactiveshell import InteractiveShell

async def main():
    shell = InteractiveShell()
    cell = Path("cell.py").read_text()
    transformed = shell.transform_cell(cell)
    assert shell.should_run_async(cell, transformed_cell=transformed)
    result = await shell.run_cell_async(cell, transformed_cell=transformed, store_history=False)
    result.raise_error()
    print(result.result)
    print(shell.user_ns["verdict"].status.value)

asyncio.run(main())
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The files of the document."""
    for name, text in EXAMPLE.findall(DOCUMENT.read_text()):
        (tmp_path / name).write_text(text)
    (tmp_path / "notebook.py").write_text(NOTEBOOK)
    return tmp_path


@pytest.mark.parametrize(
    ("file", "printed"),
    [
        ("script.py", "passed 4.5 s\n"),
        ("program.py", "2.0 round done\n4.0 round done\n6.0 round done\npassed\n"),
        ("many.py", "20 of 20 passed\n"),
        ("ask.py", "arrived at 2.0 s, who is there?\npassed\n"),
        ("notebook.py", "[2.0, 4.0, 6.0]\npassed\n"),
    ],
)
def test_the_example_runs(folder: Path, file: str, printed: str) -> None:
    done = subprocess.run(
        [sys.executable, file],
        cwd=folder,
        env={**os.environ, "IPYTHONDIR": str(folder / "ipython")},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stderr == ""
    assert printed in done.stdout
    assert done.returncode == 0


# A browser that answers, and one that disconnects.
BROWSER = """
from starlette.testclient import TestClient
import web

client = TestClient(web.app)
with client.websocket_connect("/handover") as socket:
    assert socket.receive_json().keys() == {"arrived"}
    socket.send_json({"name": "Ada"})
    print(socket.receive_json())
with client.websocket_connect("/handover") as socket:
    socket.receive_json()
print("disconnected")
"""


def test_a_browser_answers_over_a_websocket(folder: Path) -> None:
    scenario = folder / "handover.osc"
    scenario.write_text(scenario.read_text().replace("elapsed(2s)", "elapsed(1ms)"))
    done = subprocess.run(
        [sys.executable, "-c", BROWSER], cwd=folder, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout == "{'verdict': 'passed'}\ndisconnected\n", done.stderr


def test_a_scenario_with_errors_ends_a_script_with_all_of_them(folder: Path) -> None:
    (folder / "patrol.osc").write_text("scenario patrol:\n    do serial:\n        one()\n        two()\n")
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=folder, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert "patrol.osc:3:9" in done.stderr
    assert "patrol.osc:4:9" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.more
def test_the_examples_have_types(folder: Path) -> None:
    files = ["script.py", "program.py", "many.py", "ask.py", "web.py", str(SERVICE)]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--no-incremental", *files],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def test_every_option_is_documented() -> None:
    text = DOCUMENT.read_text()
    assert [option.name for option in fields(Options) if f"| `{option.name}` |" not in text] == []
