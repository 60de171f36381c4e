"""Scenarios as tests: results, reports of failures, fixtures, and other plugins."""

import json
from pathlib import Path

import pytest

from tests.pytest_plugin.conftest import Project

PASSING = (
    'scenario main:\n    pause: time = 1h\n    do serial:\n        wait elapsed(pause)\n        log("done")\n'
)
FAILING = 'scenario main:\n    do serial:\n        log("so far")\n        wait elapsed(2s)\n        emit fail\n'


def test_time_is_virtual_by_default(project: Project) -> None:
    result = project(a=PASSING).runpytest_inprocess("-v", ".")
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(["a.osc::main PASSED*"])


def test_a_failure_is_shown_in_the_text_of_the_scenario(project: Project) -> None:
    pytester = project(a=FAILING)
    result = pytester.runpytest_inprocess(".", "--basetemp=kept", "--osc-seed=7")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*_ main _*",
            " --> a.osc:7:9",
            "7 |         emit fail",
            "run it alone: seoro exec a.osc --scenario main --seed 7 --clock virtual",
            "*Captured scenario log call*",
            "    0.000 s  info     so far",
            "*Captured scenario trace call*",
            "*trace.jsonl",
        ]
    )
    result.stdout.no_fnmatch_line("*.py*:*")
    trace = pytester.path / "kept" / "main0" / "trace.jsonl"
    assert json.loads(trace.read_text().splitlines()[-1])["status"] == "failed"


def test_a_test_that_passes_leaves_no_trace(project: Project) -> None:
    pytester = project(a=PASSING)
    pytester.runpytest_inprocess(".", "--basetemp=kept").assert_outcomes(passed=1)
    assert list(pytester.path.glob("kept/*/*")) == []


def test_pages_of_runs_are_written_on_request(project: Project) -> None:
    pytester = project(a=PASSING, b=FAILING)
    result = pytester.runpytest_inprocess(".", "--seoro-report=pages", "--basetemp=kept")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*Captured scenario report call*", "*/pages/b.osc_main.html"])
    assert "Passed: main" in (pytester.path / "pages/a.osc_main.html").read_text()
    assert "Failed: main" in (pytester.path / "pages/b.osc_main.html").read_text()


def test_all_errors_of_a_file_are_shown_together(project: Project) -> None:
    result = project(a="scenario main:\n    do serial:\n        one()\n        two()\n").runpytest_inprocess(".")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*_ check _*", "*E0401*`one`", "*a.osc:5:9", "*E0401*`two`", "*a.osc:6:9"])


@pytest.mark.parametrize(
    ("expect", "text", "passed"),
    [
        ("failed", FAILING, True),
        ("failed: emit fail", FAILING, True),
        ("failed: too slow", FAILING, False),
        ("failed", PASSING, False),
        ("passed", PASSING, True),
        ("invalid: neither a simulator nor a robot", "", True),
        ("invalid", PASSING, False),
        ("error", FAILING, False),
    ],
)
def test_expect_directive_changes_the_expected_status(
    project: Project, expect: str, text: str, passed: bool
) -> None:
    robot = "import osc.ros\n# seoro: expect {}\nscenario main:\n    robot: differential_drive_robot\n"
    robot += "    do robot.init_nav2(pose_3d(position_3d(x: 0.0m)))\n"
    pytester = project(a=f"# seoro: expect {expect}\n{text}" if text else robot.format(expect))
    result = pytester.runpytest_inprocess(".")
    result.assert_outcomes(passed=int(passed), failed=int(not passed))
    if not passed:
        result.stdout.fnmatch_lines(["expected: *", "ended: *"])


def test_errors_of_the_text_can_be_expected(project: Project) -> None:
    pytester = project(header="", a="# seoro: expect invalid: `one`\n\nscenario main:\n    do one()\n")
    pytester.runpytest_inprocess(".").assert_outcomes(passed=1)


def test_parameters_reach_the_run_from_comments_and_files(project: Project) -> None:
    pytester = project(
        a="\n# seoro: parametrize far=[1m, 3m]\n# seoro: params values.yaml\n"
        "scenario main:\n    far: length\n    name: string\n"
        '    do serial:\n        wait far > 2m and name == "ada"\n'
    )
    (pytester.path / "values.yaml").write_text("main: {name: ada}\n")
    result = pytester.runpytest_inprocess(".")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*_ main?values-far:1m? _*", "*--set far=1m --params *values.yaml"])


def test_an_unknown_parameter_fails_with_a_message(project: Project) -> None:
    result = project(a=f"\n# seoro: parametrize fat=[1m]\n{PASSING}").runpytest_inprocess(".")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*unknown parameter `fat`*"])
    result.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.more
