"""Messages between executors and their clients: bundles, runs and records.

An executor serves its verbs at `executor_command(...)`, in the same form as nodes. The client draws the id of a
run at random, so that a repeated submission is the same run. The files of a scenario are sent as blobs, addressed
by the SHA-256 of their content. A manifest lists their paths.

A trace is a file that only grows, as JSON Lines. A client names the last byte that it has, and the reply waits for
more. So no record is lost or doubled, and slow clients do not delay the run.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from seoro.bridges.wire.authentication import UNAVAILABLE as UNAVAILABLE  # noqa: PLC0414 - re-exported
from seoro.bridges.wire.limits import BYTES, KIBIBYTE, MAX_MESSAGE, MEBIBYTE, Limits
from seoro.bridges.wire.message import Empty, Message, Query, Verb
from seoro.robotics.tracks import MAX_POSE_RATE
from seoro.security.keys.roles import Role

MINOR = 7  # minor version of the protocol; increases with each addition
# Minor versions that introduced a feature.
PRIORITIES = 1
WORLD_FILES = 2
FILMS = 3
ABSOLUTE_PATHS = 3  # names of files in scenarios
DRY_RUNS = 3
ROS_SIMULATORS = 3  # simulators of ROS 2 systems, with their own worlds
EXTERNAL = 4  # events emitted by applications
CAMPAIGNS = 5  # workers of campaigns
POSES = 6  # rate of poses in traces
SCANS = 7  # scans in traces

CHUNK = 1 << 20  # [bytes] of a blob or a file in one message
MAX_FILES = 10_000  # files of a bundle
MAX_FILE = 256 << 20  # [bytes] of a file
MAX_BUNDLE = 1 << 30  # [bytes] of all files of a bundle
MAX_PATH = 1024  # [characters]
MAX_TEXT = 10_000  # [characters] of an option
NOT_EMITTED = 105  # code of a refusal: the event cannot be emitted
MAX_FIELDS = 8 << 10  # [bytes] of the arguments of an event
INCOMPLETE_BUNDLE = 104  # code of a refusal: blobs are missing, and have to be sent again
HIGHEST_PRIORITY = 100  # the lowest priority is its negative
WINDOW = 256 << 10  # [bytes] of a trace in the parts of one reply: a link buffers them
MAX_FOLLOWING = 500  # waiting requests for records of all clients
LONGEST_DRY_RUN = 90.0  # [s]
MAX_PLANNED = 256  # planned runs in one message, and folders of fetched runs
LONGEST_WAIT = 10.0  # [s] maximum wait of a request; clients then repeat it

Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
RunId = Annotated[str, Field(pattern=r"^[0-9a-f]{32}$")]
Text = Annotated[str, Field(max_length=MAX_TEXT)]
PathText = Annotated[str, Field(min_length=1, max_length=MAX_PATH)]
Limit = Annotated[float, Field(gt=0, allow_inf_nan=False)]  # [s]
RunNumber = Annotated[int, Field(ge=1)]  # in a campaign


class ExecutorMessage(Message):
    """Base of messages of executors, built on first use: building takes a millisecond each."""

    model_config = ConfigDict(defer_build=True)


class State(StrEnum):
    """State of a run."""

    QUEUED = "queued"
    RUNNING = "running"
    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"
    CANCELLED = "cancelled"
    LOST = "lost"  # its executor died during the run
    INVALID = "invalid"  # not started: the scenario or an option is invalid

    @property
    def is_final(self) -> bool:
        """Whether the run is over."""
        return self not in (State.QUEUED, State.RUNNING)


class BundleFile(ExecutorMessage):
    """File of a bundle: its path relative to the bundle's root, hash and size."""

    path: PathText
    hash: Hash
    size: Annotated[int, Field(ge=0, le=MAX_FILE)]


class BundledSimulator(ExecutorMessage):
    """See `seoro.Simulator`; files are those of the bundle, the endpoint is reached from the executor."""

    name: Text | None = None
    endpoint: Text | None = None
    world: Text | None = None
    rate: float
    model_path: tuple[PathText, ...] = ()
    snapshot: PathText | None = None
    world_file: PathText | None = None  # replaces the name of a world
    world_parameters: Text | None = None  # of that file, see `seoro.files.world_names`
    world_by_uri: bool = False  # whether the simulator receives that file as `file://`


