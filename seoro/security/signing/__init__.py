"""Signatures: who sent a command, an answer or a statement, and whether it arrived unchanged.

- `commands` signs and verifies requests to executors and nodes.
- `answers` authenticates answers, and the requests of clients that hold robots (each once: `replay_window`).
- `statements` signs facts about executors and nodes.
- `audit_log` writes and checks a log of signed lines.

May import `seoro.security.keys`, `seoro.concurrency` (the steady clock), `seoro.errors` and `seoro.files`.
"""