def test_a_simulator_is_in_the_command_that_does_the_same(project: Project) -> None:
    robot = "scenario main:\n    robot: differential_drive_robot\n    do serial:\n"
    robot += "        robot.init_nav2(pose_3d(position_3d(x: 0.0m)))\n        emit fail\n"
    pytester = project(header="import osc.ros\n", a=robot)
    result = pytester.runpytest_inprocess(".", "--osc-sim=mujoco", "--osc-world=maze")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["run it alone: * --seed 0 --sim mujoco --world maze --rate max"])


@pytest.mark.more
def test_a_world_of_comments_is_that_of_the_simulator(project: Project) -> None:
    pytest.importorskip("mujoco")
    robot = (
        "# seoro: simulators mujoco\n# seoro: world nowhere\nscenario main:\n    robot: differential_drive_robot\n"
    )
    robot += "    do robot.init_nav2(pose_3d(position_3d(x: 0.0m)))\n"
    result = project(header="import osc.ros\n", a=robot).runpytest_inprocess(".")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*the world 'nowhere' cannot be loaded*"])


def test_a_world_without_a_simulator_fails_in_words(project: Project) -> None:
    result = project(a=f"# seoro: world maze\n{PASSING}").runpytest_inprocess(".")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*the world 'maze' needs a simulator*"])


def test_a_simulator_that_is_not_installed_is_a_test_that_is_skipped(
    project: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.launch.find_spec", lambda name: None)
    result = project(a=f"# seoro: simulators mujoco\n{PASSING}").runpytest_inprocess(".", "-rs")
    result.assert_outcomes(skipped=1)
    result.stdout.fnmatch_lines(["*the simulator mujoco is not installed"])


def test_conftest_overrides_the_options(project: Project) -> None:
    pytester = project(a="scenario main:\n    far: length\n    do wait far > 2m\n")
    pytester.makeconftest(
        "import pytest\n"
        "@pytest.fixture\n"
        "def osc_options(osc_options):\n"
        "    return {**osc_options, 'seed': 5, 'clock': 'real', 'overrides': {'far': '1m'}, 'grace': 1.0}\n"
        "@pytest.fixture(autouse=True)\n"
        "def _counted(request, tmp_path):\n"
        "    print('around', request.node.name)\n"
    )
    result = pytester.runpytest_inprocess(".", "--osc-timeout=0.05")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "error: no verdict within 0.05 s of wall time (`--osc-timeout SECONDS`)",
            "*--seed 5 --clock real --set far=1m",
            "around main",
        ]
    )


def test_a_limit_of_wall_time_may_stand_in_a_comment(project: Project) -> None:
    result = project(a=f"# seoro: timeout 0.05s\n{PASSING}").runpytest_inprocess(".", "--osc-clock=real")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["error: no verdict within 0.05 s of wall time (`# seoro: timeout` in the file)"])


def test_marks_have_their_usual_effects(project: Project) -> None:
    pytester = project(
        a=f"# pytest: skip(reason='no robot')\n{PASSING}",
        b=f"# pytest: xfail(strict=True)\n{FAILING}",
        c=f"# pytest: usefixtures('shout')\n{PASSING}",
    )
    pytester.makeconftest("import pytest\n@pytest.fixture\ndef shout():\n    print('LOUD')\n")
    result = pytester.runpytest_inprocess(".", "-rs", "-s")
    result.assert_outcomes(passed=1, skipped=1, xfailed=1)
    result.stdout.fnmatch_lines(["*LOUD*", "*no robot*"])


def test_a_fault_of_an_action_shows_the_line_of_its_python(project: Project) -> None:
    pytester = project(a="import osc.garden\nscenario main:\n    do water()\n")
    folder = pytester.path / "seoro.libraries"
    folder.mkdir()
    (folder / "garden.osc").write_text("action water\n")
    (folder / "garden.py").write_text(
        'from seoro import ActionContext, action\n@action("water")\n'
        'async def water(ctx: ActionContext) -> None:\n    {}["can"]\n'
    )
    result = pytester.runpytest_inprocess(".")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*`water` raised KeyError*", "*garden.py*line 4*", "KeyError: 'can'"])
    result.stdout.no_fnmatch_line("*drive.py*")


def test_an_unknown_simulator_fails_with_a_message(project: Project) -> None:
    result = project(a=PASSING).runpytest_inprocess(".", "--osc-sim=gazebo")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["error: unknown simulator 'gazebo'", "  = help: simulators: *"])
    result.stdout.no_fnmatch_line("*another exception*")


