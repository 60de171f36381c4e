"""Sentences that break a rule for a reason."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

_POLICY: Final = "`everybody` is a key of policy files"
EXCEPTIONS: Final[Mapping[tuple[str, str], str]] = {
    ("tests/executor/sandbox/test_sandbox.py", "everybody: {sandbox: required}"): _POLICY,
    ("tests/executor/test_limits.py", "everybody: {bundle: 5000}"): _POLICY,
    ("tests/executor/test_limits.py", "policy.yaml:2: everybody.speed: unknown key x (keys:"): _POLICY,
    ("tests/executor/test_limits.py", "policy.yaml:2: everybody.time: Input should be greater than 0"): _POLICY,
    ("tests/faults/test_disk.py", "everybody: {free: 4, allow: [python]}"): _POLICY,
    (
        "examples/service/service.py",
        'POST /runs {"scenario": "patrol.osc", "parameters": {"pause": "1s"}} starts a run GET '
        "/runs/{id} returns its status, and its verdict at the end GET /runs/{id}/trace streams its "
        "trace as server-sent events DELETE /runs/{id} stops it, and waits for its clean-up",
    ): "a list of requests",
    (
        "benchmarks/emergency_attacks.py",
        "--tries N of each attack at each target (default 100) --targets A,B executor, keyed-executor, "
        "keyed-simulator, bridge (default all) --attacks A,B refused, bomb, largest, waiting (default "
        "all) --cells A:B,... attacks at targets, such as bridge:waiting; instead of --targets and "
        "--attacks --results FILE a line of JSON for each try; tries that are there already are not made"
        " again, so that an interrupted measurement goes on where it was",
    ): "a list of options",
}
"""Reasons by file and sentence, as the check prints it."""
