"""Errors of sessions."""


class SessionError(Exception):
    """The session did not open, or is closed."""


class InvalidEndpoint(SessionError):
    """The endpoint is invalid."""


class Unanswered(SessionError):
    """No session answers at the endpoint in time."""


class NoServer(SessionError):
    """No session serves the requested key."""


class NoAnswer(SessionError):
    """The server took longer than the timeout, or disconnected before its answer."""


class NotAuthentic(SessionError):
    """An answer comes from another sender, or was changed in transit."""


class Refused(SessionError):
    """The server answered with an error, which is in `payload`."""

    def __init__(self, payload: bytes) -> None:
        super().__init__("the request was refused")
        self.payload = payload
