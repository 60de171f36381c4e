"""Settings that directives of a scenario file give to a run, and the options that go before them."""

import math
from pathlib import Path

import pytest

import seoro
from seoro.bundle.pack import pack
from seoro.bundle.unpack import limit_of
from seoro.embed import check_file
from seoro.embed.file_settings import FileSettings, settings_of_file, with_file_settings
from seoro.embed.options import Lab, Options, Ros, Simulator
from seoro.embed.time_limit import Source
from seoro.errors import UsageError
from seoro.runtime.verdict import RunStatus

SCENARIO = "scenario main:\n    do wait elapsed(1s)\n"


NAMES = {
    "lab": "--lab",
    "snapshot": "--from-snapshot",
    "ros": "--ros",
    "clock": "--clock virtual",
    "timeout": "--timeout SECONDS",
}


def settings(
    tmp_path: Path, directives: str, given: Options, *, world: str | None = None, repeats: bool = False
) -> FileSettings:
    return settings_of_file(checked(tmp_path, directives), given, NAMES, world=world, repeats=repeats)


def checked(tmp_path: Path, directives: str):  # type: ignore[no-untyped-def]
    (tmp_path / "hall.yaml").write_text("")
    file = tmp_path / "test.osc"
    file.write_text(f"import osc.types\n\n{directives}{SCENARIO}")
    return check_file(file).without_errors()


ALL = "# seoro: simulators mujoco\n# seoro: world hall.yaml\n# seoro: seed 7\n# seoro: timeout 9s\n"


def test_directives_supply_missing_options(tmp_path: Path) -> None:
    found = settings(tmp_path, ALL, Options())
    assert (found.simulator, found.world) == ("mujoco", str(tmp_path / "hall.yaml"))
    assert (found.seed, found.limit.seconds, found.notes) == (7, 9.0, [])


def test_options_go_before_directives(tmp_path: Path) -> None:
    found = settings(tmp_path, ALL, Options(simulator=Simulator("pybullet", world="maze"), seed=0, timeout=1.0))
    assert (found.simulator, found.world, found.seed, found.limit.seconds) == ("pybullet", "maze", 0, 1.0)
    assert [note.partition(": ")[2] for note in found.notes] == [
        "this run uses pybullet instead of its simulator mujoco"
    ]


def test_options_replace_values_of_directives_also_by_those_of_a_whole(tmp_path: Path) -> None:
    file = tmp_path / "test.osc"
    file.write_text(
        "import osc.types\n# seoro: set a=1\n# seoro: set b=2\n# seoro: set at.x=3m\n"
        "scenario main:\n    a: int\n    b: int\n    at: position_3d\n    do wait elapsed(1s)\n"
    )
    (tmp_path / "values.yaml").write_text("main: {b: 4}\n")
    scenario = check_file(file).without_errors()
    options = Options(overrides={"at": "position_3d(x: 1m)"}, parameters=tmp_path / "values.yaml")
    assert settings_of_file(scenario, options, NAMES).overrides == {"a": "1"}
    found, _ = with_file_settings(scenario, Options(overrides={"b": "5"}), "timeout=SECONDS")
    assert found.overrides == {"a": "1", "b": "5", "at.x": "3m"}


@pytest.mark.parametrize(
    ("target", "options"),
    [
        ("lab", Options(lab=Lab("lab.yaml"))),
        ("snapshot", Options(simulator=Simulator(snapshot="s"))),
        ("ros", Options(ros=Ros("tcp/[::1]:1"))),
        ("clock", Options(clock="virtual")),
    ],
)
def test_a_target_without_worlds_replaces_the_simulator_with_a_note(
    tmp_path: Path, target: str, options: Options
) -> None:
    found = settings(tmp_path, ALL, options)
    assert (found.simulator, found.world) == (None, None)
    assert all(f"`{NAMES[target]}` replaces its" in note for note in found.notes)
    assert len(found.notes) == 2


def test_a_running_simulator_loads_the_world_of_the_file(tmp_path: Path) -> None:
    found = settings(tmp_path, ALL, Options(simulator=Simulator(endpoint="tcp/[::1]:1")))
    assert (found.simulator, found.world) == (None, str(tmp_path / "hall.yaml"))


def test_a_world_of_the_user_is_for_the_simulator_of_the_file(tmp_path: Path) -> None:
    found = settings(tmp_path, ALL, Options(), world="maze")
    assert (found.simulator, found.world) == ("mujoco", "maze")
    assert settings(tmp_path, ALL, Options(clock="virtual"), world="maze").simulator is None


def test_a_world_without_a_simulator_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="the run has no simulator"):
        settings(tmp_path, "# seoro: world maze\n", Options())


