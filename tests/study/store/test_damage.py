"""Stores that are damaged at random: each is read, or refused in a line that names a whole copy.

STUDY_DAMAGES (40) says how many, STUDY_KILL_SEED which; `make test-kill` does 500.
"""

from __future__ import annotations

import errno
import json
import os
import random
import shutil
import sqlite3
import stat
from collections import Counter
from pathlib import Path

import pytest
from together import together

from hmdwarp.base import InputError, MachineError
from hmdwarp.study.store import COPY, DATABASE, Contents, Store

from .sessions import asks, begun, go_through, sql, whole

DAMAGES = int(os.environ.get("STUDY_DAMAGES", "40"))
SEED = int(os.environ.get("STUDY_KILL_SEED", "1"))
TRACE = "time_ns,x_m,y_m,z_m,qx,qy,qz,qw\n" + "".join(f"{k},0,1.6,0,0,0,0,1\n" for k in range(50))


@pytest.fixture(scope="module")
def stores(tmp_path_factory) -> dict[str, Path]:
    """A study of five people: closed, cut off in a sixth session, an older copy; and another."""
    place = tmp_path_factory.mktemp("stores")
    with Store(place / "closed", create=True) as store:
        for k in range(5):
            session = begun(store, f"P{k}", facts={"gpu": "llvmpipe", "seed": k})
            go_through(store, session, 1 + k / 4, TRACE)
            for showing in store.contents().showings[::2]:
                store.measured(showing.id, {"psnr_db": 20 + showing.id / 7, "size": [320, 400]})
            store.end(session, "complete")
            if k == 2:
                shutil.copytree(place / "closed", place / "older")
    shutil.copytree(place / "closed", place / "running")
    with Store(place / "running") as store:
        session = begun(store, "P5")
        for ask in asks(session)[:6]:
            store.answer(session, ask, 2.5, 1.0, "participant", text="blurred")
        shutil.copytree(place / "running", place / "cut-off")  # as a program leaves it that is killed
    with Store(place / "other", create=True) as store:
        for k in range(7):
            whole(store, f"X{k}")
        shutil.copytree(place / "other", place / "others-log")
    return {path.name: path for path in place.iterdir()}


def held(contents: Contents) -> dict[str, list]:
    """All that is in a store, but its folder."""
    return {name: list(getattr(contents, name)) for name in ("name", "sessions", "answers", "showings", "events")}


def flipped(path: Path, chance: random.Random) -> None:
    data = bytearray(path.read_bytes())
    for _ in range(chance.choice((1, 1, 1, 2, 8))):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    path.write_bytes(data)


