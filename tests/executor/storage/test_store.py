"""Storage of executors."""

import hashlib
import math
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace

import msgpack
import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import State
from seoro.bridges.wire.message import WireError, decode
from seoro.bridges.wire.refusal import RequestRefused
from seoro.errors import UsageError
from seoro.executor.limits import Limits
from seoro.executor.storage.blobs import Blobs, make_room
from seoro.executor.storage.store import Finished, open_store

RUN = "0123456789abcdef" * 2
OTHER = "f" * 32
NOBODY = 65534  # the number of a user


def submission(run: str = RUN) -> wire.Submission:
    file = wire.BundleFile(path="main.osc", hash="0" * 64, size=1)
    options = wire.BundledOptions(grace=5.0, overrides={})
    return wire.Submission(
        run=run, manifest=wire.Manifest(files=(file,), entry="main.osc", shown="main.osc", options=options)
    )


async def test_adding_a_run_twice_stores_it_once(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        await store.add(submission())
        await store.start(RUN)
        assert (await store.add(submission())).state is State.RUNNING
        assert [info.run for info in await store.youngest(10)] == [RUN]


async def test_stored_runs_survive_a_restart(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        await store.add(submission())
        await store.add(submission(OTHER))
        await store.start(RUN)
        await store.finish(RUN, Finished(State.FAILED, "because", b"end", 1.0))
    with open_store(tmp_path) as store:
        info = await store.info(RUN)
        assert (info.state, info.reason, await store.end(RUN)) == (State.FAILED, "because", b"end")
        assert await store.queued() == (OTHER,)
        assert await store.submission(OTHER) == submission(OTHER)


async def test_runs_of_a_dead_executor_are_lost_and_queued_ones_remain(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        await store.add(submission())
        await store.add(submission(OTHER))
        await store.start(RUN)
        assert await store.mark_lost() == 1
        assert (await store.info(RUN)).state is State.LOST
        assert (await store.info(OTHER)).state is State.QUEUED


async def test_an_incomplete_submission_is_removed(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        (tmp_path / "runs" / RUN).mkdir()
        await store.sweep()
        assert not (tmp_path / "runs" / RUN).exists()


async def test_runs_are_found_by_id_prefixes(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        await store.add(submission())
        await store.add(submission(OTHER))
        assert [info.run for info in await store.youngest(10, "0123")] == [RUN]


async def test_a_removed_run_is_deleted_with_its_files(tmp_path: Path) -> None:
    with open_store(tmp_path) as store:
        await store.add(submission())
        store.folder(RUN).output.mkdir(parents=True)
        await store.remove(RUN)
        assert not store.folder(RUN).path.exists()
        with pytest.raises(KeyError):
            await store.info(RUN)


@pytest.fixture
def theirs() -> Iterator[Path]:
    """Yield a folder as a user who is subject to permissions, unlike the superuser."""
    with TemporaryDirectory() as folder:
        is_root = os.geteuid() == 0
        if is_root:
            os.chown(folder, NOBODY, NOBODY)
            os.seteuid(NOBODY)
        try:
            yield Path(folder)
        finally:
            if is_root:
                os.seteuid(0)


async def test_unwritable_folders_of_a_run_are_removed_but_not_link_targets(theirs: Path) -> None:
    elsewhere = theirs / "elsewhere"
    elsewhere.mkdir()
    elsewhere.chmod(0o500)
    with open_store(theirs / "state") as store:
        await store.add(submission())
        closed = store.folder(RUN).output / "cache" / "inner"
        closed.mkdir(parents=True)
        (closed / "file").write_text("x")
        (closed / "link").symlink_to(elsewhere)
        closed.chmod(0o000)
        closed.parent.chmod(0o500)
        await store.remove(RUN)
        assert not store.folder(RUN).path.exists()
        assert await store.known() == frozenset()
    assert elsewhere.stat().st_mode & 0o777 == 0o500


@pytest.mark.parametrize(
    ("fields", "options"),
    [
        ({"stop_if_lost": math.nan}, {}),
        ({"stop_if_lost": math.inf}, {}),
        ({"stop_if_lost": 0.0}, {}),
        ({}, {"timeout": math.nan}),
        ({}, {"timeout": math.inf}),
        ({}, {"grace": math.nan}),
        ({}, {"grace": math.inf}),
        ({}, {"leasing": {"wait": math.nan}}),
        ({}, {"leasing": {"wait": -1.0}}),
    ],
)
def test_submissions_with_invalid_times_are_refused(fields: dict[str, object], options: dict[str, object]) -> None:
    whole = submission().model_dump() | fields
    whole["manifest"]["options"] = {"grace": 5.0} | options
    with pytest.raises(WireError, match=r"greater than|finite"):
        decode(wire.Submission, msgpack.packb(whole))


def test_the_folder_of_another_executor_is_refused(tmp_path: Path) -> None:
    with open_store(tmp_path), pytest.raises(UsageError, match="another executor"), open_store(tmp_path):
        pass


def test_a_folder_of_another_version_is_refused(tmp_path: Path) -> None:
    with open_store(tmp_path):
        pass
    with sqlite3.connect(tmp_path / "runs.sqlite") as database:
        database.execute("PRAGMA user_version = 99")
    database.close()
    with pytest.raises(UsageError, match="another version"), open_store(tmp_path):
        pass


async def test_a_folder_of_an_earlier_version_is_migrated(tmp_path: Path) -> None:
    """Runs of the earlier version have no priorities and trace hashes."""
    with open_store(tmp_path) as store:
        await store.add(submission())
        await store.finish(RUN, Finished(State.PASSED, "", b"", 1.0, "abc"))
        assert (await store.info(RUN)).trace == "abc"
    with closing(sqlite3.connect(tmp_path / "runs.sqlite")) as database:
        database.executescript("ALTER TABLE runs DROP COLUMN trace; ALTER TABLE runs DROP COLUMN priority;")
        database.execute("PRAGMA user_version = 1")
        database.commit()
    with open_store(tmp_path) as store:
        info = await store.info(RUN)
    assert (info.state, info.priority, info.trace) == (State.PASSED, 0, "")


def test_an_unwritable_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(UsageError, match=r"cannot store runs in .*/file: .*/file is not a folder"),
        open_store(tmp_path / "file"),
    ):
        pass


# ---------------------------------------------------------------- blobs

DATA = b"0123456789"
HASH = hashlib.sha256(DATA).hexdigest()


def part(offset: int, data: bytes, size: int = len(DATA)) -> wire.PutBlob:
    return wire.PutBlob(hash=HASH, size=size, offset=offset, data=data)


def test_a_blob_arrives_in_parts_and_may_restart(tmp_path: Path) -> None:
    blobs = Blobs(tmp_path)
    blobs.put(part(0, DATA[:4]))
    assert blobs.missing([HASH]) == (HASH,)
    blobs.put(part(0, DATA[:6]))
    blobs.put(part(6, DATA[6:]))
    assert blobs.missing([HASH]) == ()
    assert blobs.path(HASH).read_bytes() == DATA
    blobs.put(part(0, b"xxxx"))  # it is there, and stays
    assert blobs.path(HASH).read_bytes() == DATA


def test_parts_out_of_turn_and_too_long_blobs_are_refused(tmp_path: Path) -> None:
    blobs = Blobs(tmp_path)
    with pytest.raises(RequestRefused, match="expected byte"):
        blobs.put(part(4, DATA[4:]))
    blobs.put(part(0, DATA[:2]))
    with pytest.raises(RequestRefused, match="expected byte 2"):
        blobs.put(part(4, DATA[4:]))
    with pytest.raises(RequestRefused, match="longer"):
        blobs.put(part(0, DATA, size=4))


def test_repeated_parts_change_nothing(tmp_path: Path) -> None:
    blobs = Blobs(tmp_path)
    blobs.put(part(0, DATA[:4]))
    blobs.put(part(4, DATA[4:8]))
    blobs.put(part(4, DATA[4:8]))  # the answer was lost
    blobs.put(part(0, DATA[:4]))  # another sends the same
    blobs.put(part(8, DATA[8:]))
    blobs.put(part(4, DATA[4:8]))
    assert blobs.path(HASH).read_bytes() == DATA
    assert [path.name for path in tmp_path.iterdir()] == [HASH]


def test_parts_with_another_size_than_the_first_are_refused(tmp_path: Path) -> None:
    blobs = Blobs(tmp_path)
    blobs.put(part(0, DATA[:1], size=2), kept=5)
    with pytest.raises(RequestRefused, match="expected byte 0"):
        blobs.put(part(1, DATA[1:]), kept=5)
    assert blobs.missing([HASH]) == (HASH,)
    with pytest.raises(RequestRefused, match=r"exceeds your quota of"):
        blobs.put(part(0, DATA[:1]), kept=5)
    blobs.put(part(0, DATA[:1]))  # false parts do not prevent others from sending it
    blobs.put(part(1, DATA[1:]))
    assert blobs.missing([HASH]) == ()


def test_an_incomplete_blob_of_an_earlier_executor_restarts(tmp_path: Path) -> None:
    Blobs(tmp_path).put(part(0, b"xxxx"))
    blobs = Blobs(tmp_path)
    with pytest.raises(RequestRefused, match="expected byte"):
        blobs.put(part(4, DATA[4:]))
    blobs.put(part(0, DATA[:4]))
    blobs.put(part(4, DATA[4:]))
    assert blobs.missing([HASH]) == ()


def test_a_blob_with_a_wrong_hash_is_refused_and_leaves_no_file(tmp_path: Path) -> None:
    blobs = Blobs(tmp_path)
    with pytest.raises(RequestRefused, match="does not match its hash"):
        blobs.put(part(0, b"x" * len(DATA)))
    assert list(tmp_path.iterdir()) == []


def test_old_blobs_are_removed(tmp_path: Path) -> None:
    blobs = Blobs(tmp_path)
    blobs.put(part(0, DATA))
    written = blobs.path(HASH).stat().st_mtime
    blobs.remove_old(written - 1.0)
    assert blobs.missing([HASH]) == ()
    blobs.remove_old(written + 1.0)
    assert blobs.missing([HASH]) == (HASH,)


def sent(blobs: Blobs, by: str, content: str, kept: int = 10) -> str:
    """Store a blob of five bytes of a client with a quota; return its hash."""
    digest = hashlib.sha256(content.encode()).hexdigest()
    blobs.put(wire.PutBlob(hash=digest, size=5, offset=0, data=content.encode(), by=by), kept)
    return digest


def test_the_latest_blobs_of_a_user_are_kept(tmp_path: Path) -> None:
    blobs = Blobs(tmp_path)
    others = sent(blobs, "vera", "other")
    first, second = sent(blobs, "anna", "first"), sent(blobs, "anna", "secnd")
    blobs.use([first])
    third = sent(blobs, "anna", "third")
    assert blobs.missing([others, first, second, third]) == (second,)
    with pytest.raises(RequestRefused, match=r"exceeds your quota of"):
        sent(blobs, "anna", "forth", kept=4)
    blobs.drop([first, third, others], "anna")
    assert blobs.missing([others, first, third]) == (first, third)
    fifth, sixth = sent(blobs, "anna", "fifth"), sent(blobs, "anna", "sixth")
    assert blobs.missing([fifth, sixth]) == ()


def test_old_blobs_are_removed_for_disk_space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blobs = Blobs(tmp_path)
    digests = [sent(blobs, "anna", f"blob{number}", kept=100) for number in range(4)]
    for number, digest in enumerate(digests):
        os.utime(blobs.path(digest), (number, number))

    def usage(folder: Path) -> SimpleNamespace:
        left = 30 - 5 * len(list(folder.iterdir()))
        return SimpleNamespace(total=100, free=left)

    monkeypatch.setattr("seoro.executor.storage.blobs.shutil.disk_usage", usage)
    make_room(blobs, tmp_path, 5, Limits(), ())  # there are 10, of which 5 stay free
    assert blobs.missing(digests) == ()
    make_room(blobs, tmp_path, 10, Limits(), {digests[0]})
    assert blobs.missing(digests) == (digests[1],)
    with pytest.raises(RequestRefused, match=r"its disk has .* left, of which .* stay free"):
        make_room(blobs, tmp_path, 50, Limits(), {digests[3]})
    assert blobs.missing(digests) == tuple(digests[:3])
    with pytest.raises(RequestRefused):
        make_room(blobs, tmp_path, 0, Limits(free=1), ())
