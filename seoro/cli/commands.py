"""Commands of `seoro`, in groups, in the order of the help. Modules of commands are loaded on demand."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import starmap
from typing import Final

GROUPS: Final[Mapping[str, Mapping[str, str]]] = {
    "run scenarios": {
        "exec": "run a scenario in this process or on an executor",
        "test": "run scenario files and folders as tests",
        "campaign": "run a scenario many times, with planned values of its parameters",
        "replay": "repeat a recorded run, with the events that its application emitted",
        "accept": "check a recorded trace against its scenario",
    },
    "write scenarios": {
        "new": "make a project with a scenario, a world, an own action and tests",
        "check": "parse and check scenario files without running them",
        "fmt": "format scenario files (coding style guide of the standard)",
        "migrate": "rewrite scenario files that were written for scenario_execution",
        "explain": "explain error codes, with examples",
        "doc": "show the documentation of libraries, actions, modifiers, types and units",
        "schema": "print JSON Schemas of world, lab, robot and other files, for editors",
        "lsp": "run the language server for editors (diagnostics, completion, hover, definitions)",
        "mcp": "serve scenarios and results to agents (Model Context Protocol)",
        "dap": "run a debug adapter for editors (breakpoints, steps, variables)",
    },
    "look at runs": {
        "ui": "show and start runs in a browser: live and past, of this machine and of executors",
        "report": "write a page that shows a run: verdict, timeline, world, source, plots, causes",
        "trace": "print, filter, summarise or convert the trace of a run",
        "compare": "find where two recorded runs first differ",
        "bag": "show the contents of a ROS 2 bag, or repair a truncated one",
        "redact": "remove names, hosts, paths and chosen fields from a trace, before it is shared",
        "runs": "delete old runs by age and size",
    },
    "simulators and robots": {
        "sim": "start a simulator node that runs connect to",
        "bridge": "expose a simulator as ROS 2 nodes, or ROS 2 robots to seoro",
        "ros": "inspect and use a ROS 2 system: topics, services, actions, parameters, bags",
        "lab": "show, lease, release and stop the robots of a lab",
        "estop": "emergency stop: stop all robots, or the named ones, until they are released",
        "router": "run a Zenoh router that connects executors, simulators and bridges",
        "keys": "create, renew and revoke the keys of a lab",
        "check-node": "check whether a simulator node keeps the rules of the protocol",
    },
    "executors": {
        "serve": "run an executor: accept scenarios over the network and run them",
        "ps": "list the runs of executors",
        "attach": "follow a run on an executor from its first record to its end",
        "logs": "print the progress of a run on an executor so far",
        "stop": "stop runs on executors",
        "get": "download the output files of a run",
        "rm": "delete a run and its files",
    },
    "this installation": {
        "config": "show the settings of the project, and where each comes from",
        "doctor": "check the installation and the network, and suggest fixes",
        "completion": "print the script that completes commands in a shell",
    },
}

COMMANDS: Final[Mapping[str, str]] = {
    name: what for commands in GROUPS.values() for name, what in commands.items()
}
REPLACED: Final = {"sweep": "campaign run"}


def listed(columns: int) -> str:
    """Return the commands for the help, in lines of at most so many columns."""
    from textwrap import fill  # noqa: PLC0415 - for the help only

    width = max(map(len, COMMANDS))
    indent = " " * (width + 4)

    def line(name: str, what: str) -> str:
        return fill(
            what, max(columns, 2 * len(indent)), initial_indent=f"  {name:{width}}  ", subsequent_indent=indent
        )

    groups = ("\n".join((f"{title}:", *starmap(line, commands.items()))) for title, commands in GROUPS.items())
    return "\n\n".join(groups)
