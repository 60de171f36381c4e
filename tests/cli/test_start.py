"""Modules that `seoro exec` loads for a short scenario; each takes about half a millisecond."""

import os
import subprocess
import sys

import pytest

HELLO = 'import osc.helpers\nscenario hello:\n    do serial:\n        log("hello")\n'
MOST_MODULES = 300  # of a run whose plan is cached
MOST_MODULES_FIRST = 395  # of the first run of a file
HEAVY = {
    "anyio",
    "bz2",
    "cryptography",
    "datetime",
    "email",
    "getpass",
    "hmac",
    "importlib.metadata",
    "lzma",
    "msgpack",
    "multiprocessing",
    "numpy",
    "pydantic",
    "rich",
    "shutil",
    "starlette",
    "tempfile",
    "uvicorn",
    "xml",
    "yaml",
    "zenoh",
    "seoro.actions.processes",
    "seoro.client",
    "seoro.executor",
    "seoro.security.keys.folder",
    "seoro.lang.ast",
    "seoro.lang.check",
    "seoro.lang.diagnostic",
    "seoro.lang.parser",
    "seoro.runtime.accept",
    "seoro.runtime.trace.jsonl",
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[set[str]]:
    """Modules that the first two runs of a scenario load; the second has a cached plan."""
    folder = tmp_path_factory.mktemp("start")
    file = folder / "hello.osc"
    file.write_text(HELLO)
    code = (
        "import sys; before = set(sys.modules); from seoro.cli.main import main; main(sys.argv[1:]); "
        "print(*(set(sys.modules) - before), file=sys.stderr)"
    )
    command = [sys.executable, "-c", code, "exec", str(file)]
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    return [
        set(subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stderr.split())
        for _ in range(2)
    ]


def test_short_runs_load_few_modules(runs: list[set[str]]) -> None:
    first, repeated = runs
    assert len(first) <= MOST_MODULES_FIRST, sorted(first)
    assert len(repeated) <= MOST_MODULES, sorted(repeated)


def test_a_repeated_run_loads_nothing_that_it_does_not_use(runs: list[set[str]]) -> None:
    assert sorted(HEAVY & runs[1]) == []


def test_the_help_loads_neither_an_event_loop_nor_plans() -> None:
    code = (
        "import sys; sys.argv[1:] = ['--help']\nfrom seoro.cli.main import main\n"
        "try:\n    main()\nexcept SystemExit:\n    print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {"asyncio", "seoro.lang.plan", "seoro.runtime.verdict", "pydantic"} & set(done.stderr.split()) == set()
