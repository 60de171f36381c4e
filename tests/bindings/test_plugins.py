"""Actions of packages for scenario_execution: classes without any base class, found by their entry points."""

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import seoro
from seoro.cli.main import main
from seoro.embed import check_file
from seoro.runtime.verdict import RunStatus, Verdict
from tests.installed_packages import add_entry_points

LIBRARY = """import osc.types

enum mood: [calm, angry]

struct spot:
    place: position_3d
    label: string = 'here'

actor gardener:
    var state: string = 'idle'
    can: float = 2.5

action dig:
    depth: length
    times: int = 3

action gardener.water:
    where: spot
    how: mood = mood!angry
"""
PYTHON = """import enum
from pathlib import Path

LOG = Path(__file__).with_name("log.txt")


class Status(enum.Enum):
    SUCCESS = 1
    FAILURE = 2
    RUNNING = 3
    INVALID = 4


class ActionError(Exception):
    pass


def note(text):
    with LOG.open("a") as file:
        file.write(text + "\\n")


class Dig:
    feedback_message = ""

    def __init__(self, depth):
        self.depth = depth
        self.done = 0

    def setup(self, **kwargs):
        self.logger, self.clock = kwargs["logger"], kwargs["clock"]
        note(f"setup {sorted(kwargs)} {kwargs['tick_period']}")

    def execute(self, times: int):
        self.times = times
        note(f"execute {self.depth} {times}")

    def update(self):
        self.done += 1
        note(f"update at {self.clock.now():.1f}")
        self.feedback_message = f"dug {self.done}"
        return Status.SUCCESS if self.done == self.times else Status.RUNNING

    def shutdown(self):
        self.logger.info("cleaned")
        note(f"shutdown at {self.clock.now():.1f}")


class Water:
    def execute(self, associated_actor, where, how):
        note(f"{associated_actor} {where} {how}")

    def update(self):
        self.blackboard.set("/tom/state", "wet")
        self.status = "success"
"""
MAIN = """import osc.helpers
import osc.garden

scenario main:
    timeout(1min)
    tom: gardener
    do serial:
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Folder of an installed package for scenario_execution with the library `garden`."""
    folder = tmp_path / "site/sx_garden"
    (folder / "lib_osc").mkdir(parents=True)
    (folder / "lib_osc/plants.osc").write_text(LIBRARY)
    (folder / "__init__.py").write_text("")
    (folder / "where.py").write_text("def library():\n    return 'sx_garden', 'plants.osc'\n")
    (folder / "acts.py").write_text(PYTHON)
    add_entry_points(
        folder.parent,
        "sx-garden",
        "[scenario_execution.osc_libraries]\ngarden = sx_garden.where:library\n"
        "[scenario_execution.actions]\ndig = sx_garden.acts:Dig\ngardener.water = sx_garden.acts:Water\n",
    )
    monkeypatch.syspath_prepend(str(folder.parent))
    yield folder
    for name in [name for name in sys.modules if name.partition(".")[0] == "sx_garden"]:
        del sys.modules[name]


async def run(package: Path, body: str) -> tuple[Verdict, list[str]]:
    """Run a body of the scenario on the virtual clock; return its verdict and what the classes noted."""
    file = package.parent.parent / "main.osc"
    file.write_text(MAIN + "".join(f"        {line}\n" for line in body.splitlines()))
    async with seoro.start(seoro.load(file), clock="virtual") as running:
        verdict = await running.result()
    log = package / "log.txt"
    return verdict, log.read_text().splitlines() if log.exists() else []


async def test_a_class_is_updated_ten_times_per_second_until_it_succeeds(package: Path) -> None:
    verdict, log = await run(package, "dig(20cm)\nwait elapsed(1s)")
    assert verdict.passed
    names = "['clock', 'host_clock', 'input_dir', 'logger', 'output_dir', 'tick_period']"
    assert log == [
        f"setup {names} 0.1",
        "execute 0.2 3",
        "update at 0.0",
        "update at 0.1",
        "update at 0.2",
        "shutdown at 0.2",
    ]


async def test_an_actor_reaches_the_class_and_its_variables_the_scenario(package: Path) -> None:
    verdict, log = await run(package, "tom.water(spot(position_3d(x: 1m)))\nwait tom.state == 'wet'\nemit end")
    assert verdict.passed
    assert log[0] == (
        "{'state': 'idle', 'can': 2.5, 'name': 'tom'} "
        "{'place': {'x': 1.0, 'y': 0.0, 'z': 0.0}, 'label': 'here'} ('angry', 1)"
    )


