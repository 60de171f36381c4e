"""What a router lets whom pass, by role: the access control of Zenoh.

Whatever is not allowed here is dropped without a word. A session is known by the seat in its certificate
(`certificates.py`); one whose seat is revoked, or no seat of ours, gets nothing and can send nothing.

Only its owner may use the name of an executor or a node, as far as names are known: a hub knows its own, and those
in the list of revoked keys. A name that is not known may be used by all of that role, so that nobody has to tell
routers of each new identity.

A rule is about a *flow*: what comes from a session (ingress), and what goes to it (egress). Names of keys are
those of `bridges/wire/keys.py`. A pattern such as `seoro/**` does not have the keys below which publishers keep
samples for those who come late: chunks that begin with `@` have to be spelled out.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType
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
_CLAIMS: Final = (*_SERVES, *_ANSWERS, *_PUBLISHES, *_LIVES)  # what only the owner of a name may say
_NO_NAMES: Final[Mapping[Seat, str]] = MappingProxyType({})
_SENDS: Final = "ingress"
_GETS: Final = "egress"

Rule = tuple[str, tuple[str, ...], Iterable[str]]  # flow, messages, keys


def access_control(revoked: Collection[Seat] = (), names: Mapping[Seat, str] = _NO_NAMES) -> dict[str, Any]:
    """The settings of Zenoh's access control.

    Args:
        revoked: Seats that nobody may use any more.
        names: Of executors and nodes.
    """
    rules: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    subjects: list[dict[str, Any]] = []
    for role in Role:
        commons = [str(seat) for seat in _seats(role) if seat not in revoked]
        said = [_rule(f"{role.value}_{number}", "allow", *rule) for number, rule in enumerate(_rules(role))]
        rules += said
        if said and commons:
            subjects.append({"id": role.value, "cert_common_names": commons})
            policies.append({"rules": [rule["id"] for rule in said], "subjects": [role.value]})
    for owner, name in names.items():
        others = [str(seat) for seat in _seats(owner.role) if seat != owner]
        subject = f"not_{owner}"
        rules.append(_rule(subject, "deny", _SENDS, _CLAIMS, _keys_of(owner.role, name)))
        subjects.append({"id": subject, "cert_common_names": others})
        policies.append({"rules": [subject], "subjects": [subject]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _seats(role: Role) -> list[Seat]:
    return [Seat(role, number) for number in range(1, SEATS + 1)]


def _rule(name: str, permission: str, flow: str, messages: Iterable[str], keys: Iterable[str]) -> dict[str, Any]:
    return {
        "id": name,
        "permission": permission,
        "flows": [flow],
        "messages": list(messages),
        "key_exprs": list(keys),
    }


def _keys_of(role: Role, name: str) -> tuple[str, ...]:
    """On which only the executor or the node of a name may say something."""
    if role is Role.EXECUTOR:
        return (f"{_ROOT}/exec/{name}/**", f"{_ROOT}/alive/exec/{name}/**")
    return (f"{_ROOT}/node/{name}/**", f"{_ROOT}/node/{name}/st/*/@adv/**", f"{_ROOT}/alive/node/{name}/**")


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
                *_asking(f"{_EXECUTORS}/claim"),  # of another one of the same name
                (_SENDS, _SUBSCRIBES, (_STOPS,)),
                (_GETS, _PUBLISHES, (_STOPS,)),
            )
        case Role.NODE:
            return (
                *_serving(f"{_NODES}/*", f"{_ROOT}/alive/node/*/*"),
                *_asking(f"{_NODES}/challenge"),  # of another one of the same name
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
    return (*_asking(*verbs), *_seeing())


def _asking(*keys: str) -> tuple[Rule, ...]:
    return ((_SENDS, _ASKS, keys), (_GETS, (*_ANSWERS, *_SERVES), keys))


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
        *_asking(f"{_NODES}/*"),
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
