"""Files, commands and options that the documentation names exist, or the page itself shows how they come about."""

from __future__ import annotations

import argparse
import inspect
import re
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import seoro
from seoro import ActionContext, Client, MethodContext, ModifierContext, Run, ThreadContext, Verdict
from seoro.cli.commands import COMMANDS
from seoro.cli.main import command_parser
from seoro.client.lab import LabControl
from seoro.client.runs import RemoteRun

ROOT = Path(__file__).parents[1]
PAGES = [
    *sorted((ROOT / "docs").rglob("*.md")),
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "ARCHITECTURE.md",
]
SUFFIXES = "osc|py|yaml|yml|md|sdf|urdf|xml|jsonl|json|mcap|csv|mp4|png|pgm|sh|snapshot|lark|toml"
FILE = re.compile(rf"(?<![\w$*{{=:%/.~-])[\w./~-]*\w\.(?:{SUFFIXES})\b(?!\w)")
BLOCK = re.compile(r"^ *```(\w*)[^\n]*\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
SHOWN = re.compile(r"`([\w./-]+)`(?:\s*\([^)]*\))?[:,]?\n+ *```")
WRITTEN = re.compile(r"(?:--trace|--record-video|--junit|--perfetto|-o|--output|>)[ =]([\w./-]+)")
OUTPUTS = frozenset(
    {
        *("trace.jsonl", "measurements.json", "top_down.png", "test.xml", "coverage.json", "results.csv"),
        *("log.txt", "video.mp4", "audit.jsonl", "trajectories.csv", "joint_trajectories.csv"),
        *("recording.mcap", "foxglove-layout.json", "shared.jsonl"),
        *("runs.csv", "asked.jsonl", "campaign.json"),  # of campaigns
        "metadata.yaml",  # of bags, by rosbag2
    }
)
EXAMPLES = {  # names that only illustrate a rule
    "CONTRIBUTING.md": {"name.osc", "name.invalid.osc"},
    "docs/explanation/measurements.md": {"localisation.csv"},
    "docs/how-to/edit.md": {"source.osc"},  # a scope of TextMate
    "docs/how-to/libraries.md": {"garden.osc", "garden.py", "garden/garden.osc", "garden/__init__.py", "view.png"},
    "docs/how-to/projects.md": {"warehouse/scenarios/deliver.osc"},  # made by a command
    "docs/how-to/pytest.md": {"far.yaml"},
    "docs/how-to/simulate.md": {"name.png"},
    "docs/how-to/worlds.md": {"garden/pots/small.sdf"},
    "docs/tutorial/many_runs.md": {
        *("warehouse/scenarios/deliver.osc", "warehouse/.github/workflows/scenarios.yml"),  # made by a command
        "warehouse/seoro.toml",
    },
}
OTHERS = frozenset(  # options of other programs
    {
        *("--lf", "--ff", "--sw", "--nf", "--co", "--junitxml", "--collect-only", "--tb"),
        *("--upgrade", "--editable", "--system", "--build", "--rm"),
    }
)


@cache
def repository() -> frozenset[str]:
    """Return the paths of all files, and all endings of these at a folder."""
    skipped = {".git", ".venv", "__pycache__", "build", "dist"}
    found: set[str] = set()
    for path in ROOT.rglob("*"):
        parts = path.relative_to(ROOT).parts
        if not skipped & set(parts) and path.is_file():
            found.update("/".join(parts[i:]) for i in range(len(parts)))
    return frozenset(found)


def commands(text: str) -> Iterator[str]:
    """Yield the command lines of `seoro` in the blocks of a page."""
    for language, body in BLOCK.findall(text):
        if language in ("", "sh", "bash", "console", "text"):
            for line in body.replace("\\\n", " ").splitlines():
                found = re.match(r"\s*(?:\$ )?(?:[A-Z_]+=\S+ )*(seoro .*)", line)
                if found:
                    yield found[1]


def spans(text: str) -> list[str]:
    """Return the code spans outside of blocks."""
    return re.findall(r"(?<!`)`([^`\n]+)`(?!`)", BLOCK.sub("\n", text))


def links(text: str) -> list[str]:
    """Return the targets of links to files."""
    found = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", BLOCK.sub("\n", text))
    return [target for target in found if "://" not in target]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_files_in_pages_exist(page: Path) -> None:
    text, name = page.read_text(), page.relative_to(ROOT).as_posix()
    broken = [target for target in links(text) if not (page.parent / target).exists()]
    assert not broken, "links to files that do not exist"
    made = {*SHOWN.findall(text), *EXAMPLES.get(name, ())}
    written = tuple(path.removesuffix("/") for path in WRITTEN.findall(text))
    named = {file for line in (*commands(text), *spans(text)) for file in FILE.findall(line.partition(" # ")[0])}
    unknown = []
    for file in sorted(named):
        is_written = Path(file).name in OUTPUTS or any(f"{file}/".startswith(f"{path}/") for path in written)
        is_placeholder = re.search(r"\b[A-Z]{2,}\b", file) is not None
        if not (
            file.removeprefix("./").lstrip("./") in repository() or file in made or is_written or is_placeholder
        ):
            unknown.append(file)
    assert not unknown, "files that neither exist nor are shown by the page"


def test_examples_are_still_used() -> None:
    for name, examples in EXAMPLES.items():
        text = (ROOT / name).read_text()
        assert not [example for example in examples if example not in text]


@cache
def options_of(command: str) -> frozenset[str]:
    """Return the options of a command and of all commands below it."""

    def walk(parser: argparse.ArgumentParser) -> Iterator[str]:
        for action in parser._actions:
            yield from action.option_strings
            if isinstance(action, argparse._SubParsersAction):
                for below in action.choices.values():
                    yield from walk(below)

    parser = command_parser([command])
    [commands] = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
    return frozenset((*walk(commands.choices[command]), "--version"))


@cache
def subcommands_of(command: str) -> frozenset[str]:
    """Return the names of the commands directly below a command."""
    parser = command_parser([command])
    [commands] = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
    below = [each for each in commands.choices[command]._actions if isinstance(each, argparse._SubParsersAction)]
    return frozenset(name for action in below for name in action.choices)


def unknown_options(line: str) -> list[str]:
    """Return the commands and options of a command line that do not exist."""
    try:
        words = shlex.split(line, comments=True)
    except ValueError:  # a quote that the page leaves open
        words = line.split()
    if len(words) < 2 or words[1].startswith("-") or not words[1].islower():
        return []
    command = {"run": "exec", "help": "exec"}.get(words[1], words[1])
    if command not in COMMANDS:
        return [command]
    given = [word.partition("=")[0] for word in words[2:] if re.match(r"--[a-z]", word)]
    unknown = [option for option in given if option not in options_of(command)]
    if len(words) > 2 and re.fullmatch(r"[a-z]+", words[2]) and (below := subcommands_of(command)):
        unknown += sorted({words[2]} - below)
    return unknown


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_commands_and_options_in_pages_exist(page: Path) -> None:
    text = page.read_text()
    lines = [*commands(text), *(span for span in spans(text) if span.startswith("seoro "))]
    assert not {line: found for line in lines if (found := unknown_options(line))}
    known = OTHERS.union(*map(options_of, COMMANDS), PLUGIN, PROGRAMS)
    named = {
        span.split()[0].partition("=")[0]
        for span in spans(text)
        if re.fullmatch(r"--[a-z][\w-]+", re.split(r"[ =]", span)[0])
    }
    assert not sorted(named - known), "options of no command"


NO_MEMBERS = frozenset(
    {"run.start", "run.end", "seoro.libraries", "seoro.models", "seoro.engines", "seoro.navigation"}
)  # not of Python
MEMBERS = {
    "ctx": (ActionContext, ThreadContext, ModifierContext),
    "run": (Run, RemoteRun, MethodContext),
    "client": (Client,),
    "lab": (LabControl,),
    "verdict": (Verdict,),
    "seoro": (seoro,),
    "Verdict": (Verdict,),
    "ActionContext": (ActionContext,),
    "Run": (Run,),
}


def members_of(owner: object) -> set[str]:
    """Return the names of the attributes of a class or module, fields of its instances included."""
    assigned = (
        re.findall(r"self\.(\w+)(?::[^=\n]+)? =", inspect.getsource(owner)) if isinstance(owner, type) else ()
    )
    return {*dir(owner), *assigned, *getattr(owner, "__annotations__", ())}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_members_of_the_library_in_pages_exist(page: Path) -> None:
    text = page.read_text()
    blocks = [body for language, body in BLOCK.findall(text) if language == "python"]
    unknown = set()
    for part in (*spans(text), *blocks):
        for name, member in re.findall(r"(?<![\w./\"'@-])(\w+)\.([a-zA-Z]\w*)(?![\w/-])", part):
            owners = MEMBERS.get(name, ())
            is_module = name == "seoro" and (ROOT / "seoro" / member).is_dir()
            if owners and not is_module and not any(member in members_of(owner) for owner in owners):
                unknown.add(f"{name}.{member}")
    files = {name for name in unknown if FILE.fullmatch(name)}
    assert not sorted(unknown - files - NO_MEMBERS), "members that do not exist"


@cache
def _options_in(folder: Path) -> frozenset[str]:
    text = "\n".join(path.read_text() for path in folder.rglob("*.py"))
    return frozenset(re.findall(r"\"(--[a-z][\w-]+)\"", text))


PLUGIN = _options_in(ROOT / "seoro" / "pytest_plugin")
PROGRAMS = _options_in(ROOT / "sim_nodes") | _options_in(ROOT / "benchmarks")


def test_options_in_help_texts_exist() -> None:
    for command in COMMANDS:
        parser = command_parser([command])
        [below] = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
        examples = below.choices[command].epilog or ""
        lines = [line.strip() for line in examples.splitlines() if line.strip().startswith("seoro ")]
        assert not {line: found for line in lines if (found := unknown_options(line))}
