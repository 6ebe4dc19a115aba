"""Stores that are damaged at random: each is read as it was, or refused in a line and rescued.

STUDY_DAMAGES (40) says how many, STUDY_KILL_SEED which; `make test-kill` does 500.
"""

from __future__ import annotations

import os
import random
import shutil
import sqlite3
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import attrs
import pytest
from typer.testing import CliRunner

from hmdwarp.cli._app import app
from hmdwarp.errors import InputError, MachineError
from hmdwarp.study.store import DATABASE, Contents, Store, recover

from .sessions import TEXT, asks, begun, design, go_through, whole

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
    with sqlite3.connect(path) as db:
        db.execute("CREATE TABLE bookmarks (url)")
    db.close()


def another_schema(path: Path, chance: random.Random) -> None:
    with sqlite3.connect(path) as db:
        db.execute(
            chance.choice(
                (
                    "PRAGMA user_version = 0", "PRAGMA user_version = 9", "PRAGMA application_id = 0",
                    "ALTER TABLE answer DROP COLUMN seconds", "ALTER TABLE answer RENAME TO replies",
                    "DROP TABLE event",
                    "DELETE FROM participant WHERE id = 2", "UPDATE answer SET value = value + 1 WHERE id = 3",
                    "UPDATE event SET data = '[]' WHERE id = 5", "DELETE FROM event WHERE id > 20",
                )
            )
        )  # fmt: skip
    db.close()


def may_not_be_read(path: Path, chance: random.Random) -> None:
    path.chmod(0)  # which stops nobody who is root


Damage = Callable[[Path, random.Random], None]
OF_THE_FILE: tuple[Damage, ...] = (
    *(flipped, flipped, flipped, overwritten, overwritten, cut, gone, a_folder, another_kind, another_program_s),
    *(another_schema, may_not_be_read),
)
OF_THE_LOG: tuple[Damage, ...] = (flipped, flipped, overwritten, cut, gone, gone, a_folder)


def swapped(folder: Path, stores: dict[str, Path], chance: random.Random) -> None:
    """A file of another store, or of an older copy, in place of one of this."""
    source, name = chance.choice((("older", DATABASE), ("other", DATABASE), ("older", DATABASE)))
    shutil.copyfile(stores[source] / name, folder / name)


def one(stores: dict[str, Path], folder: Path, chance: random.Random) -> tuple[str, str]:
    """Damage a copy. Returns the kind of store and of damage."""
    kind = chance.choice(("closed", "cut-off"))
    shutil.copytree(stores[kind], folder)
    way = chance.random()
    if way < 0.1:
        swapped(folder, stores, chance)
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
def test_a_damaged_store_is_read_as_it_was_or_refused_and_rescued(stores, tmp_path, capsys):
    """Never read as something else, never a fault of the program's, and nothing is changed."""
    whole_: dict[str, dict[str, list]] = {}
    for kind in ("closed", "cut-off"):
        with Store(stores[kind]) as store:
            whole_[kind] = held(store.contents())
    tally, kept, lost = Counter(), 0, 0
    for number in range(DAMAGES):
        chance = random.Random(f"{SEED}-{number}")
        folder, new = tmp_path / "data", tmp_path / "new"
        for path in (folder, new):
            shutil.rmtree(path, ignore_errors=True)
        kind, damage = one(stores, folder, chance)
        where = f"STUDY_KILL_SEED={SEED}, number {number}: {kind}, {damage}"
        try:
            with Store(folder) as store:
                assert held(store.contents()) == whole_[kind], where
            tally["read as it was"] += 1
            continue
        except (InputError, MachineError) as error:
            said = str(error)
            assert "\n" not in said and str(folder) in said, where
        other = ("another_program_s", "another_schema", "flipped", "a_folder")  # which other lines may tell as well
        assert "damaged" in said or damage in other, f"{where}: {said}"
        for act in (lambda store: begun(store, "Q1"), lambda store: store.resume("P5")):
            with pytest.raises((InputError, MachineError)), Store(folder, create=True) as store:
                act(store)
        try:
            rescued = recover(folder, new, design(TEXT), "late", "person")
        except InputError as error:
            assert "no row of a study can be read" in str(error), where
            tally["refused, nothing to rescue"] += 1
            continue
        tally["refused and rescued"] += 1
        with Store(new) as store:
            again = store.contents()
            begun(store, "Q2")
        if damage != "swapped":
            was = {answer.id: answer for answer in whole_[kind]["answers"]}
            named = " ".join(rescued.altered)
            for answer in again.answers:
                before = was.get(answer.id)
                if before is not None and "words of theirs are lost" in named:
                    before = attrs.evolve(before, text=answer.text)
                assert answer == before or before.key in named or answer.key in named, f"{where}: {answer}"
            kept, lost = kept + len(again.answers), lost + max(len(was) - len(again.answers), 0)
    with capsys.disabled():
        told = ", ".join(f"{count} {what}" for what, count in sorted(tally.items()))
        print(f"\n{DAMAGES} damages, seed {SEED}: {told}; of {kept + lost} answers {kept} were rescued")
    assert tally["refused and rescued"] > DAMAGES / 4