async def test_a_failure_has_the_feedback_of_the_class_and_shuts_it_down(package: Path) -> None:
    module = package / "acts.py"
    module.write_text(module.read_text().replace("return Status.SUCCESS if", "return Status.FAILURE if"))
    verdict, log = await run(package, "dig(20cm, 2)")
    assert verdict.status is RunStatus.FAILED
    assert "`dig` failed: Dig returned FAILURE: dug 2" in verdict.reason
    assert log[-1] == "shutdown at 0.1"


async def test_a_cancelled_class_is_shut_down_at_once(package: Path) -> None:
    verdict, log = await run(package, "one_of:\n    dig(20cm, 1000)\n    wait elapsed(0.25s)\nwait elapsed(5s)")
    assert verdict.passed
    assert log[-2:] == ["update at 0.2", "shutdown at 0.2"]


@pytest.mark.parametrize("method", ["setup", "execute", "update"])
async def test_an_action_error_is_a_failure(method: str, package: Path) -> None:
    module = package / "acts.py"
    text = module.read_text()
    start = text.index(f"def {method}(", text.index("class Dig"))
    place = text.index("\n", start)
    module.write_text(f"{text[:place]}\n        raise ActionError('no spade'){text[place:]}")
    verdict, _ = await run(package, "dig(20cm)")
    assert verdict.status is RunStatus.FAILED
    assert "`dig` failed: no spade" in verdict.reason


async def test_an_exception_in_shutdown_is_an_error_after_a_success(package: Path) -> None:
    module = package / "acts.py"
    module.write_text(module.read_text().replace("self.logger.info", "self.logger.trace"))
    verdict, _ = await run(package, "dig(20cm, 1)")
    assert verdict.status is RunStatus.ERROR
    assert "raised AttributeError: 'Logger' object has no attribute 'trace'" in verdict.reason


async def test_any_other_exception_is_an_error_of_the_test_and_shuts_the_class_down(package: Path) -> None:
    module = package / "acts.py"
    module.write_text(module.read_text().replace("self.done += 1", "self.done += 1 / 0"))
    verdict, log = await run(package, "dig(20cm)")
    assert verdict.status is RunStatus.ERROR
    assert "`dig` raised ZeroDivisionError" in verdict.reason
    assert log[-1].startswith("shutdown")


async def test_what_is_no_status_is_an_error(package: Path) -> None:
    module = package / "acts.py"
    module.write_text(module.read_text().replace("return Status.SUCCESS if", "return 'done' if"))
    verdict, _ = await run(package, "dig(20cm, 1)")
    assert verdict.status is RunStatus.ERROR
    assert "expected one of SUCCESS, FAILURE, RUNNING, INVALID from `update`, found 'done'" in verdict.reason


async def run_blocking(package: Path, old: str, monkeypatch: pytest.MonkeyPatch) -> Verdict:
    """Run with a method that blocks until the end of the run, where it must not keep the process."""
    monkeypatch.setattr("seoro.bindings.plugins.adapter.SHUTDOWN", 0.1)
    module = package / "acts.py"
    text = module.read_text().replace(old, f"RELEASE.wait()\n        {old}")
    module.write_text(
        text.replace("import enum\n", "import enum\nimport threading\nRELEASE = threading.Event()\n")
    )
    file = package.parent.parent / "main.osc"
    file.write_text(f"{MAIN}        one_of:\n            dig(20cm, 1)\n            wait elapsed(0.1s)\n")
    async with seoro.start(seoro.load(file), grace=0.1) as running:
        verdict = await running.result()
    assert all(thread.daemon for thread in threading.enumerate() if thread.name.startswith("seoro"))
    sys.modules["sx_garden.acts"].RELEASE.set()
    return verdict


