"""What executors and their clients say to each other: bundles, runs, records. Not among the verbs of nodes.

An executor serves its verbs at `executor_command(...)`, in the form of those of nodes. A run is known by an id
that its client has drawn, so that a submission which is sent twice is one run. What a scenario consists of
travels as blobs, single files that are known by the SHA-256 of their content, and a manifest that says where
they belong.

A trace is a file that only grows, as JSON Lines. A watcher says up to which byte it has it, and the answer waits
until there is more: nothing can be lost or doubled on the way, and who asks late, or seldom, delays nobody.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any

from pydantic import ConfigDict, Field

from seoro.bridges.wire.limits import BYTES, KIBIBYTE, MAX_MESSAGE, MEBIBYTE, Limits
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.proving import CHALLENGE, CLAIM
from seoro.bridges.wire.proving import UNAVAILABLE as UNAVAILABLE  # noqa: PLC0414 - for those who import it from here

MINOR = 3  # of what is said here; grows with what is added
PRIORITIES = 1  # the minor version from which on there are priorities
WORLD_FILES = 2  # and world files
FILMS = 3  # and films
ABSOLUTE_PATHS = 3  # and files that are named by absolute paths
DRY_RUNS = 3  # and dry runs
ROS_SIMULATORS = 3  # and simulators of ROS 2 systems, with worlds that are theirs
CHUNK = 1 << 20  # [bytes] of a blob or a file in one message
MAX_FILES = 10_000  # of a bundle
MAX_FILE = 256 << 20  # [bytes]
MAX_BUNDLE = 1 << 30  # [bytes] of all its files
MAX_PATH = 1024  # [characters]
MAX_TEXT = 10_000  # [characters] of an option
LACKING = 104  # the code of a refusal: blobs of the bundle are not there, and have to be sent
HIGHEST_PRIORITY = 100  # and the lowest, below 0
WINDOW = 256 << 10  # [bytes] of a trace that are sent to one who asks once: a link has room for them
LONGEST_DRY_RUN = 90.0  # [s]
LONGEST_WAIT = 10.0  # [s] for what has not happened yet; clients ask again then

Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
RunId = Annotated[str, Field(pattern=r"^[0-9a-f]{32}$")]
Text = Annotated[str, Field(max_length=MAX_TEXT)]
Place = Annotated[str, Field(min_length=1, max_length=MAX_PATH)]
Limit = Annotated[float, Field(gt=0, allow_inf_nan=False)]  # [s]


class Said(Message):
    """Base of the messages here: a command needs a few of them, and each takes a millisecond to be made ready."""

    model_config = ConfigDict(defer_build=True)


class State(StrEnum):
    """What has become of a run."""

    QUEUED = "queued"
    RUNNING = "running"
    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"
    CANCELLED = "cancelled"
    LOST = "lost"  # its executor died while it ran
    INVALID = "invalid"  # it was not run: the scenario, or how it was to be run, cannot be

    @property
    def is_final(self) -> bool:
        """Whether nothing changes any more."""
        return self not in (State.QUEUED, State.RUNNING)


class BundleFile(Said):
    """A file of a bundle: where it belongs, relative to the bundle's root, and what its content is."""

    path: Place
    hash: Hash
    size: Annotated[int, Field(ge=0, le=MAX_FILE)]


class BundledSimulator(Said):
    """As `seoro.Simulator`; files are those of the bundle, the endpoint is seen from the executor."""

    name: Text | None = None
    endpoint: Text | None = None
    world: Text | None = None
    rate: float
    model_path: tuple[Place, ...] = ()
    snapshot: Place | None = None
    world_file: Place | None = None  # instead of a name of a world
    world_by_uri: bool = False  # whether the simulator is told that file as `file://`


class BundledRos(Said):
    """As `seoro.Ros`."""

    endpoint: Text
    domain: int = 0
    dialect: Text | None = None
    interfaces: tuple[Place, ...] = ()


class BundledLab(Said):
    """As `seoro.Lab`."""

    file: Place
    rate: float | None = None
    model_path: tuple[Place, ...] = ()


class BundledLeasing(Said):
    """As `seoro.embed.options.Leasing`."""

    wait: Annotated[float, Field(ge=0)] | None = None  # which may be infinite
    priority: int = 0
    lease: Text = ""


class BundledFilm(Said):
    """As `seoro.film.Film`."""

    camera: Text = ""
    follow: Text = ""
    width: int
    height: int
    rate: int