def test_the_line_says_what_can_be_rescued_and_the_command_does(stores, tmp_path):
    shutil.copytree(stores["closed"], tmp_path / "data")
    data = bytearray((tmp_path / "data" / DATABASE).read_bytes())
    data[:4096] = bytes(4096)
    (tmp_path / "data" / DATABASE).write_bytes(data)
    line = r"damaged \(.*\): 5 sessions, 25 showings, .* answers and 25 head traces can be read.*study recover STUDY"
    with pytest.raises(InputError, match=line):
        Store(tmp_path / "data")
    (tmp_path / "late.toml").write_text(TEXT)
    words = ["study", "recover", tmp_path / "late.toml", "--store", tmp_path / "data", "--out", tmp_path / "new"]
    done = CliRunner().invoke(app, [*map(str, words)])
    assert done.exit_code == 0, done.output
    assert "rescued: 5 participants, 5 sessions, 25 showings" in done.output
    with Store(tmp_path / "new") as store, Store(stores["closed"]) as before:
        assert held(store.contents()) == held(before.contents())
    assert (tmp_path / "data" / DATABASE).read_bytes() == data


def test_who_withdrew_does_not_come_back(stores, tmp_path):
    shutil.copytree(stores["closed"], tmp_path / "data")
    with Store(tmp_path / "data") as store:
        store.withdraw("P1")
    recover(tmp_path / "data", tmp_path / "new", None, "late", "person")
    with Store(tmp_path / "new") as store:
        assert {session.code for session in store.contents().sessions} == {"P0", "P2", "P3", "P4"}
        with pytest.raises(InputError, match="has withdrawn"):
            begun(store, "P1")


def test_a_seal_broken_by_hand_is_named(stores, tmp_path):
    shutil.copytree(stores["closed"], tmp_path / "data")
    with sqlite3.connect(tmp_path / "data" / DATABASE) as db:
        db.execute("UPDATE answer SET value = 6 WHERE id = (SELECT max(id) FROM answer)")
    db.close()
    with pytest.raises(InputError, match="damaged .*is not as it was written"):
        Store(tmp_path / "data")
    (found,) = recover(tmp_path / "data", tmp_path / "new", None, "late", "person").altered
    assert "of P4" in found


def test_figures_that_differ_from_what_was_measured_are_noticed_and_left_out(stores, tmp_path):
    shutil.copytree(stores["closed"], tmp_path / "data")
    with Store(tmp_path / "data") as store:
        before = {showing.id: showing.measured for showing in store.contents().showings if showing.measured}
    with sqlite3.connect(tmp_path / "data" / DATABASE) as db:
        db.execute("UPDATE showing SET measured = replace(measured, '320', '321') WHERE id = 3")
    db.close()
    with pytest.raises(InputError, match="damaged .*'study measure' are not as they were written"):
        Store(tmp_path / "data")
    (found,) = recover(tmp_path / "data", tmp_path / "new", None, "late", "person").altered
    assert "figures of showing 3 are lost" in found
    del before[3]
    with Store(tmp_path / "new") as store:
        assert {showing.id: showing.measured for showing in store.contents().showings if showing.measured} == before
