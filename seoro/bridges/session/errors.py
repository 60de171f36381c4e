"""What can go wrong with a session."""


class SessionError(Exception):
    """Nothing could be sent: the session did not open, or it is closed."""


class InvalidEndpoint(SessionError):
    """What was given is no endpoint."""


class NoServer(SessionError):
    """Nobody serves the key that was asked."""


class NoAnswer(SessionError):
    """The server took longer than the timeout, or went away while it had the request."""


class NotAuthentic(SessionError):
    """Somebody else has answered, or an answer was changed on its way."""


class Refused(SessionError):
    """The server answered with an error; `payload` is what it sent."""

    def __init__(self, payload: bytes) -> None:
        super().__init__("the request was refused")
        self.payload = payload