class BundledOptions(Said):
    """How the scenario is to be run: as the options of `seoro.start`, with files of the bundle."""

    name: Text | None = None
    seed: int | None = None
    overrides: Annotated[dict[Text, Text], Field(default_factory=dict)]
    parameters: Place | None = None
    clock: Text | None = None
    simulator: BundledSimulator | None = None
    ros: BundledRos | None = None
    lab: BundledLab | None = None
    leasing: BundledLeasing = BundledLeasing()
    grace: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    timeout: Limit | None = None  # [s] of the machine's clock
    timeout_of_file: bool = False  # whether the scenario file gives it, or the sender
    film: BundledFilm | None = None  # to be recorded, as `seoro.film.NAME` among what the run leaves


class Manifest(Said):
    """What is run: the files, which of them is the scenario, what the user calls it, and how it is run."""

    files: Annotated[tuple[BundleFile, ...], Field(min_length=1, max_length=MAX_FILES)]
    entry: Place
    shown: Text
    directory: Text = ""  # what stands for the working directory, relative to the root
    root: Text | None = None  # what the root is called where the bundle was made: an absolute path
    options: BundledOptions


class Hashes(Said):
    """Blobs."""

    hashes: Annotated[tuple[Hash, ...], Field(max_length=MAX_FILES)]


class PutBlob(Said):
    """A part of a blob; parts come in order, and the last completes it. The same part may come again.

    Where those before it are missing, or the whole has another hash, it is refused as an `INCORRECT_STATE`: the
    blob has to be sent anew.

    An executor with keys finds out by itself who sends it, and in which role.
    """

    hash: Hash
    size: Annotated[int, Field(ge=0, le=MAX_FILE)]
    offset: Annotated[int, Field(ge=0)]
    data: Annotated[bytes, Field(max_length=CHUNK)]
    by: Text = ""
    role: Text = ""


class Submission(Said):
    """A run that is asked for; its blobs are there. The same once more is the same run."""

    run: RunId
    manifest: Manifest
    by: Text = ""  # who asks for it, for people
    role: Text = ""  # as what, by their keys; set by the executor
    stop_if_lost: Limit | None = None  # [s] without a watcher after which it is stopped; None to let it live
    priority: Annotated[int, Field(ge=-HIGHEST_PRIORITY, le=HIGHEST_PRIORITY)] = 0  # higher ones run first


class DryRun(Submission):
    """A run that is tried and not carried out; of it, and of the blobs that were sent for it, nothing is kept."""

    sent: Annotated[tuple[Hash, ...], Field(max_length=MAX_FILES)] = ()


class Tried(Said):
    """How a dry run went: what the run would have begun with, or why it cannot be (`seoro.embed.ends`)."""

    seed: int | None = None
    parameters: bytes = b""  # the chosen values, as JSON
    texts: bytes = b"{}"  # the same as the language writes them, as JSON
    end: bytes = b""


class RunInfo(Said):
    """What is known of a run; times are seconds since 1970 by the executor's clock."""

    run: RunId
    file: str  # as the user named it
    by: str
    state: State
    submitted: float
    started: float | None = None
    ended: float | None = None
    reason: str = ""  # of its end, in a line
    announcement: str = ""  # what it runs with, once that is known
    priority: int = 0
    place: int | None = None  # in the queue, from 1 on; None if it does not wait, or for something else
    waits: str = ""  # for robots: which, and who has them
    trace: str = ""  # SHA-256 of its whole trace, of a run that is over; empty if that is unknown


class Runs(Said):
    """Runs, the youngest first."""

    runs: tuple[RunInfo, ...]


class ListRuns(Said):
    """The youngest runs, so many at most; those whose ids begin so."""

    limit: Annotated[int, Field(ge=1, le=1000)] = 100
    prefix: Annotated[str, Field(pattern=r"^[0-9a-f]{0,32}$")] = ""


class OneRun(Said):
    """A run that is meant."""

    run: RunId


class StopRun(OneRun):
    """Stop a run, which cleans up; of no effect on one that is over."""

    reason: Text = ""


class Details(Said):
    """All about a run: `end` is what it ended with (`seoro.embed.ends`); empty while there is none."""

    info: RunInfo
    end: bytes = b""