def test_a_single_run_uses_the_first_seed_and_simulator_with_notes(tmp_path: Path) -> None:
    directives = "# seoro: simulators mujoco, pybullet\n# seoro: seed 4, 5\n"
    found = settings(tmp_path, directives, Options())
    assert (found.simulator, found.seed, found.seeds) == ("mujoco", 4, (4, 5))
    assert [note.partition(": ")[2] for note in found.notes] == [
        "this run uses mujoco of its simulators mujoco, pybullet",
        "this run uses seed 4 of 4, 5",
    ]
    assert len(settings(tmp_path, directives, Options(), repeats=True).notes) == 1


def test_parameters_that_only_tests_vary_are_noted_unless_given(tmp_path: Path) -> None:
    directives = "# seoro: parametrize speed=[1mps]\n"
    assert "varies the parameter speed" in settings(tmp_path, directives, Options()).notes[0]
    assert settings(tmp_path, directives, Options(overrides={"speed": "1mps"})).notes == []


def test_directives_of_the_chosen_scenario_apply(tmp_path: Path) -> None:
    file = tmp_path / "two.osc"
    file.write_text(
        f"# seoro: seed 1\n\nimport osc.types\n# seoro: seed 2\nscenario other:\n    do main()\n{SCENARIO}"
    )
    both = check_file(file).without_errors()
    assert settings_of_file(both, Options(name="main"), NAMES).seed == 1
    assert settings_of_file(both, Options(name="other"), NAMES).seed == 2


@pytest.mark.parametrize(
    ("options", "simulator"),
    [
        (Options(), Simulator(name="mujoco", world="hall.yaml")),
        (
            Options(simulator=Simulator(name="pybullet", rate=2.0)),
            Simulator("pybullet", world="hall.yaml", rate=2.0),
        ),
        (Options(simulator=Simulator(endpoint="tcp/[::1]:1")), Simulator(None, "tcp/[::1]:1", "hall.yaml")),
        (Options(simulator=Simulator(snapshot=Path("s"))), Simulator(snapshot=Path("s"))),
        (Options(lab=Lab(Path("lab.yaml"))), None),
        (Options(ros=Ros("tcp/[::1]:1")), None),
        (Options(clock="virtual"), None),
    ],
)
def test_programs_get_the_simulator_and_world_of_the_file(
    tmp_path: Path, options: Options, simulator: Simulator | None
) -> None:
    found, _ = with_file_settings(checked(tmp_path, ALL), options, "timeout=SECONDS")
    expected = simulator
    if simulator is not None and simulator.world is not None:
        expected = Simulator(simulator.name, simulator.endpoint, str(tmp_path / "hall.yaml"), simulator.rate)
    assert found.simulator == expected
    assert found.seed == 7


def test_the_limit_of_wall_time_names_its_source(tmp_path: Path) -> None:
    file = settings(tmp_path, ALL, Options()).limit
    option = settings(tmp_path, ALL, Options(timeout=1.0)).limit
    default = settings(tmp_path, "", Options()).limit
    assert (file.source, option.source, default.source) == (Source.FILE, Source.CALLER, Source.DEFAULT)
    assert file.reason == "no verdict within 9 s of wall time (`# seoro: timeout` in the file)"
    assert option.reason == "no verdict within 1 s of wall time (`--timeout SECONDS`)"
    assert default.seconds == 3600.0
    assert "`--timeout SECONDS` raises it" in default.reason
    for limit in (file, option, default):
        packed = pack(check_file(tmp_path / "test.osc").without_errors(), Options(), limit)
        assert limit_of(packed.manifest.options) == limit, "executors name the same source"


WAITING = """# seoro: timeout 0.05s
import osc.helpers

scenario main:
    do wait elapsed(100s)
"""


def test_programs_hold_runs_to_the_limit_of_the_file_and_to_their_own(tmp_path: Path) -> None:
    file = tmp_path / "waiting.osc"
    file.write_text(WAITING)
    scenario = seoro.load(file)
    verdict = seoro.run(scenario, clock="real")
    assert verdict.status is RunStatus.ERROR
    assert verdict.reason == "no verdict within 0.05 s of wall time (`# seoro: timeout` in the file)"
    verdict = seoro.run(scenario, clock="real", timeout=0.01)
    assert verdict.reason == "no verdict within 0.01 s of wall time (`timeout=SECONDS`)"
    assert seoro.run(scenario, clock="virtual", timeout=math.inf).passed
    with pytest.raises(UsageError, match="invalid `timeout`: found 0, expected seconds above 0"):
        seoro.run(scenario, timeout=0)