def overwritten(path: Path, chance: random.Random) -> None:
    data = bytearray(path.read_bytes())
    size, unit = chance.choice(((4096, 4096), (4096, 4096), (512, 512), (100, 1)))
    at = chance.randrange(max(len(data) - size, 0) // unit + 1) * unit
    data[at : at + size] = chance.choice((bytes(size), chance.randbytes(size), data[:size]))
    path.write_bytes(data)


def cut(path: Path, chance: random.Random) -> None:
    size = path.stat().st_size
    os.truncate(path, chance.choice((0, chance.randrange(size), size // 4096 // 2 * 4096)))


def gone(path: Path, chance: random.Random) -> None:
    path.unlink()


def a_folder(path: Path, chance: random.Random) -> None:
    path.unlink()
    path.mkdir()


def another_kind(path: Path, chance: random.Random) -> None:
    path.unlink()
    chance.choice((os.mkfifo, lambda p: p.write_text("ratings: 3, 4, 5\n"), lambda p: p.symlink_to(p)))(path)


def another_program_s(path: Path, chance: random.Random) -> None:
    path.unlink()
    sql(path, "CREATE TABLE bookmarks (url)")


SCHEMAS = [
    "PRAGMA user_version = 0", "PRAGMA user_version = 9", "PRAGMA application_id = 0", "DROP TABLE event",
    "ALTER TABLE answer DROP COLUMN seconds", "ALTER TABLE answer RENAME TO replies",
    "DELETE FROM participant WHERE id = 2", "UPDATE answer SET value = value + 1 WHERE id = 3",
    "UPDATE event SET data = '[]' WHERE id = 5", "DELETE FROM event WHERE id > 20",
    "UPDATE sqlite_sequence SET seq = x'ff' WHERE name = 'event'", "UPDATE session SET facts = 'x' WHERE id = 2",
    "UPDATE answer SET value = x'00' WHERE id = 4", "UPDATE showing SET measured = '[1]' WHERE id = 3",
]  # fmt: skip


def another_schema(path: Path, chance: random.Random) -> None:
    sql(path, chance.choice(SCHEMAS))


def may_not_be_read(path: Path, chance: random.Random) -> None:
    path.chmod(0)  # which stops nobody who is root


OF_THE_FILE = (
    *(flipped, flipped, flipped, overwritten, overwritten, cut, gone, a_folder, another_kind, another_program_s),
    *(another_schema, may_not_be_read),
)
# These may change a value, which SQLite does not notice, or put another sound store in place.
OF_VALUES = ("flipped", "overwritten", "another_schema", "swapped", "log flipped", "log overwritten", "log cut")
OF_THE_LOG = (flipped, flipped, overwritten, cut, gone, gone, a_folder)


def one(stores: dict[str, Path], folder: Path, chance: random.Random) -> tuple[str, str]:
    """Damage a copy. Returns the kind of store and of damage."""
    kind = chance.choice(("closed", "cut-off"))
    shutil.copytree(stores[kind], folder)
    way = chance.random()
    if way < 0.1:
        other = stores[chance.choice(("older", "other", "older"))]  # another store, or an older copy of this
        shutil.copyfile(other / DATABASE, folder / DATABASE)
        return kind, "swapped"
    if way < 0.4 and kind == "cut-off":
        damage = chance.choice(OF_THE_LOG)
        damage(folder / f"{DATABASE}-wal", chance)
        return kind, f"log {damage.__name__}"
    if way < 0.45:
        a_folder(folder / "lock", chance)
        return kind, "lock a_folder"
    damage = chance.choice(OF_THE_FILE)
    damage(folder / DATABASE, chance)
    return kind, damage.__name__


@pytest.mark.slow(20)
def test_a_damaged_store_is_read_or_refused_with_its_copy_and_the_copy_is_whole(stores, tmp_path, capsys):
    """Never a fault of the program's; the damaged file stays as it is. What can only be damage of
    the file itself, and not of a value in it, is never read as something else.
    """
    whole_: dict[str, dict[str, list]] = {}
    for kind in ("closed", "cut-off"):
        with Store(stores[kind]) as store:
            whole_[kind] = held(store.contents())
    tally = Counter()
    for number in range(DAMAGES):
        chance = random.Random(f"{SEED}-{number}")
        folder, new = tmp_path / "data", tmp_path / "new"
        for path in (folder, new):
            shutil.rmtree(path, ignore_errors=True)
        kind, damage = one(stores, folder, chance)
        database = folder / DATABASE
        left = database.read_bytes() if database.is_file() and os.access(database, os.R_OK) else b""
        where = f"STUDY_KILL_SEED={SEED}, number {number}: {kind}, {damage}"
        try:
            with Store(folder) as store:
                found = held(store.contents())
            assert found == whole_[kind] or damage in OF_VALUES, where
            tally["read as it was" if found == whole_[kind] else "read with another value"] += 1
            continue
        except (InputError, MachineError) as error:
            said = str(error)
            assert "\n" not in said and str(folder) in said, where
        tally["refused"] += 1
        # Of these other lines may tell as well.
        other = ("another_program_s", "another_schema", "flipped", "a_folder", "log a_folder")
        assert f"the newest copy, {folder / COPY}, is of" in said or damage in other, f"{where}: {said}"
        for act in (lambda store: begun(store, "Q1"), lambda store: store.resume("P5")):
            with pytest.raises((InputError, MachineError)), Store(folder, create=True) as store:
                act(store)
        with Store(by_the_line(folder, new)) as store:
            assert held(store.contents()) == whole_["closed"], where
            begun(store, "Q2")
        assert not left or database.read_bytes() == left, where
    with capsys.disabled():
        told = ", ".join(f"{count} {what}" for what, count in sorted(tally.items()))
        print(f"\n{DAMAGES} damages, seed {SEED}: {told}")
    assert tally["refused"] > DAMAGES / 4


def by_the_line(folder: Path, new: Path) -> Path:
    """What the line says: a copy of the folder, with the store's copy in place of the database."""
    new.mkdir()
    for path in folder.iterdir():
        if path.name not in (DATABASE, f"{DATABASE}-wal", f"{DATABASE}-shm", "lock"):
            (shutil.copytree if path.is_dir() else shutil.copy)(path, new / path.name)
    return (new / COPY).rename(new / DATABASE).parent


def test_the_copy_is_of_the_last_session_s_end_and_sound(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        first = begun(store, "P1")
        assert not (tmp_path / "data" / COPY).exists()
        go_through(store, first)
        store.end(first, "complete")
        ended = held(store.contents())
        begun(store, "P2")
    copy = tmp_path / "data" / COPY
    assert stat.S_IMODE(copy.stat().st_mode) == 0o600
    with Store(by_the_line(tmp_path / "data", tmp_path / "new")) as store:
        assert held(store.contents()) == ended
    with Store(tmp_path / "data") as store:
        store.end(store.resume("P2"), "interrupted")
    with Store(by_the_line(tmp_path / "data", tmp_path / "newer")) as store:
        assert [session.status for session in store.contents().sessions] == ["complete", "interrupted"]
        assert store.resume("P2").number == 1


def test_a_copy_that_cannot_be_written_costs_no_session_and_leaves_the_one_before(tmp_path, monkeypatch):
    said: list[str] = []
    with Store(tmp_path / "data", create=True, say=said.append) as store:
        whole(store, "P1")
        before = (tmp_path / "data" / COPY).read_bytes()

        def full(path: Path) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr("hmdwarp.study.store.database.sync", full)
        assert whole(store, "P2").status == "complete"
        assert "the store's copy could not be renewed" in said[-1] and "No space left" in said[-1]
    names = {path.name for path in (tmp_path / "data").iterdir()}
    assert names == {DATABASE, COPY, "lock", "traces"}
    assert (tmp_path / "data" / COPY).read_bytes() == before


def emptied(file: Path) -> None:
    """As of a folder whose files were moved away, but for the traces and the copy."""
    for path in file.parent.glob(f"{DATABASE}*"):
        path.unlink()
    (file.parent / "lock").unlink()


SPOILT = [  # what is done to the database, what is said of it
    (lambda file: file.write_bytes(b"ratings: 3, 4, 5\n" * 100), "no database"),
    (lambda file: another_program_s(file, random.Random(0)), "not of an hmdwarp study"),
    (lambda file: sql(file, "PRAGMA user_version = 99"), "newer hmdwarp (schema 99; this one knows 1)"),
    (lambda file: os.truncate(file, file.stat().st_size // 2 // 4096 * 4096), "damaged"),
    (emptied, "there were sessions"),
]


@together("spoil, why", SPOILT)
def test_what_is_no_store_is_told_as_what_it_is(stores, tmp_path, spoil, why):
    for copy in ("the newest copy, ", "there is no copy, as no session has ended"):
        shutil.rmtree(tmp_path / "data", ignore_errors=True)
        shutil.copytree(stores["closed"], tmp_path / "data")
        if "no copy" in copy:
            (tmp_path / "data" / COPY).unlink()
        spoil(tmp_path / "data" / DATABASE)
        with pytest.raises(InputError) as error, Store(tmp_path / "data", create=True) as store:
            store.contents()
        assert why in str(error.value)
        assert copy in str(error.value) or why not in ("no database", "damaged")


def test_a_store_of_0_2_with_checksums_is_read(tmp_path):
    """It has them in its journal, in its figures and in the lock's words."""
    with Store(tmp_path / "data", create=True) as store:
        whole(store, "P1")
        store.measured(store.contents().showings[0].id, {"psnr_db": 20.0})
        before = held(store.contents())
    with sqlite3.connect(tmp_path / "data" / DATABASE) as db:
        db.execute("UPDATE event SET data = json_set(data, '$.seal', json('[7, \"answer\", 1]'))")
        db.execute("UPDATE showing SET measured = json_set(measured, '$.seal', 9) WHERE measured <> '{}'")
        (count,) = db.execute("SELECT count(*) FROM event").fetchone()
    db.close()
    for noted, is_read in ((count, True), (count + 1, False)):
        (tmp_path / "data" / "lock").write_text(json.dumps({"journal": [noted, count, 7]}))
        if is_read:
            with Store(tmp_path / "data") as store:
                assert held(store.contents()) == before
        else:
            with pytest.raises(InputError, match=f"the last 1 of {noted} entries of its journal"):
                Store(tmp_path / "data")
