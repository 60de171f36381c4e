"""Rights of the users of a site, by the role in its keys."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Final

from starlette.types import ASGIApp, Receive, Scope, Send

from seoro.security.keys.roles import Role
from seoro.ui.answers import RequestError, answer

READING: Final = ("GET", "HEAD")


@dataclass(frozen=True)
class Rights:
    """Rights of the users of a site.

    Args:
        may_act: Whether they may start and stop runs, and command the lab.
        is_owner: Whether they are the user of this machine, who may do everything that the account may do.
    """

    may_act: bool = True
    is_owner: bool = True

    @classmethod
    def of(cls, role: Role | None) -> Rights:
        """Return the rights of a role; None for the user of this machine."""
        return cls() if role is None else cls(may_act=role.includes(Role.OPERATOR), is_owner=False)

    def check_owner(self) -> None:
        """Check that the user is that of this machine.

        Raises:
            RequestError: It is not.
        """
        if not self.is_owner:
            raise RequestError(
                403,
                "a site for other machines debugs no runs: they would have the rights of its user",
                "start `seoro ui` without `--listen`",
            )


class OnlyReading:
    """Middleware of sites whose users may watch only: it refuses requests that change something.

    Args:
        app: The application.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or WebSocket."""
        serve: Callable[[Scope, Receive, Send], Awaitable[None]] = self._app
        if scope["type"] == "http" and scope["method"] not in READING:
            error = RequestError(
                403, "the keys of this site may watch only (role viewer)", "use a site with keys of an operator"
            )
            serve = answer(error.data, error.status)
        await serve(scope, receive, send)