def test_a_test_in_python_runs_scenarios(project: Project) -> None:
    pytester = project(a=FAILING, b=PASSING)
    pytester.makepyfile(
        """
        import pytest, seoro

        def test_good(osc_run):
            result = osc_run("b.osc", overrides={"pause": "2s"}, seed=3)
            assert result.passed
            assert result.logs == ["done"]
            assert (result.verdict.seed, result.verdict.duration) == (3, 2.0)
            assert result.parameters == {"pause": 2.0}
            assert result.records[0]["kind"] == "run.start"

        def test_bad(osc_run):
            assert osc_run("a.osc").passed

        def test_missing(osc_run):
            with pytest.raises(seoro.InvalidScenario):
                osc_run("c.osc")

        async def test_loop(osc_run):
            with pytest.raises(seoro.UsageError, match="a running event loop"):
                osc_run("a.osc")

        async def test_embedded(osc_options):
            scenario = seoro.load("b.osc")
            async with seoro.start(scenario, **{**osc_options, "clock": "virtual"}) as run:
                assert (await run.result()).passed
        """
    )
    result = pytester.runpytest_inprocess("test_a_test_in_python_runs_scenarios.py")
    result.assert_outcomes(passed=4, failed=1)
    result.stdout.fnmatch_lines(["*where False = <main: failed *", "    0.000 s  info     so far", "*trace.jsonl"])


def test_tests_with_an_event_loop_and_scenarios_live_side_by_side(project: Project) -> None:
    pytester = project(a=PASSING, z=PASSING)
    pytester.makepyfile(
        test_m="import asyncio\nasync def test_loop():\n    await asyncio.sleep(0)\n"
        "def test_own():\n    asyncio.run(asyncio.sleep(0))\n"
    )
    pytester.runpytest_inprocess(".").assert_outcomes(passed=4)


@pytest.mark.more
def test_xdist_spreads_scenarios_over_processes(project: Project) -> None:
    pytester = project(a=f"\n# seoro: seed 1, 2, 3\n{PASSING}", b=FAILING)
    result = pytester.runpytest_subprocess("-n", "2", ".")
    result.assert_outcomes(passed=3, failed=1)
    result.stdout.fnmatch_lines([" --> b.osc:7:9", "*Captured scenario log call*"])
    result = pytester.runpytest_subprocess("-n", "2")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_results_go_into_junit_xml_with_their_seeds(project: Project) -> None:
    pytester = project(a=f"\n# seoro: seed 1\n{PASSING}")
    pytester.runpytest_inprocess(".", "--junitxml=out.xml", "-o", "junit_family=xunit2").assert_outcomes(passed=1)
    text = Path("out.xml").read_text()
    assert '<property name="seed" value="1"' in text
    assert 'name="main[seed:1]"' in text


def test_failures_alone_can_be_run_again(project: Project) -> None:
    pytester = project(a=PASSING, b=FAILING)
    pytester.runpytest_inprocess(".").assert_outcomes(passed=1, failed=1)
    pytester.runpytest_inprocess(".", "--lf").assert_outcomes(failed=1)


VARIED = """
# seoro: parametrize limit=[3s, 1s]
# seoro: seed 3, 4
scenario main:
    limit: time
    do wait_a_while() with:
        timeout(limit)

scenario wait_a_while:
    do wait elapsed(2s)
"""


def test_failed_variants_alone_are_run_again(project: Project) -> None:
    pytester = project(a=PASSING, b=VARIED)
    pytester.runpytest_inprocess(".").assert_outcomes(passed=3, failed=2)
    pytester.runpytest_inprocess(".", "--lf").assert_outcomes(failed=2)
    result = pytester.runpytest_inprocess(".", "--ff", "-v")
    assert "limit:1s" in next(line for line in result.outlines if "b.osc::" in line)


@pytest.mark.more
def test_a_stepwise_session_begins_at_the_failed_variant(project: Project) -> None:
    pytester = project(b=VARIED)
    pytester.runpytest_inprocess(".", "--sw").assert_outcomes(passed=1, failed=1)
    pytester.runpytest_inprocess(".", "--sw").assert_outcomes(failed=1, deselected=1)


@pytest.mark.more
def test_an_interrupt_stops_the_session(project: Project) -> None:
    pytester = project(a=PASSING, b=PASSING)
    pytester.makeconftest(
        "import os, pytest, signal, threading\n"
        "@pytest.fixture(autouse=True)\n"
        "def _interrupt():\n"
        "    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
    )
    result = pytester.runpytest_subprocess(".", "--osc-clock=real")
    assert result.ret == pytest.ExitCode.INTERRUPTED
    result.stdout.fnmatch_lines(["*KeyboardInterrupt*", "*no tests ran*"])
