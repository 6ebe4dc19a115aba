"""SIGKILL at any instant: what was confirmed is there, once, and the file is sound."""

from __future__ import annotations

import itertools
import random
import sqlite3

from hmdwarp.study.store import DATABASE, Store

from .killing import Killing

KILLS = 45
# Values rise through the whole life of a store, so that each is known by itself.
ANSWERS = """
def job(folder):
    with Store(folder, create=True) as store:
        try: session = store.resume("P1")
        except Exception: session = begun(store, "P1")
        value = max((answer.value for answer in store.contents().answers), default=0.0)
        while True:
            for ask in asks(session):
                value += 1
                one = store.answer(session, ask, value, 0.5, "participant")
                told(f"{one.value} {one.key} {one.revision}")
                store.record(session, "remark", text="x" * 300)
"""


def test_no_confirmed_answer_is_missing_or_doubled(tmp_path):
    """Every third store is new: the making of one is killed as well.

    The log is taken over into the file (at 1000 pages) several times.
    """
    chance = random.Random(3)
    confirmed: dict[int, list[tuple]] = {}
    with Killing(ANSWERS) as killing:
        for number in itertools.count():
            if number >= KILLS and sum(map(len, confirmed.values())) > KILLS:
                break  # else a slow machine was killed at its beginnings, and gets more time
            folder = tmp_path / str(number // 3)
            kept = confirmed.setdefault(number // 3, [])
            lines = killing.job(folder, (1 + number // KILLS) * chance.choice((0.02, 0.05, 0.3)) * chance.random())
            kept += [(float(value), key, int(revision)) for value, key, revision in (line.split() for line in lines)]
            check(folder, kept, kills=number % 3 + 1)


def check(folder, kept, kills) -> None:
    if not (folder / DATABASE).exists() or not kept:
        return
    with Store(folder) as store:
        found = store.contents()
        there = [(answer.value, answer.key, answer.revision) for answer in found.answers]
        told = [
            (event.data["value"], event.key, event.data["revision"]) for event in found.events if event.kind == "answer"
        ]
    assert len(set(there)) == len(there) and len({value for value, *_ in there}) == len(there), "none is doubled"
    assert set(kept) <= set(there), "none is missing"
    assert len(there) - len(kept) <= kills, "what was stored and not yet told: at most one each time"
    assert there == told, "an answer and its line in the journal are one"
    assert [value for value, *_ in there] == sorted(value for value, *_ in there)
    db = sqlite3.connect(folder / DATABASE)
    assert (
        db.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        and db.execute("PRAGMA foreign_key_check").fetchall() == []
    )
    db.close()
