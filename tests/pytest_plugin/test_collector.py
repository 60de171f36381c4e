"""Collection of files and scenarios as tests, and their names."""

import subprocess
import sys

import pytest

from tests.pytest_plugin.conftest import CONFIGURATION, Project

ONE = 'scenario one:\n    do log("one")\n'
TWO = ONE + 'scenario two:\n    do log("two")\n'


def collected(pytester: pytest.Pytester, *arguments: str) -> list[str]:
    """The tests that pytest finds."""
    result = pytester.runpytest_inprocess("--collect-only", "-q", *arguments)
    assert result.ret in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED), result.outlines
    return [line for line in result.outlines if "::" in line]


def test_the_only_scenario_of_a_file_is_a_test(project: Project) -> None:
    assert collected(project(a=ONE), "a.osc") == ["a.osc::one"]


def test_of_several_the_one_called_main_is_a_test(project: Project) -> None:
    pytester = project(a=TWO + "scenario main:\n    do one()\n")
    assert collected(pytester, "a.osc") == ["a.osc::main"]


def test_of_several_without_main_all_are_tests(project: Project) -> None:
    assert collected(project(a=TWO), "a.osc") == ["a.osc::one", "a.osc::two"]


def test_scenarios_with_comments_are_the_tests(project: Project) -> None:
    pytester = project(a=TWO + "\n# seoro: test\nscenario three:\n    do one()\nscenario main:\n    do two()\n")
    assert collected(pytester, "a.osc") == ["a.osc::three"]


def test_a_file_without_scenarios_has_no_tests(project: Project) -> None:
    assert collected(project(a="struct box:\n    mass: mass\n"), "a.osc") == []


def test_scenarios_of_actors_and_imported_files_are_not_collected(project: Project) -> None:
    pytester = project(
        a='import "b.osc"\nactor robot\nscenario robot.turn:\n    do log("")\nscenario here:\n    do log("")\n',
        b=ONE,
    )
    assert collected(pytester, "a.osc") == ["a.osc::here"]


def test_parameters_seeds_and_files_make_tests(project: Project) -> None:
    pytester = project(
        a="\n# seoro: parametrize speed=[1mps, 2mps] name=['a, b', \"]\"]\n# seoro: seed 3\n"
        'scenario main:\n    speed: speed\n    name: string\n    do log("")\n',
        b='\n# seoro: params values/*.yaml\nscenario main:\n    far: bool = true\n    do log("")\n',
    )
    (pytester.path / "values").mkdir()
    for name in ("near", "far"):
        (pytester.path / "values" / f"{name}.yaml").write_text(f"main: {{far: {str(name == 'far').lower()}}}\n")
    assert collected(pytester, ".") == [
        "a.osc::main[speed:1mps-name:'a, b'-seed:3]",
        'a.osc::main[speed:1mps-name:"]"-seed:3]',
        "a.osc::main[speed:2mps-name:'a, b'-seed:3]",
        'a.osc::main[speed:2mps-name:"]"-seed:3]',
        "b.osc::main[far]",
        "b.osc::main[near]",
    ]
    pytester.runpytest_inprocess("-q").assert_outcomes()  # no path was given
    pytester.runpytest_inprocess("-q", ".").assert_outcomes(passed=6)


def test_a_test_has_the_values_of_its_file(project: Project) -> None:
    text = (
        'import osc.helpers\n# seoro: set near=3\nscenario main:\n    near: int\n    do compare(near, "==", 3)\n'
    )
    project(a=text).runpytest_inprocess("-q", ".").assert_outcomes(passed=1)


def test_each_simulator_makes_a_test_unless_pytest_is_given_one(project: Project) -> None:
    pytester = project(a=f"# seoro: simulators mujoco, pybullet\n# seoro: seed 1\n{ONE}")
    assert collected(pytester, ".") == ["a.osc::one[mujoco-seed:1]", "a.osc::one[pybullet-seed:1]"]
    assert collected(pytester, ".", "--osc-sim=pybullet") == ["a.osc::one[seed:1]"]


def test_tests_are_selected_by_name_and_mark(project: Project) -> None:
    pytester = project(
        a="\n# pytest: smoke\n# seoro: seed 1, 2\nscenario one:\n    do log('')\n\n"
        "# seoro: seed 1, 2\nscenario two:\n    do log('')\n"
    )
    assert collected(pytester, ".", "-k", "seed:1") == ["a.osc::one[seed:1]", "a.osc::two[seed:1]"]
    assert collected(pytester, ".", "-m", "smoke") == ["a.osc::one[seed:1]", "a.osc::one[seed:2]"]
    assert collected(pytester, "a.osc::two[seed:2]") == ["a.osc::two[seed:2]"]


def test_equal_test_names_are_numbered(project: Project) -> None:
    pytester = project(a="\n# seoro: seed 1, 1\nscenario one:\n    do log('')\n")
    assert collected(pytester, ".") == ["a.osc::one[seed:1]", "a.osc::one[seed:1-1]"]


def test_comments_at_the_top_are_for_all_tests_of_the_file(project: Project) -> None:
    pytester = project(header="", a="# Two scenarios.\n# seoro: seed 5\n\nimport osc.helpers\n" + TWO)
    assert collected(pytester, ".") == ["a.osc::one[seed:5]", "a.osc::two[seed:5]"]


def test_a_wrong_comment_fails_with_its_place(project: Project) -> None:
    result = project(a="\n# seoro: parametrise x=[1]\n" + ONE).runpytest_inprocess(".")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*E0500*unknown directive `parametrise`", "*--> a.osc:4:1", "*did you mean*"])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_without_a_path_nothing_is_collected(project: Project) -> None:
    pytester = project(a=ONE)
    assert collected(pytester) == []
    assert collected(pytester, ".") == ["a.osc::one"]


def test_testpaths_are_paths(project: Project) -> None:
    pytester = project(a=ONE)
    pytester.makefile(".ini", pytest=CONFIGURATION + "testpaths = .\n")
    assert collected(pytester) == ["a.osc::one"]


def test_globs_select_test_files(project: Project) -> None:
    pytester = project(a=ONE, b=ONE)
    (pytester.path / "sub").mkdir()
    (pytester.path / "sub" / "c.osc").write_text((pytester.path / "a.osc").read_text())
    pytester.makefile(".ini", pytest=CONFIGURATION + "osc_files = sub/* b*\n")
    assert collected(pytester) == ["b.osc::one", "sub/c.osc::one"]
    assert collected(pytester, "a.osc") == ["a.osc::one"]


def test_other_projects_are_not_affected() -> None:
    code = "import sys, seoro.pytest_plugin; print([m for m in sys.modules if m.startswith(('seoro.', 'anyio'))])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['seoro.lazy_names', 'seoro.pytest_plugin']"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--osc-seed", "x"], "invalid seed 'x': expected a whole number from 0, or `random`"),
        (["--osc-timeout", "0"], "expected a positive number, found '0'"),
        (["--osc-world", "maze"], "--osc-world needs a simulator"),
        (["--osc-sim", "mujoco", "--osc-connect", "x"], "--osc-sim contradicts --osc-connect"),
    ],
)
def test_a_wrong_option_is_refused(project: Project, arguments: list[str], message: str) -> None:
    # In a process of its own: pytest that ends so does not put its global settings back.
    result = project(a=ONE).runpytest_subprocess(*arguments)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert message in result.stdout.str() + result.stderr.str()
