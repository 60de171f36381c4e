"""`osc.helpers`: actions, and the methods of its struct `common`."""

from __future__ import annotations

from seoro.errors import InvalidUse
from seoro.runtime.actions import action
from seoro.runtime.context import ActionContext
from seoro.runtime.method_context import MethodContext


@action("log")
async def log(ctx: ActionContext, msg: object) -> None:
    """Write a message into the trace."""
    ctx.log(str(msg))


def get_scenario_file_directory(run: MethodContext) -> str:
    """The folder of the scenario file, as an absolute path."""
    return str(run.file.resolve().parent)


def get_output_directory(run: MethodContext) -> str:
    """The folder for the results of the run, as an absolute path.

    Raises:
        InvalidUse: The run has none.
    """
    if run.output_directory is None:
        raise InvalidUse("the run has no output directory; give it one with `-o`")
    return str(run.output_directory.resolve())