class AskRecords(OneRun):
    """The records of a run from a byte of its trace on; waits up to `wait` [s] for something that is new."""

    at: Annotated[int, Field(ge=0)] = 0
    state: State | None = None  # as far as the asker knows
    is_announced: bool = False  # whether the asker knows what it runs with
    waits: str | None = None  # for whom it waits, as far as the asker knows; None from one who does not want to
    wait: Annotated[float, Field(ge=0, le=LONGEST_WAIT)] = 0.0
    keeps_alive: bool = False  # whether this watcher is the one whose loss would stop the run
    printed_at: Annotated[int, Field(ge=0)] | None = (
        None  # up to where the asker has what it prints; None: not at all
    )
    in_parts: bool = False  # whether to send what comes at once, `WINDOW` bytes at most, and then the answer


class Records(Said):
    """Whole lines of a trace; `info.state` is final in the answer to one who has them all."""

    lines: bytes
    at: int  # where to go on
    is_complete: bool  # whether nothing comes any more
    info: RunInfo
    end: bytes = b""  # with the last lines: what it ended with, as in `Details`
    printed: bytes = b""  # what its process has printed after `printed_at`


class NewRecords(Said):
    """Whole lines that a trace has grown by: the parts of `Records`."""

    lines: bytes
    at: int  # where to go on


class OutputInfo(Said):
    """A file that a run has left: its path in the output folder, and its size."""

    path: str
    size: int


class Outputs(Said):
    """What a run has left."""

    files: tuple[OutputInfo, ...]


class ReadFile(OneRun):
    """A part of a file of the output folder."""

    path: Place
    offset: Annotated[int, Field(ge=0)] = 0


class FilePart(Said):
    """A part of a file; empty at its end."""

    data: bytes


class ExecutorInfo(Said):
    """What an executor is."""

    version: str  # of seoro
    jobs: int  # how many runs go on at a time
    allowed: tuple[str, ...]  # what scenarios may do that they else may not
    running: int = 0  # how many runs go on now
    waiting: int = 0  # and how many wait
    received: float | None = None  # when the request arrived [s since 1970], by the executor's clock
    sent: float | None = None  # when this left, by the same
    free: int | None = None  # [bytes] of disk, where it keeps runs
    simulators: tuple[str, ...] | None = None  # that it can start
    films: bool | None = None  # whether they can be filmed
    stopped: str = ""  # the emergency stop that keeps runs from beginning, in words
    no_sandbox: str | None = None  # why runs are not sandboxed; empty if they are


class Revoke(Said):
    """A list of revoked keys, which the authority of the lab has signed."""

    data: Annotated[bytes, Field(max_length=CHUNK)]


HASHES = Limits(MEBIBYTE, MAX_FILES + 100)  # of all files of a bundle
PART = Limits(CHUNK + 256 * KIBIBYTE)  # of a file, with two texts
BUNDLE = Limits(16 * MEBIBYTE, 10 * MAX_FILES)  # a manifest of 10,000 files, which has 7 elements for each
FILES = Limits(MAX_MESSAGE, 2_000_000)  # 400,000 files that a run has left

DESCRIBE = Verb("describe", Empty, ExecutorInfo)
MISSING_BLOBS = Verb("missing_blobs", Hashes, Hashes, HASHES)
PUT_BLOB = Verb("put_blob", PutBlob, Empty, PART)
SUBMIT = Verb("submit", Submission, RunInfo, BUNDLE)
DRY_RUN = Verb("dry_run", DryRun, Tried, BUNDLE, BYTES)
LIST_RUNS = Verb("list_runs", ListRuns, Runs)
GET_RUN = Verb("get_run", OneRun, Details, answers=BYTES)
STOP_RUN = Verb("stop_run", StopRun, RunInfo)
RECORDS = Verb("records", AskRecords, Records, answers=BYTES)
LIST_FILES = Verb("list_files", OneRun, Outputs, answers=FILES)
READ_FILE = Verb("read_file", ReadFile, FilePart)
REMOVE_RUN = Verb("remove_run", OneRun, Empty)
REVOKE = Verb("revoke", Revoke, Empty, PART)
EXECUTOR_VERBS: tuple[Verb[Any, Any], ...] = (
    CHALLENGE, CLAIM, DESCRIBE, MISSING_BLOBS, PUT_BLOB, SUBMIT, DRY_RUN, LIST_RUNS, GET_RUN, STOP_RUN, RECORDS,
    LIST_FILES, READ_FILE, REMOVE_RUN, REVOKE,
)  # fmt: skip