class BundledRos(ExecutorMessage):
    """See `seoro.Ros`."""

    endpoint: Text
    domain: int = 0
    dialect: Text | None = None
    interfaces: tuple[PathText, ...] = ()


class BundledLab(ExecutorMessage):
    """See `seoro.Lab`."""

    file: PathText
    rate: float | None = None
    model_path: tuple[PathText, ...] = ()


class BundledLeasing(ExecutorMessage):
    """See `seoro.embed.options.Leasing`."""

    wait: Annotated[float, Field(ge=0)] | None = None  # may be infinite
    priority: int = 0
    lease: Text = ""


class BundledFilm(ExecutorMessage):
    """See `seoro.embed.video.VideoOptions`."""

    camera: Text = ""
    follow: Text = ""
    width: int
    height: int
    rate: int


class BundledOptions(ExecutorMessage):
    """Options of a run, as of `seoro.start`, with files of the bundle."""

    name: Text | None = None
    seed: int | None = None
    overrides: Annotated[dict[Text, Text], Field(default_factory=dict)]
    parameters: PathText | None = None
    constraints: tuple[Text, ...] = ()
    clock: Text | None = None
    simulator: BundledSimulator | None = None
    ros: BundledRos | None = None
    lab: BundledLab | None = None
    leasing: BundledLeasing = BundledLeasing()
    grace: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    timeout: Limit | None = None  # [s] of the machine's clock
    timeout_of_file: bool = False  # whether the scenario file sets the timeout, not the client
    poses: Annotated[float, Field(ge=0, le=MAX_POSE_RATE)] | None = None
    scans: Annotated[float, Field(ge=0, le=MAX_POSE_RATE)] = 0.0
    external: tuple[Text, ...] = ()  # events that applications may emit
    film: BundledFilm | None = None  # saved as `seoro.embed.video.NAME` among the output files


class Manifest(ExecutorMessage):
    """Manifest of a bundle: its files, its scenario and the options of the run."""

    files: Annotated[tuple[BundleFile, ...], Field(min_length=1, max_length=MAX_FILES)]
    entry: PathText  # path of the scenario
    shown: Text  # name of the scenario for people
    directory: Text = ""  # working directory, relative to the root
    root: Text | None = None  # absolute path of the root at the client
    options: BundledOptions


class Hashes(ExecutorMessage):
    """Hashes of blobs."""

    hashes: Annotated[tuple[Hash, ...], Field(max_length=MAX_FILES)]


class PutBlob(ExecutorMessage):
    """Part of a blob; parts are sent in order, and the last completes the blob. Parts may be repeated.

    If previous parts are missing, or the hash of the blob differs, it is refused as `INCORRECT_STATE`: the client
    must send the blob from its start. An executor with keys sets `by` and `role` from the signature.
    """

    hash: Hash
    size: Annotated[int, Field(ge=0, le=MAX_FILE)]
    offset: Annotated[int, Field(ge=0)]
    data: Annotated[bytes, Field(max_length=CHUNK)]
    by: Text = ""
    role: Text = ""


class CampaignWorker(ExecutorMessage):
    """Request to make the runs of a campaign that its coordinator gives, see `PlannedRuns`.

    Its trace has a record for each run, with its row. Folders of kept runs are among the output files.
    """

    name: Annotated[str, Field(pattern=r"^[\w-][\w.-]{0,200}$")]  # name of the worker, in its rows
    digest: Hash  # identity of the campaign
    version: Text  # version of seoro; others are refused
    keep: Literal["failed", "all", "none"] = "failed"  # runs that keep their files
    parquet: bool = False  # whether trajectories of kept runs are also written as Parquet
    has_own_python: bool = False  # whether a new Python makes the runs, instead of a copy of a running one


class Submission(ExecutorMessage):
    """Submission of a run, after its blobs. A repetition is the same run."""

    run: RunId
    manifest: Manifest
    by: Text = ""  # name of the client, for people
    role: Text = ""  # role of the client, set by executors with keys
    stop_if_lost: Limit | None = None  # [s] without a client until the run is stopped; None to continue
    priority: Annotated[int, Field(ge=-HIGHEST_PRIORITY, le=HIGHEST_PRIORITY)] = 0  # higher ones run first
    campaign: CampaignWorker | None = None  # to make the runs of a campaign instead of one run


