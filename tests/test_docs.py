"""The examples of the documentation have the shown results."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.tools.code_blocks import Block, blocks_in, commands_in, is_covered, matches

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [
    *sorted(DOCS.rglob("*.md")),
    *(ROOT / f"{name}.md" for name in ("README", "ARCHITECTURE", "CONTRIBUTING")),
]
IN_PROCESSES = ("sim", "test")  # `sim` replaces its process; tests of several pages have the same names
LINKED = ("scenarios", "examples", "benchmarks")  # folders of the repository that commands name


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def write(block: Block) -> None:
    path = Path(block.name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(block.text)


def run(command: str, capfd: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Run a command of a console block, and return its exit status, stdout and stderr."""
    capfd.readouterr()
    program, *arguments = shlex.split(command, comments=True)
    if program == "seoro" and arguments[0] not in IN_PROCESSES:
        try:
            status = main(arguments)
        except SystemExit as end:
            status = int(end.code or 0)
        return status, *capfd.readouterr()
    words = {
        "python": [sys.executable],
        "pytest": [sys.executable, "-m", "pytest", "-p", "no:cacheprovider"],
        "seoro": [sys.executable, "-m", "seoro"],
    }
    done = subprocess.run([*words[program], *arguments], capture_output=True, text=True, timeout=120, check=False)
    return done.returncode, done.stdout, done.stderr


def execute(
    page: Path, block: Block, number: int, names: dict[str, object], capfd: pytest.CaptureFixture[str]
) -> str:
    """Execute a block; returns what a program has printed."""
    where = f"{name_of(page)}:{block.line}"
    if block.language == "osc":
        file = Path(block.name or f"block_{number}.osc")
        if file.parent == Path():
            file.write_text(block.text)
            status = main(["check", str(file)])
            assert (status != 0) == block.has_errors, f"{where}: {capfd.readouterr().err}"
    elif block.language == "console":
        for command, shown in commands_in(block):
            status, out, err = run(command, capfd)
            assert status == block.status, f"{where}: `{command}` has the status {status}:\n{out}{err}"
            is_shown = not shown or any(matches(shown, printed) for printed in (out, err, out + err))
            assert is_shown, f"{where}: `{command}` printed:\n{out}{err}"
    elif block.language == "python" and not block.name:
        capfd.readouterr()
        exec(compile(block.text, where, "exec"), names)
        return capfd.readouterr().out
    return ""


def play(page: Path, folder: Path, capfd: pytest.CaptureFixture[str], with_simulators: bool) -> None:
    """Execute the blocks of a page in a folder, in their order."""
    for linked in LINKED:
        (folder / linked).symlink_to(ROOT / linked)
    names: dict[str, object] = {"__name__": "examples"}
    printed, is_executed = "", False
    blocks = [block for block in blocks_in(page) if not block.reason]
    for block in blocks:
        if block.name:
            write(block)
    for number, block in enumerate(blocks):
        if block.language == "text" and is_executed:
            assert printed == block.text, f"{name_of(page)}:{block.line}"
        is_executed = block.language == "python" and not block.name
        if with_simulators or not block.needs_simulator:
            printed = execute(page, block, number, names, capfd)


EXECUTED = [page for page in PAGES if any(not block.reason for block in blocks_in(page))]
SIMULATED = [
    page for page in PAGES if any(block.needs_simulator and not block.reason for block in blocks_in(page))
]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_code_block_is_executed_or_has_a_reason(page: Path) -> None:
    before, uncovered = None, []
    for block in blocks_in(page):
        if not is_covered(block, before):
            uncovered.append(f"{name_of(page)}:{block.line}: ```{block.language}")
        before = block
    assert uncovered == []


@pytest.mark.parametrize("page", EXECUTED, ids=name_of)
def test_code_blocks_of_a_page_have_the_shown_output(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    play(page, tmp_path, capfd, with_simulators=False)


@pytest.mark.more
@pytest.mark.engine("mujoco")
@pytest.mark.parametrize("page", SIMULATED, ids=name_of)
def test_code_blocks_with_a_simulator_have_the_shown_output(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    play(page, tmp_path, capfd, with_simulators=True)


def test_the_tutorial_has_five_steps_that_lead_to_each_other_and_end_with_a_picture() -> None:
    index = (DOCS / "index.md").read_text()
    steps = re.findall(r"^\d\. \[[^]]+\]\(tutorial/(\w+)\.md\)$", index, re.MULTILINE)
    assert len(steps) == 5
    assert "\n".join(f"tutorial/{step}" for step in steps) in index
    for number, step in enumerate(steps, start=1):
        page = (DOCS / "tutorial" / f"{step}.md").read_text()
        assert page.split("\n\n", maxsplit=1)[1].startswith(f"**Step {number} of 5.** After it you have ")
        assert re.search(rf"!\[[^]]+\]\(\.\./images/(first_drive|{step})\.png\)", page)
        if number < 5:
            assert re.search(rf"Next: \[step {number + 1}, [^]]+\]\({steps[number]}\.md\)", page)


def test_the_page_about_the_kernel_is_short() -> None:
    text = re.sub(
        r"^```.*?^```$", "", (DOCS / "explanation/kernel.md").read_text(), flags=re.MULTILINE | re.DOTALL
    )
    assert len(text.split()) <= 600


@pytest.mark.parametrize("name", ["parallel", "wait"])
def test_the_architecture_quotes_current_behaviors(name: str) -> None:
    source = Path(f"seoro/runtime/behaviors/{name}.py").read_text()
    function = source[source.index(f"async def run_{name}(") :].rstrip()
    assert f"```python\n{function}\n```" in Path("ARCHITECTURE.md").read_text()


def test_the_architecture_describes_the_runtime_in_few_words() -> None:
    text = Path("ARCHITECTURE.md").read_text().partition("### `seoro/runtime`")[2].partition("\n### ")[0]
    assert len(re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL).split()) <= 300
