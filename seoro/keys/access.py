"""What a router lets whom pass, by role: the access control of Zenoh.

Whatever is not allowed here is dropped without a word. A session is known by the seat in its certificate
(`certificates.py`); one whose seat is revoked, or no seat of ours, gets nothing and can send nothing.

A rule is about a *flow*: what comes from a session (ingress), and what goes to it (egress). Names of keys are
those of `bridges/wire/keys.py`. A pattern such as `seoro/**` does not have the keys below which publishers keep
samples for those who come late: chunks that begin with `@` have to be spelled out.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any, Final

from seoro.keys.certificates import SEATS, Seat
from seoro.keys.roles import NODE_READING, Role, executor_verbs

_ROOT: Final = "seoro/1/*"
_EXECUTORS: Final = f"{_ROOT}/exec/*/cmd"
_NODES: Final = f"{_ROOT}/node/*/cmd"
_STREAMS: Final = (f"{_ROOT}/node/*/st/*", f"{_ROOT}/node/*/st/*/@adv/**")
_TOKENS: Final = "seoro/*/*/alive/**"  # of other versions, too
_EVERYTHING: Final = ("seoro/1/**", "seoro/1/**/@adv/**")
_STOPS: Final = f"{_ROOT}/estop"

_ASKS: Final = ("query",)
_SERVES: Final = ("declare_queryable",)
_ANSWERS: Final = ("reply",)
_PUBLISHES: Final = ("put", "delete")
_SUBSCRIBES: Final = ("declare_subscriber",)
_LIVES: Final = ("liveliness_token",)
_LOOKS: Final = ("liveliness_query", "declare_liveliness_subscriber")
_SENDS: Final = "ingress"
_GETS: Final = "egress"

Rule = tuple[str, tuple[str, ...], Iterable[str]]  # flow, messages, keys


def access_control(revoked: Collection[Seat] = ()) -> dict[str, Any]:
    """The settings of Zenoh's access control.

    Args:
        revoked: Seats that nobody may use any more.
    """
    rules: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    subjects: list[dict[str, Any]] = []
    for role in Role:
        seats = [Seat(role, number) for number in range(1, SEATS + 1)]
        names = [str(seat) for seat in seats if seat not in revoked]
        ids = []
        for number, (flow, messages, keys) in enumerate(_rules(role)):
            ids.append(f"{role.value}_{number}")
            rules.append(
                {
                    "id": ids[-1],
                    "permission": "allow",
                    "flows": [flow],
                    "messages": list(messages),
                    "key_exprs": list(keys),
                }
            )
        if ids and names:
            subjects.append({"id": role.value, "cert_common_names": names})
            policies.append({"rules": ids, "subjects": [role.value]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _rules(role: Role) -> tuple[Rule, ...]:
    """What those of a role may send and get."""
    match role:
        case Role.VIEWER:
            return _looking(role)
        case Role.OPERATOR | Role.ADMIN:
            return (*_looking(role), *_moving())
        case Role.EXECUTOR:
            return (
                *_moving(),
                *_seeing(),
                *_serving(f"{_EXECUTORS}/*", f"{_ROOT}/alive/exec/*/*"),
                (_SENDS, _SUBSCRIBES, (_STOPS,)),
                (_GETS, _PUBLISHES, (_STOPS,)),
            )
        case Role.NODE:
            return (
                *_serving(f"{_NODES}/*", f"{_ROOT}/alive/node/*/*"),
                (_SENDS, (*_PUBLISHES, *_SERVES, *_ANSWERS, *_LIVES), _STREAMS),
                (_GETS, (*_SUBSCRIBES, *_ASKS, *_LOOKS), _STREAMS),
                (_SENDS, (*_LOOKS, *_SUBSCRIBES), (_TOKENS, _STOPS)),
                (_GETS, (*_LIVES, *_PUBLISHES), (_TOKENS, _STOPS)),
            )
        case Role.ROUTER:  # sessions connect to routers, they do not connect to one another
            return ()


def _looking(role: Role) -> tuple[Rule, ...]:
    """What people may: ask executors for what their role may, and see who is there and how robots are."""
    verbs = [f"{_EXECUTORS}/{verb}" for verb in sorted(executor_verbs(role))]
    verbs += [f"{_NODES}/{verb}" for verb in sorted(NODE_READING)]
    return ((_SENDS, _ASKS, verbs), (_GETS, (*_ANSWERS, *_SERVES), verbs), *_seeing())


def _seeing() -> tuple[Rule, ...]:
    return (
        (_SENDS, _LOOKS, (_TOKENS,)),
        (_GETS, _LIVES, (_TOKENS,)),
        (_SENDS, (*_SUBSCRIBES, *_ASKS, *_LOOKS), _STREAMS),
        (_GETS, (*_PUBLISHES, *_ANSWERS, *_SERVES, *_LIVES), _STREAMS),
    )


def _moving() -> tuple[Rule, ...]:
    """Using simulators and robots."""
    holder = f"{_ROOT}/alive/holder/*"
    return (
        (_SENDS, _ASKS, (f"{_NODES}/*",)),
        (_GETS, (*_ANSWERS, *_SERVES), (f"{_NODES}/*",)),
        (_SENDS, _LIVES, (holder,)),
        (_SENDS, _PUBLISHES, (_STOPS,)),
        (_GETS, (*_SUBSCRIBES, *_LOOKS), (_STOPS, _TOKENS)),
    )


def _serving(commands: str, token: str) -> tuple[Rule, ...]:
    return (
        (_SENDS, (*_SERVES, *_ANSWERS), (commands,)),
        (_GETS, _ASKS, (commands,)),
        (_SENDS, _LIVES, (token,)),
        (_GETS, _LOOKS, (token, _TOKENS)),
    )