async def test_a_blocking_update_ends_the_run_as_an_error(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = await run_blocking(package, "self.done += 1", monkeypatch)
    assert verdict.status is RunStatus.ERROR
    assert "the thread of `dig` has not ended 0.2 s after it was cancelled" in verdict.reason
    assert "shutdown at" in (package / "log.txt").read_text()


async def test_a_blocking_shutdown_ends_the_run_as_an_error(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    verdict = await run_blocking(package, 'self.logger.info("cleaned")', monkeypatch)
    assert verdict.status is RunStatus.ERROR
    assert "took longer than 0.2 s" in verdict.reason


@pytest.mark.parametrize(
    ("old", "new", "code", "message"),
    [
        ("self, depth):", "self, deep):", "E0604", "`__init__` takes `deep`; expected parameters of the action"),
        ("self, times: int", "self, count: int", "E0604", "`execute` takes `count`"),
        ("self, times: int", "self", "E0604", "expected `def execute(self, times)`"),
        ("def execute(self, associated_actor, ", "def execute(self, ", "E0604", "self, associated_actor, where"),
        ("import enum\n", "import enum\nimport py_trees_of_nobody\n", "E0601", "install `py_trees_of_nobody`"),
        ("class Dig:", "class Digg:", "E0601", "Dig"),
    ],
)
def test_mismatches_are_found_before_the_run(old: str, new: str, code: str, message: str, package: Path) -> None:
    module = package / "acts.py"
    module.write_text(module.read_text().replace(old, new, 1))
    file = package.parent.parent / "main.osc"
    file.write_text(MAIN + "        dig(20cm)\n        tom.water(spot(position_3d()))\n")
    found = check_file(file).checked.diagnostics
    assert code in {each.code for each in found}
    assert any(message in f"{each.message} {each.help}" for each in found)


def test_the_package_that_declares_an_action_implements_it(package: Path) -> None:
    add_entry_points(package.parent, "other", "[scenario_execution.actions]\ndig = sx_garden.nowhere:Dig\n")
    file = package.parent.parent / "main.osc"
    file.write_text(MAIN + "        dig(20cm)\n")
    assert check_file(file).checked.diagnostics == ()


def test_a_library_file_that_is_missing_is_reported(package: Path) -> None:
    (package / "lib_osc/plants.osc").unlink()
    file = package.parent.parent / "main.osc"
    file.write_text(MAIN + "        dig(20cm)\n")
    found = check_file(file).checked.diagnostics
    assert found[0].code == "E0206"
    assert "no file of the library `osc.garden` at its entry point `sx_garden.where:library`" in found[0].message


def test_a_library_of_a_package_that_is_not_installed_is_found_around_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "setup.py").write_text(
        "setup(entry_points={'scenario_execution.osc_libraries': [\n    'zoo = zoo.where:library',\n]})\n"
    )
    file = tmp_path / "scenarios/main.osc"
    file.parent.mkdir()
    file.write_text("import osc.zoo\nscenario main:\n    do serial:\n        emit end\n")
    found = check_file(file).checked.diagnostics
    assert [each.code for each in found] == ["E0201"]
    assert f"`{tmp_path}` has it for scenario_execution" in found[0].help


def test_a_python_package_that_is_not_installed_is_found_around_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "zoo").mkdir()
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    file = tmp_path / "scenarios/main.osc"
    file.parent.mkdir()
    file.write_text("struct keeper:\n    def count() -> int is external zoo.animals.count()\n")
    found = check_file(file).checked.diagnostics
    assert [each.code for each in found] == ["E0606"]
    assert f"with `pip install {tmp_path}`" in found[0].help


async def test_left_out_parameters_of_a_library_that_seoro_declares_are_none(package: Path) -> None:
    points = package.with_name("sx_garden-1.0.dist-info") / "entry_points.txt"
    points.write_text(points.read_text() + "docker_exec = sx_garden.docker:Exec\n")
    (package / "docker.py").write_text(
        "from sx_garden.acts import Status, note\n"
        "class Exec:\n"
        "    def execute(self, **given):\n"
        "        pass\n"
        "    def __init__(self, container, command, environment, privileged, user, workdir):\n"
        "        note(f'{environment} {privileged} {user} {workdir}')\n"
        "    def update(self):\n"
        "        return Status.SUCCESS\n"
    )
    file = package.parent.parent / "main.osc"
    file.write_text("import osc.docker\nscenario main:\n    do docker_exec('a', 'ls')\n")
    async with seoro.start(seoro.load(file), clock="virtual") as running:
        assert (await running.result()).passed
    assert (package / "log.txt").read_text() == "None False root None\n"


def test_a_declared_action_without_a_package_names_its_replacement(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "main.osc"
    file.write_text("import osc.docker\nscenario main:\n    do docker_exec('a', 'ls')\n")
    assert main(["exec", str(file)]) == 2
    err = capsys.readouterr().err
    assert "write `run_process('docker exec CONTAINER COMMAND')` of `osc.helpers`, or install" in err
