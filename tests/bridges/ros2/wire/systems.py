"""Made-up nodes and endpoints."""

from dataclasses import replace

from hypothesis import strategies as st

from seoro.bridges.ros2.wire import Durability, Endpoint, History, Kind, Liveliness, Node, Qos, Reliability

TOKENS = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,8}", fullmatch=True)
NAMES = st.lists(TOKENS, min_size=1, max_size=4).map(lambda parts: "/" + "/".join(parts))
NAMESPACES = st.just("/") | NAMES
TYPES = st.builds(
    "{}/{}/{}".format,
    st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True),
    st.sampled_from(["msg", "srv", "action"]),
    st.from_regex(r"[A-Z][A-Za-z0-9]{0,8}(_Request)?", fullmatch=True),
)
HASHES = st.none() | st.from_regex(r"RIHS01_[0-9a-f]{64}", fullmatch=True)
SESSIONS = st.from_regex(r"[0-9a-f]{1,32}", fullmatch=True)
NUMBERS = st.integers(0, 2**31)
TIMES = st.none() | st.integers(1, 2**63 - 2)

QOS = st.builds(
    Qos,
    st.sampled_from(Reliability),
    st.sampled_from(Durability),
    st.sampled_from(History),
    st.integers(1, 2**31 - 1),
    TIMES,
    TIMES,
    st.sampled_from(Liveliness),
    TIMES,
)
NODES = st.builds(Node, SESSIONS, NUMBERS, TOKENS, NAMESPACES, NAMESPACES)
KINDS = st.sampled_from([Kind.PUBLISHER, Kind.SUBSCRIPTION, Kind.SERVER, Kind.CLIENT])


@st.composite
def endpoints(draw: st.DrawFn) -> Endpoint:
    node = draw(NODES)
    return Endpoint(
        draw(KINDS), draw(NAMES), draw(TYPES), node.session, draw(HASHES), draw(QOS), draw(NUMBERS), node
    )


def without_times(qos: Qos) -> Qos:
    """What the bridge tells of it."""
    return replace(qos, deadline=None, lifespan=None, lease=None, liveliness=Liveliness.AUTOMATIC)
