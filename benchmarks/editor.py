"""Latency of diagnostics and answers for a long scenario in an editor (table of docs/how-to/edit.md).

    python benchmarks/editor.py [--lines N] [--rounds N]

Each time is measured from the message of the editor to the answer, less the pause after the last change; beside it
stands the processor time of the server. "edit" changes a number in one scenario, "new text" changes all of them.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
from collections.abc import Awaitable, Callable
from statistics import median
from time import perf_counter

import processes
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

from seoro.lsp.scheduling import DELAY

URI = "file:///tmp/long.osc"
BLOCK = """
scenario part_{number}:
    robot: differential_drive_robot
    box: sim_object
    limit: speed = {number}kph
    event go
    do parallel:
        first: serial:
            robot.init_nav2(pose_3d(position_3d(x: 0.0m, y: 1.0m)))
            emit go
            robot.nav_to_pose(goal_pose: pose_3d(position_3d(x: 3.0m, y: -3.0m)))
            box.spawn(
                spawn_pose: pose_3d(
                    position: position_3d(x: 2.0m, y: -2.0m, z: 0.1m),
                    orientation: orientation_3d(yaw: 0.0rad)),
                model: 'example_simulation://models/box.sdf')
        serial:
            wait @go
            wait elapsed(120s)
            emit fail
"""


def long_text(length: int, number: int) -> str:
    """Return a scenario file of about as many lines, different for each number."""
    count = length // BLOCK.count("\n")
    blocks = (BLOCK.format(number=number + part) for part in range(count))
    return "import osc.ros\nimport osc.gazebo\n" + "".join(blocks)


def processor_time(client: LanguageClient) -> float:
    """Return the processor time of the server so far [s]."""
    server = client._server
    assert server is not None
    return processes.processor_time(server.pid)


async def measure(
    client: LanguageClient,
    rounds: int,
    what: str,
    act: Callable[[int], Awaitable[object]],
    less: float = 0.0,
) -> None:
    """Print the duration of a request."""
    times = []
    used = processor_time(client)
    for number in range(rounds):
        start = perf_counter()
        await act(number)
        times.append((perf_counter() - start - less) * 1000)
    used = (processor_time(client) - used) / rounds * 1000
    print(f"{what:<30} median {median(times):4.0f} ms, worst {max(times):4.0f} ms, processor time {used:4.0f} ms")


async def main(length: int, rounds: int) -> None:
    """Start a server, and act as its editor."""
    client = LanguageClient("benchmark", "1")
    shown: asyncio.Queue[lsp.PublishDiagnosticsParams] = asyncio.Queue()

    @client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)  # type: ignore[untyped-decorator]
    def published(params: lsp.PublishDiagnosticsParams) -> None:
        shown.put_nowait(params)

    await client.start_io(sys.executable, "-m", "seoro", "lsp")
    await client.initialize_async(lsp.InitializeParams(lsp.ClientCapabilities()))
    client.initialized(lsp.InitializedParams())
    client.text_document_did_open(
        lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(URI, "osc", 0, long_text(length, 0)))
    )
    await shown.get()
    document = lsp.TextDocumentIdentifier(URI)
    lines = long_text(length, 0).split("\n")
    line = next(number for number in reversed(range(len(lines))) if "nav_to_pose" in lines[number])
    place = lsp.Position(line, lines[line].index("nav_to_pose") + 3)

    async def show(text: str, version: int) -> None:
        changes = [lsp.TextDocumentContentChangeWholeDocument(text)]
        identifier = lsp.VersionedTextDocumentIdentifier(version, URI)
        client.text_document_did_change(lsp.DidChangeTextDocumentParams(identifier, changes))
        await shown.get()

    async def edit(number: int) -> None:
        edited = lines[line // 2 :]
        at = next(index for index, text in enumerate(edited) if "elapsed(120s)" in text)
        edited[at] = edited[at].replace("120s", f"{number + 1}s")
        await show("\n".join(lines[: line // 2] + edited), number + 1)

    async def change(number: int) -> None:
        await show(long_text(length, number + 1), rounds + number + 1)

    print(f"a file of {len(lines)} lines")
    await measure(client, rounds, "diagnostics after an edit", edit, less=DELAY)
    await measure(client, rounds, "diagnostics after a new text", change, less=DELAY)
    await measure(
        client,
        rounds,
        "completion",
        lambda _: client.text_document_completion_async(lsp.CompletionParams(document, place)),
    )
    await measure(
        client,
        rounds,
        "hover",
        lambda _: client.text_document_hover_async(lsp.HoverParams(document, place)),
    )
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()  # type: ignore[no-untyped-call]


parser = argparse.ArgumentParser(description="Measure the latency of answers to an editor.")
parser.add_argument("--lines", type=int, default=3000)
parser.add_argument("--rounds", type=int, default=20)
options = parser.parse_args()
asyncio.run(main(options.lines, options.rounds))
