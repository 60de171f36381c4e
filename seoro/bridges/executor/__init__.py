"""Executors for their clients.

- `messages.py`, `probing.py`, `verbs.py`: messages and verbs.
- `finding.py`: discovery.
- `asking.py`: requests, which are repeated after a lost connection.

May import `session`, `wire` and `seoro.security`.
"""
