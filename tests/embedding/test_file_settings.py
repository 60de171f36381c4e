"""Settings that directives of a scenario file give to a run, and the options that go before them."""

from pathlib import Path

import pytest

from seoro.embed import check_file
from seoro.embed.file_settings import FileSettings, Given, settings_of_file, with_file_settings
from seoro.embed.options import Lab, Options, Ros, Simulator
from seoro.errors import InvalidUse

SCENARIO = "scenario main:\n    do wait elapsed(1s)\n"


def settings(tmp_path: Path, directives: str, given: Given, *, repeats: bool = False) -> FileSettings:
    return settings_of_file(checked(tmp_path, directives), None, given, repeats=repeats)


def checked(tmp_path: Path, directives: str):  # type: ignore[no-untyped-def]
    (tmp_path / "hall.yaml").write_text("")
    file = tmp_path / "test.osc"
    file.write_text(f"import osc.types\n\n{directives}{SCENARIO}")
    return check_file(file).without_errors().checked


ALL = "# seoro: simulators mujoco\n# seoro: world hall.yaml\n# seoro: seed 7\n# seoro: timeout 9s\n"


def test_directives_give_what_options_leave_open(tmp_path: Path) -> None:
    found = settings(tmp_path, ALL, Given())
    assert (found.simulator, found.world) == ("mujoco", str(tmp_path / "hall.yaml"))
    assert (found.seed, found.timeout, found.notes) == (7, 9.0, [])


def test_options_go_before_directives(tmp_path: Path) -> None:
    found = settings(tmp_path, ALL, Given(simulator="pybullet", world="maze", seed=0, timeout=1.0))
    assert (found.simulator, found.world, found.seed, found.timeout) == ("pybullet", "maze", 0, 1.0)
    assert [note.partition(": ")[2] for note in found.notes] == [
        "it asks for the simulator mujoco; this run uses pybullet"
    ]


@pytest.mark.parametrize("place", ["--lab", "--from-snapshot", "--ros", "--clock virtual"])
def test_a_place_without_worlds_replaces_the_simulator_with_a_note(tmp_path: Path, place: str) -> None:
    found = settings(tmp_path, ALL, Given(place=place))
    assert (found.simulator, found.world) == (None, None)
    assert all(f"`{place}` goes before it" in note for note in found.notes)
    assert len(found.notes) == 2


def test_a_running_simulator_loads_the_world_of_the_file(tmp_path: Path) -> None:
    found = settings(tmp_path, ALL, Given(place="--connect", takes_world=True))
    assert (found.simulator, found.world) == (None, str(tmp_path / "hall.yaml"))


def test_a_world_without_a_simulator_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidUse, match="the run has no simulator"):
        settings(tmp_path, "# seoro: world maze\n", Given())


def test_a_single_run_uses_the_first_seed_and_simulator_and_says_so(tmp_path: Path) -> None:
    directives = "# seoro: simulators mujoco, pybullet\n# seoro: seed 4, 5\n"
    found = settings(tmp_path, directives, Given())
    assert (found.simulator, found.seed, found.seeds) == ("mujoco", 4, (4, 5))
    assert [note.partition(": ")[2] for note in found.notes] == [
        "it lists the simulators mujoco, pybullet; this run uses mujoco",
        "it lists the seeds 4, 5; this run uses 4",
    ]
    assert len(settings(tmp_path, directives, Given(), repeats=True).notes) == 1


def test_parameters_that_only_tests_vary_are_noted_unless_given(tmp_path: Path) -> None:
    directives = "# seoro: parametrize speed=[1mps]\n"
    assert "varies the parameter speed" in settings(tmp_path, directives, Given()).notes[0]
    assert settings(tmp_path, directives, Given(parameters=("speed",))).notes == []


def test_directives_of_the_chosen_scenario_apply(tmp_path: Path) -> None:
    file = tmp_path / "two.osc"
    file.write_text(
        f"# seoro: seed 1\n\nimport osc.types\n# seoro: seed 2\nscenario other:\n    do main()\n{SCENARIO}"
    )
    both = check_file(file).without_errors().checked
    assert settings_of_file(both, "main", Given()).seed == 1
    assert settings_of_file(both, "other", Given()).seed == 2


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
    found, _ = with_file_settings(checked(tmp_path, ALL), options)
    expected = simulator
    if simulator is not None and simulator.world is not None:
        expected = Simulator(simulator.name, simulator.endpoint, str(tmp_path / "hall.yaml"), simulator.rate)
    assert found.simulator == expected
    assert found.seed == 7
