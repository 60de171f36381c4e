"""Tools that only read, over the stdio of a real server."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.errors import UsageError
from seoro.mcp.bounds import LONGEST_TEXT, MOST_ITEMS, Bounds
from seoro.mcp.served_folder import ServedFolder
from tests.mcp.agents import connected

HELLO = """# Says hello.
# seoro: requirement REQ-7
import osc.helpers

scenario hello:
    # How often.
    times: int = 2
    do serial:
        log("hello")
"""
FAILING = 'import osc.helpers\nscenario failing:\n    do serial:\n        log("before")\n        emit fail\n'
BROKEN = "scenario broken:\n    do serial:\n        missing()\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with scenarios, two runs, and links that lead out of it."""
    top = tmp_path_factory.mktemp("top")
    made = top / "project"
    made.mkdir()
    (top / "secret.osc").write_text("token of_nobody\n")
    (made / "link.osc").symlink_to(top / "secret.osc")
    (made / "importing.osc").write_text('import "../secret.osc"\n' + HELLO)
    for name, text in (("hello", HELLO), ("failing", FAILING), ("broken", BROKEN)):
        (made / f"{name}.osc").write_text(text)
    for name in ("hello", "failing"):
        main(["exec", str(made / f"{name}.osc"), "-o", str(made / "out" / name), "--seed", "3"])
    outside = top / "outside"
    main(["exec", str(made / "hello.osc"), "-o", str(outside)])
    (made / "linked_run").mkdir()
    (made / "linked_run" / "trace.jsonl").symlink_to(outside / "trace.jsonl")
    return made


async def test_agents_read_scenarios_and_results(folder: Path) -> None:
    before = sorted(folder.rglob("*"))
    async with connected(folder) as agent:
        tools = {tool.name: tool for tool in (await agent.client.list_tools()).tools}
        assert "run_scenario" not in tools
        assert all(tool.annotations and tool.annotations.read_only_hint for tool in tools.values())
        assert all(tool.output_schema for tool in tools.values())

        listed = await agent.call("list_scenarios")
        by_file = {each["file"]: each for each in listed["scenarios"]}
        assert set(by_file) == {"broken.osc", "failing.osc", "hello.osc", "importing.osc"}
        assert by_file["hello.osc"]["scenario"] == "hello"
        assert by_file["hello.osc"]["doc"] == "Says hello."

        described = await agent.call("describe_scenario", file="hello.osc")
        assert [(each["path"], each["default"]) for each in described["parameters"]] == [("times", "2")]
        assert described["requirements"] == ["REQ-7"]

        found = await agent.call("check_scenarios", path="broken.osc")
        assert found["errors"] == 1
        [finding] = found["findings"]
        assert (finding["file"], finding["line"]) == ("broken.osc", 3)
        explained = await agent.call("explain_code", code=finding["code"])
        assert "## Right" in explained["text"]

        runs = await agent.call("list_runs")
        assert {each["run"] for each in runs["runs"]} == {"out/hello", "out/failing"}
        result = await agent.call("explain_run", run="out/failing")
        assert (result["status"], result["seed"]) == ("failed", 3)
        assert "failing.osc:5" in result["source"]
        assert result["logs"] == ["0.000 s before"]

        same = await agent.call("compare_runs", first="out/hello", second="out/hello/trace.jsonl")
        assert same["is_equal"]
        other = await agent.call("compare_runs", first="out/hello", second="out/failing")
        assert ["scenario", "hello", "failing"] in other["settings"]

        resources = [each.uri for each in (await agent.client.list_resources()).resources]
        assert "seoro://scenario/hello.osc" in resources
        [source] = (await agent.client.read_resource("seoro://scenario/hello.osc")).contents
        assert getattr(source, "text", "") == HELLO
        [verdict] = (await agent.client.read_resource("seoro://run/out/failing")).contents
        assert json.loads(getattr(verdict, "text", "{}"))["status"] == "failed"
    assert sorted(folder.rglob("*")) == before


async def test_invalid_requests_have_one_clear_error(folder: Path) -> None:
    async with connected(folder) as agent:
        for name in ("../secret.osc", "/etc/passwd", "link.osc", "out/../../secret.osc"):
            for tool, argument in (
                ("describe_scenario", "file"),
                ("check_scenarios", "path"),
                ("explain_run", "run"),
            ):
                text = await agent.error(tool, **{argument: name})
                assert "outside of the served folder" in text
                assert "of_nobody" not in text
        assert "outside" in await agent.error("explain_run", run="linked_run")
        assert "invalid path" in await agent.error("explain_run", run="a\0b")
        assert "not a scenario file" in await agent.error("describe_scenario", file="out")
        assert "path not found" in await agent.error("explain_run", run="out/no")
        unknown = await agent.error("explain_code", kode="E0312")
        assert unknown.startswith("unknown argument `kode` of `explain_code`")
        assert "`code`" in unknown
        assert await agent.error("explain_code", code=3) == (
            "invalid argument `code` of `explain_code`: input should be a valid string; found 3"
        )
        assert "missing argument `run`" in await agent.error("explain_run")
        assert "unknown code" in await agent.error("explain_code", code="E9999")
        with pytest.raises(Exception, match="unknown tool `run_scenario`"):
            await agent.client.call_tool("run_scenario", {"file": "hello.osc"})
        with pytest.raises(Exception, match="outside of the served folder"):
            await agent.client.read_resource("seoro://scenario/../secret.osc")
        # Findings in imported files outside of the folder do not quote them.
        found = await agent.call("check_scenarios", path="importing.osc")
        assert found["errors"] >= 1
        assert "of_nobody" not in json.dumps(found)


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "seoro", "mcp", str(tmp_path / "no")]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert "not a folder" in done.stderr


def test_the_server_ends_with_its_input_and_survives_bad_lines(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "seoro", "mcp", str(tmp_path)]
    done = subprocess.run(command, input="nonsense\n\n{}\n", capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert all(json.loads(line)["jsonrpc"] == "2.0" for line in done.stdout.splitlines())


def test_large_values_are_cut_and_named() -> None:
    bounds = Bounds()
    found = bounds.apply(
        {"text": "x" * (LONGEST_TEXT + 1), "list": list(range(MOST_ITEMS + 1)), "one": 1}, "found"
    )
    assert found["text"].endswith("... (1 more characters)")
    assert len(found["list"]) == MOST_ITEMS
    assert bounds.cut == ["found.text", f"found.list ({MOST_ITEMS} of {MOST_ITEMS + 1})"]
    many = Bounds()
    many.apply([["y" * LONGEST_TEXT] * MOST_ITEMS] * MOST_ITEMS, "many")
    assert many.cut == ["many"]


def test_the_folder_itself_may_be_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a.osc").write_text(HELLO)
    (tmp_path / "link").symlink_to(tmp_path / "real")
    served = ServedFolder(tmp_path / "link")
    assert served.scenario("a.osc") == tmp_path.resolve() / "real" / "a.osc"
    with pytest.raises(UsageError, match="outside"):
        served.path("..")
