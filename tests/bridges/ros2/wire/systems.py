"""Invented nodes and endpoints."""

from dataclasses import replace

from hypothesis import strategies as st

from seoro.bridges.ros2.wire import Durability, Endpoint, History, Kind, Liveliness, Node, Qos, Reliability

LETTERS = "abzAZ_"
TOKENS = st.builds("{}{}".format, st.sampled_from(LETTERS), st.text(LETTERS + "059", max_size=8))
NAMES = st.lists(TOKENS, min_size=1, max_size=4).map(lambda parts: "/" + "/".join(parts))
NAMESPACES = st.just("/") | NAMES
TYPES = st.builds(
    "{}/{}/{}".format,
    st.sampled_from(["std_msgs", "a_b2_msgs"]),
    st.sampled_from(["msg", "srv", "action"]),
    st.sampled_from(["String", "Int32", "A", "SetBool_Request", "Spin_SendGoal_Response"]),
)
HASHES = st.none() | st.integers(0, 2**256 - 1).map("RIHS01_{:064x}".format)
SESSIONS = st.integers(0, 2**128 - 1).map("{:x}".format)
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
    """Return the announcement of the bridge."""
    return replace(qos, deadline=None, lifespan=None, lease=None, liveliness=Liveliness.AUTOMATIC)
