"""Tools that only read, over the stdio of a real server."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import anyio
import pytest

from seoro.campaign.runs import End
from seoro.campaign.store.folder import RUNS
from seoro.cli.main import main
from seoro.errors import UsageError
from seoro.mcp.bounds import LONGEST_TEXT, MOST_ITEMS, Bounds
from seoro.mcp.served_folder import ServedFolder
from seoro.mcp.stdin_lines import LONGEST
from tests.campaign.compared import rows, write
from tests.mcp.agents import PATIENCE, Agent, connected

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
        assert "of_nobody" not in await agent.error("describe_scenario", file="importing.osc")
        # Findings in imported files outside of the folder do not quote them.
        found = await agent.call("check_scenarios", path="importing.osc")
        assert found["errors"] >= 1
        assert "of_nobody" not in json.dumps(found)


async def test_campaigns_are_compared(tmp_path: Path) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    write(folder / "before", rows([End.PASSED] * 200))
    write(folder / "after", rows([End.FAILED] * 6 + [End.PASSED] * 194))
    write(tmp_path / "outside", rows([End.PASSED]))
    write(folder / "linked", rows([End.PASSED]))
    (folder / "linked" / RUNS / "other.jsonl").symlink_to(tmp_path / "outside" / RUNS / "worker.jsonl")
    async with connected(folder) as agent:
        found = await agent.call("compare_campaigns", before="before", after="after")
        assert found["outcome"] == "worse"
        assert len(found["comparison"]["newly_failing"]) == 6
        assert "margin" in await agent.error("compare_campaigns", before="before", after="after", margin=2.0)
        assert "leads out" in await agent.error("compare_campaigns", before="before", after="linked")
        assert "outside" in await agent.error("compare_campaigns", before="before", after="../outside")


async def test_requests_at_the_same_time_have_their_own_answers(folder: Path) -> None:
    answers: list[dict[str, object]] = []

    async def ask(agent: Agent) -> None:
        answers.append(await agent.call("list_runs"))

    async with connected(folder) as agent, anyio.create_task_group() as group:
        for _ in range(20):
            group.start_soon(ask, agent)
    assert answers == answers[:1] * 20


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


@pytest.mark.parametrize("line", ["[" * 100_000, '{"jsonrpc": "2.0", "id": 1, "method": "no"}', "\0", "\ud83d"])
def test_odd_messages_do_not_end_the_server(tmp_path: Path, line: str) -> None:
    command = [sys.executable, "-m", "seoro", "mcp", str(tmp_path)]
    ping = '{"jsonrpc": "2.0", "id": 7, "method": "ping"}'
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdin is not None
    assert process.stdout is not None
    with process.stdin as written, process.stdout as answers:
        written.write(f"{line}\n{ping}\n".encode("utf-8", "surrogatepass"))
        written.flush()
        while json.loads(answers.readline()).get("id") != 7:
            pass
        written.close()
        assert process.wait(PATIENCE) == 0


def test_messages_are_bounded(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "seoro", "mcp", str(tmp_path)]
    done = subprocess.run(command, input="x" * (LONGEST + 100_000), capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "longer than 4 MiB" in done.stderr


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
