"""Access control of Zenoh: the messages that a router forwards, by role.

All other messages are dropped silently. A session is identified by the slot in its certificate
(`certificates.py`). Sessions with revoked or unknown slots can neither send nor receive.

Only its owner may use the name of an executor or a node, if the hub knows the name: its own, and those in the list
of revoked keys. Every identity of the role may use an unknown name, so that routers need no update for each new
identity.

A rule is about a *flow*: messages from a session (ingress) or to it (egress). Keys are named in
`bridges/wire/keys.py`. A pattern such as `seoro/**` does not match the keys of samples that publishers keep for
late subscribers: chunks that begin with `@` have to be spelled out.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

from seoro.security.keys.certificates import SLOTS, CertificateSlot
from seoro.security.keys.roles import Role

_ROOT: Final = "seoro/1/*"
_EXECUTORS: Final = f"{_ROOT}/exec/*/cmd"
_NODES: Final = f"{_ROOT}/node/*/cmd"
_STREAMS: Final = (f"{_ROOT}/node/*/st/*", f"{_ROOT}/node/*/st/*/@adv/**")
_TOKENS: Final = "seoro/*/*/alive/**"  # of other versions, too
_STOPS: Final = f"{_ROOT}/estop"

_ASKS: Final = ("query",)
_SERVES: Final = ("declare_queryable",)
_ANSWERS: Final = ("reply",)
_PUBLISHES: Final = ("put", "delete")
_SUBSCRIBES: Final = ("declare_subscriber",)
_LIVES: Final = ("liveliness_token",)
_LOOKS: Final = ("liveliness_query", "declare_liveliness_subscriber")
_CLAIMS: Final = (*_SERVES, *_ANSWERS, *_PUBLISHES, *_LIVES)  # reserved for the owner of a name
_NO_NAMES: Final[Mapping[CertificateSlot, str]] = MappingProxyType({})
_SENDS: Final = "ingress"
_GETS: Final = "egress"

Rule = tuple[str, tuple[str, ...], Iterable[str]]  # flow, messages, keys


def access_control(
    requests: Mapping[Role, Sequence[str]],
    revoked: Collection[CertificateSlot] = (),
    names: Mapping[CertificateSlot, str] = _NO_NAMES,
) -> dict[str, Any]:
    """Return the settings of Zenoh's access control.

    Args:
        requests: Keys of requests that people may send, by role.
        revoked: Revoked slots.
        names: Names of executors and nodes by their slots.
    """
    rules: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    subjects: list[dict[str, Any]] = []
    for role in Role:
        commons = [str(slot) for slot in _slots(role) if slot not in revoked]
        own = [
            _rule(f"{role.value}_{number}", "allow", *rule)
            for number, rule in enumerate(_rules(role, requests.get(role, ())))
        ]
        rules += own
        if own and commons:
            subjects.append({"id": role.value, "cert_common_names": commons})
            policies.append({"rules": [rule["id"] for rule in own], "subjects": [role.value]})
    for owner, name in names.items():
        others = [str(slot) for slot in _slots(owner.role) if slot != owner]
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


def _slots(role: Role) -> list[CertificateSlot]:
    return [CertificateSlot(role, number) for number in range(1, SLOTS + 1)]


def _rule(name: str, permission: str, flow: str, messages: Iterable[str], keys: Iterable[str]) -> dict[str, Any]:
    return {
        "id": name,
        "permission": permission,
        "flows": [flow],
        "messages": list(messages),
        "key_exprs": list(keys),
    }


def _keys_of(role: Role, name: str) -> tuple[str, ...]:
    """Return the keys that are reserved for the executor or node of a name."""
    if role is Role.EXECUTOR:
        return (f"{_ROOT}/exec/{name}/**", f"{_ROOT}/alive/exec/{name}/**")
    return (f"{_ROOT}/node/{name}/**", f"{_ROOT}/node/{name}/st/*/@adv/**", f"{_ROOT}/alive/node/{name}/**")


def _rules(role: Role, requests: Sequence[str]) -> tuple[Rule, ...]:
    """Return the rules of a role, whose people may send the requests."""
    match role:
        case Role.VIEWER:
            return (*_asking(*requests), *_seeing())
        case Role.OPERATOR | Role.ADMIN:
            return (*_asking(*requests), *_seeing(), *_moving())
        case Role.EXECUTOR:
            return (
                *_moving(),
                *_seeing(),
                *_serving(f"{_EXECUTORS}/*", f"{_ROOT}/alive/exec/*/*"),
                *_asking(f"{_EXECUTORS}/claim"),  # of another executor of the same name
                (_SENDS, _SUBSCRIBES, (_STOPS,)),
                (_GETS, _PUBLISHES, (_STOPS,)),
            )
        case Role.NODE:
            return (
                *_serving(f"{_NODES}/*", f"{_ROOT}/alive/node/*/*"),
                *_asking(f"{_NODES}/challenge"),  # of another executor of the same name
                (_SENDS, (*_PUBLISHES, *_SERVES, *_ANSWERS, *_LIVES), _STREAMS),
                (_GETS, (*_SUBSCRIBES, *_ASKS, *_LOOKS), _STREAMS),
                (_SENDS, (*_LOOKS, *_SUBSCRIBES), (_TOKENS, _STOPS)),
                (_GETS, (*_LIVES, *_PUBLISHES), (_TOKENS, _STOPS)),
            )
        case Role.ROUTER | Role.SITE:  # routers do not connect to one another, and sites have no session
            return ()


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
