"""Server of the tools over stdin and stdout, by the official SDK."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import anyio.to_thread
import mcp_types as types
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server
from mcp.shared.exceptions import MCPError

from seoro import __version__
from seoro.errors import SeoroError, cause_of
from seoro.mcp.reading import ScenarioReader
from seoro.mcp.resources import TEMPLATES, Resources
from seoro.mcp.results import ResultReader
from seoro.mcp.running import Runner
from seoro.mcp.served_folder import ServedFolder
from seoro.mcp.stdin_lines import StdinLines
from seoro.mcp.tool import Answer, Tool, message_of
from seoro.mcp.tools import make_tools

INSTRUCTIONS: Final = (
    "Robot test scenarios in OpenSCENARIO DSL 2. Paths are relative to the served folder. Check a scenario after "
    "each change; explain a run before you change a scenario because of its verdict."
)


def _declaration(tool: Tool) -> types.Tool:
    return types.Tool(
        name=tool.name,
        description=tool.description,
        input_schema=tool.arguments.model_json_schema(),
        output_schema=tool.answer.model_json_schema(),
        annotations=types.ToolAnnotations(
            read_only_hint=tool.reads_only,
            destructive_hint=False,
            idempotent_hint=tool.reads_only,
            open_world_hint=not tool.reads_only,
        ),
    )


class _Handlers:
    """Handlers of requests.

    Args:
        tools: The tools by name.
        resources: The resources.
    """

    def __init__(self, tools: Mapping[str, Tool], resources: Resources) -> None:
        self._tools = tools
        self._resources = resources

    async def list_tools(self, _context: Any, _params: Any) -> types.ListToolsResult:
        """List the tools."""
        return types.ListToolsResult(tools=[_declaration(tool) for tool in self._tools.values()])

    async def call_tool(self, _context: Any, params: types.CallToolRequestParams) -> types.CallToolResult:
        """Call a tool; errors are results, which agents read."""
        tool = self._tools.get(params.name)
        if tool is None:
            raise MCPError(
                types.INVALID_PARAMS, f"unknown tool `{params.name[:100]}` (tools: {', '.join(self._tools)})"
            )
        try:
            answer: Answer = await tool.call(tool.checked(params.arguments or {}))
        except Exception as error:
            return _text_result(_message(error), is_error=True)
        data = answer.model_dump(mode="json")
        return types.CallToolResult(
            content=[types.TextContent(type="text", text=answer.model_dump_json())], structured_content=data
        )

    async def list_resources(self, _context: Any, _params: Any) -> types.ListResourcesResult:
        """List the resources."""
        return types.ListResourcesResult(resources=await anyio.to_thread.run_sync(self._resources.list_scenarios))

    async def list_templates(self, _context: Any, _params: Any) -> types.ListResourceTemplatesResult:
        """List the templates of resources."""
        return types.ListResourceTemplatesResult(resource_templates=list(TEMPLATES))

    async def read_resource(
        self, _context: Any, params: types.ReadResourceRequestParams
    ) -> types.ReadResourceResult:
        """Read a resource."""
        try:
            found = await anyio.to_thread.run_sync(self._resources.read, str(params.uri))
        except Exception as error:
            raise MCPError(types.INVALID_PARAMS, _message(error)) from error
        return types.ReadResourceResult(contents=[found])


def _message(error: Exception) -> str:
    """Return the text of an error for the agent; unexpected ones are logged with their traceback."""
    error = cause_of(error)
    if isinstance(error, SeoroError | OSError):
        return message_of(error)
    logging.getLogger(__name__).error("a request failed", exc_info=error)
    return f"internal error: {type(error).__name__}: {error}"


def _text_result(text: str, *, is_error: bool) -> types.CallToolResult:
    return types.CallToolResult(content=[types.TextContent(type="text", text=text)], is_error=is_error)


async def serve(folder: Path, *, allow_run: bool) -> None:
    """Serve a client on stdin and stdout until it disconnects; runs end with it.

    Args:
        folder: The served folder.
        allow_run: Whether agents may run scenarios.

    Raises:
        UsageError: The folder is missing.
    """
    served = ServedFolder(folder)
    scenarios, results = ScenarioReader(served), ResultReader(served)
    tools = make_tools(scenarios, results, Runner(served, results) if allow_run else None)
    handlers = _Handlers(tools, Resources(served, scenarios, results))
    server: Server[Any] = Server(
        "seoro",
        version=__version__,
        instructions=INSTRUCTIONS,
        on_list_tools=handlers.list_tools,
        on_call_tool=handlers.call_tool,
        on_list_resources=handlers.list_resources,
        on_list_resource_templates=handlers.list_templates,
        on_read_resource=handlers.read_resource,
    )
    lines: Any = StdinLines()
    async with stdio_server(stdin=lines) as (received, sent):
        await server.run(received, sent, server.create_initialization_options())
