"""Notifications of commands: `--notify URL`, or the setting `notify` of the project."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from seoro.cli.arguments import Container, add_option
from seoro.errors import SeoroError

if TYPE_CHECKING:
    from seoro.notifications.message import Event

Content = Callable[[BaseException | None], Mapping[str, Any]]
"""Returns the result, for the exception that ended the command, if any."""


def add_notify_argument(parser: Container) -> None:
    """Declare the option."""
    add_option(
        parser,
        "--notify URL",
        "send the result to this URL as JSON (default: those of the project; SEORO_NOTIFY_SECRET signs)",
        repeatable=True,
    )


def use_notify(options: argparse.Namespace, settings: Mapping[str, Any]) -> None:
    """Fill in the URLs of the project, and check all.

    Args:
        options: Options with `notify`.
        settings: Settings of the project.

    Raises:
        UsageError: A URL is invalid.
    """
    options.notify = [*dict.fromkeys(options.notify or settings.get("notify", ()))]
    if options.notify:
        from seoro.notifications.addresses import read_address  # noqa: PLC0415 - seldom needed

        for text in options.notify:
            read_address(text)


@contextmanager
def notifying(options: argparse.Namespace, event: Event, content: Content) -> Iterator[None]:
    """Send a notification after the block, also if it ends with an error. Failed deliveries are warnings.

    Args:
        options: Options with `notify`, which `use_notify` has checked.
        event: Kind of the end.
        content: Returns its result.
    """
    if not options.notify:
        yield
        return
    from seoro.notifications.addresses import read_address  # noqa: PLC0415 - seldom needed
    from seoro.notifications.delivery import deliver  # noqa: PLC0415 - the same
    from seoro.notifications.message import Message  # noqa: PLC0415 - the same

    addresses = [read_address(text) for text in options.notify]
    failed: BaseException | None = None
    try:
        yield
    except BaseException as error:
        failed = error
        raise
    finally:
        for problem in deliver(addresses, Message(event, content(failed))):
            print(f"warning: notification not delivered: {problem}", file=sys.stderr, flush=True)


def ended(status: str, error: BaseException | None) -> dict[str, str]:
    """Return the status and reason of a command with a status of its own, unless an exception ended it."""
    return {"status": status, "reason": ""} if error is None else failure_of(error)


def failure_of(error: BaseException | None) -> dict[str, str]:
    """Return the status and reason for an end without a result."""
    if isinstance(error, SeoroError | OSError):
        return {"status": "error", "reason": str(error)}
    if isinstance(error, Exception):
        return {"status": "error", "reason": f"internal error: {type(error).__name__}"}
    return {"status": "cancelled", "reason": "interrupted before it had a result"}