class DryRun(Submission):
    """Dry run of a scenario; the executor keeps neither the run nor the blobs in `sent`."""

    sent: Annotated[tuple[Hash, ...], Field(max_length=MAX_FILES)] = ()


class DryRunResult(ExecutorMessage):
    """Result of a dry run: the chosen values, or the reason of its refusal (`seoro.embed.run_end`)."""

    seed: int | None = None
    parameters: bytes = b""  # the chosen values, as JSON
    texts: bytes = b"{}"  # the same as the language writes them, as JSON
    end: bytes = b""


class RunInfo(ExecutorMessage):
    """State of a run; times are seconds since 1970 by the executor's clock."""

    run: RunId
    file: str  # name of the scenario for people
    by: str
    state: State
    submitted: float
    started: float | None = None
    ended: float | None = None
    reason: str = ""  # reason of its end, one line
    announcement: str = ""  # seed and parameter values, once known
    priority: int = 0
    place: int | None = None  # position in the queue, from 1 on; None outside the queue
    waits: str = ""  # robots that it waits for, and their holders
    trace: str = ""  # SHA-256 of its whole trace; empty if unknown, or before its end
    is_wanted: bool = False  # whether other runs wait for the slot of this worker of a campaign
    scenario: str = ""  # name of the scenario, in lists only; empty if unknown
    robots: tuple[str, ...] = ()  # names of its first robots, in lists only


class Runs(ExecutorMessage):
    """Runs, most recent first."""

    runs: tuple[RunInfo, ...]


class ListRuns(ExecutorMessage):
    """List the most recent runs, up to `limit`, whose ids begin with `prefix`."""

    limit: Annotated[int, Field(ge=1, le=1000)] = 100
    prefix: Annotated[str, Field(pattern=r"^[0-9a-f]{0,32}$")] = ""


class OneRun(ExecutorMessage):
    """A run by its id."""

    run: RunId


class StopRun(OneRun):
    """Stop a run, which cleans up; without effect after its end."""

    reason: Text = ""


class EmitEvent(OneRun):
    """Emit an event in a run; a repetition with the same id is the same emission."""

    emission: RunId
    event: PathText
    fields: Annotated[bytes, Field(max_length=MAX_FIELDS)]  # arguments by name, as a JSON object
    wait: Annotated[float, Field(ge=0, le=LONGEST_WAIT)] = 0.0  # [s] maximum wait for its occurrence


class PlannedRun(ExecutorMessage):
    """Run of a campaign, see `seoro.campaign.runs.Planned`."""

    number: RunNumber
    variant: RunNumber
    repeat: RunNumber
    seed: int
    values: Annotated[dict[Text, Text], Field(default_factory=dict)]
    strategy: Text
    parent: Annotated[int, Field(ge=0)] = 0
    attempt: Annotated[int, Field(ge=1)] = 1


class PlannedRuns(OneRun):
    """Planned runs for a worker of a campaign. Parts are numbered; a repeated one has no effect.

    Folders of the fetched runs are removed at the executor.
    """

    part: Annotated[int, Field(ge=1)]
    runs: Annotated[tuple[PlannedRun, ...], Field(max_length=MAX_PLANNED)]
    fetched: Annotated[tuple[RunNumber, ...], Field(max_length=MAX_PLANNED)] = ()


class Emitted(ExecutorMessage):
    """Result of an emission: its time, or the reason of its refusal."""

    emission: RunId
    time: float | None = None  # [s] on the clock of the run; None before its occurrence
    name: str = ""  # name of the event in the trace
    arguments: bytes = b"{}"  # arguments by name, as a JSON object
    refused: str = ""  # reason of a refusal


class Details(ExecutorMessage):
    """Details of a run; `end` is its result (`seoro.embed.run_end`), empty until it ends."""

    info: RunInfo
    end: bytes = b""


class AskRecords(OneRun):
    """Request the records of a run from a byte of its trace on; waits up to `wait` [s] for a change."""

    at: Annotated[int, Field(ge=0)] = 0
    state: State | None = None  # last state known to the client
    is_announced: bool = False  # whether the client knows the announcement
    waits: str | None = None  # last `RunInfo.waits` known to the client; None to ignore its changes
    wait: Annotated[float, Field(ge=0, le=LONGEST_WAIT)] = 0.0
    keeps_alive: bool = False  # whether the request counts for `stop_if_lost`
    printed_at: Annotated[int, Field(ge=0)] | None = None  # byte of the printed output to continue from
    in_parts: bool = False  # whether to send records at once as `NewRecords`, up to `WINDOW` bytes


