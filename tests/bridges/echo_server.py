"""A process that serves one key, for tests of sessions: `python echo_server.py ENDPOINT`.

It echoes payloads, but refuses `refuse`, never answers `hold`, and kills itself at `die`.
"""

import os
import queue
import sys

from seoro.bridges.session import Request, Session


def main() -> None:
    session = Session(connect=sys.argv[1])
    inbox: queue.SimpleQueue[Request] = queue.SimpleQueue()
    session.serve("seoro/1/default/node/echo/cmd/*", b"busy", inbox)
    session.declare_token("seoro/1/default/alive/node/echo/b1")
    held = []
    while True:
        request = inbox.get()
        match request.payload:
            case b"refuse":
                request.refuse(b"no")
            case b"hold":
                held.append(request)
            case b"die":
                os._exit(1)
            case payload:
                request.reply(payload)


if __name__ == "__main__":
    main()