class Records(ExecutorMessage):
    """Whole lines of a trace; with the last ones, `info.state` is final."""

    lines: bytes
    at: int  # byte to continue from
    is_complete: bool  # whether these are the last
    info: RunInfo
    end: bytes = b""  # with the last lines: result of the run, as in `Details`
    printed: bytes = b""  # printed output of the run after `printed_at`


class NewRecords(ExecutorMessage):
    """New whole lines of a trace; part of a reply with `Records`."""

    lines: bytes
    at: int  # byte to continue from


class OutputInfo(ExecutorMessage):
    """Output file of a run: its path in the output folder, and its size."""

    path: str
    size: int


class Outputs(ExecutorMessage):
    """Output files of a run."""

    files: tuple[OutputInfo, ...]


class ReadFile(OneRun):
    """Read a part of an output file."""

    path: PathText
    offset: Annotated[int, Field(ge=0)] = 0


class FilePart(ExecutorMessage):
    """Part of a file; empty at its end."""

    data: bytes


class ExecutorInfo(ExecutorMessage):
    """Version, abilities and load of an executor."""

    version: str  # version of seoro
    jobs: int  # number of runs at a time
    allowed: tuple[str, ...]  # permissions of scenarios
    running: int = 0  # number of active runs
    waiting: int = 0  # number of waiting runs
    received: float | None = None  # arrival of the request [s since 1970], by the executor's clock
    sent: float | None = None  # departure of the reply, by the same clock
    free: int | None = None  # free disk space for runs [bytes]
    simulators: tuple[str, ...] | None = None  # installed simulators
    films: bool | None = None  # whether it can record videos
    stopped: str = ""  # reason of an emergency stop
    no_sandbox: str | None = None  # reason why runs are not sandboxed; empty if they are


class Revoke(ExecutorMessage):
    """Install a list of revoked keys, signed by the authority of the lab."""

    data: Annotated[bytes, Field(max_length=CHUNK)]


HASHES = Limits(MEBIBYTE, MAX_FILES + 100)  # all files of a bundle
PART = Limits(CHUNK + 256 * KIBIBYTE)  # a part of a file, with two texts
BUNDLE = Limits(16 * MEBIBYTE, 10 * MAX_FILES)  # a manifest of 10,000 files with 7 elements each
RUNS = Limits(32 * KIBIBYTE, 20_000)  # fits into the pipe of a process
FILES = Limits(MAX_MESSAGE, 2_000_000)  # 400,000 output files

DESCRIBE = Query("describe", Empty, ExecutorInfo, role=Role.VIEWER)
MISSING_BLOBS = Verb("missing_blobs", Hashes, Hashes, HASHES)
PUT_BLOB = Verb("put_blob", PutBlob, Empty, PART)
SUBMIT = Verb("submit", Submission, RunInfo, BUNDLE, is_audited=True)
DRY_RUN = Verb("dry_run", DryRun, DryRunResult, BUNDLE, BYTES, is_audited=True)
LIST_RUNS = Query("list_runs", ListRuns, Runs, role=Role.VIEWER)
GET_RUN = Query("get_run", OneRun, Details, reply_limits=BYTES, role=Role.VIEWER)
STOP_RUN = Verb("stop_run", StopRun, RunInfo, is_audited=True, is_stop=True)
GIVE_RUNS = Verb("give_runs", PlannedRuns, Empty, RUNS)
EMIT_EVENT = Verb("emit_event", EmitEvent, Emitted, is_audited=True)
RECORDS = Query(
    "records", AskRecords, Records, reply_limits=BYTES, role=Role.VIEWER, waits=True, max_pending=MAX_FOLLOWING
)
LIST_FILES = Query("list_files", OneRun, Outputs, reply_limits=FILES, role=Role.VIEWER)
READ_FILE = Query("read_file", ReadFile, FilePart, role=Role.VIEWER)
REMOVE_RUN = Verb("remove_run", OneRun, Empty, is_audited=True)
REVOKE = Verb("revoke", Revoke, Empty, PART, role=Role.ADMIN, is_audited=True)
