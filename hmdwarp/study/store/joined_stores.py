"""Joins the stores of several sites into one that every other command reads like theirs.

A participant's code and every id are a site's own, so codes get the site's name before them and
rows new ids. The random word that names a participant in exports stays: two stores that share one
hold the same person's sessions twice.
"""

from __future__ import annotations

import re
import shutil
import sqlite3
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...report import keep_private
from ...resources import __version__
from ...scenes import inputs_beside
from . import database, queries
from .admission import insert
from .database import transaction, translated
from .folders import DATABASE, TRACES, check_place, make_folders
from .records import PILOT, from_json, to_json
from .signature import signature_changes

_SITE = re.compile(r"[A-Za-z0-9]{1,16}")
_MOST_CODE = 32
Row = dict[str, Any]
Ids = dict[int, int]


@attrs.frozen
class SiteRows:
    """What came from one site."""

    site: str
    participants: int
    sessions: int
    answers: int


def merge(sites: Mapping[str, Path], out: Path) -> list[SiteRows]:
    """Join the stores of sites into a new one, and return what each brought.

    sites: the folder of each, by the site's name. out: a folder that does not exist yet; it appears
    when it is whole. Sessions keep their random words, plans, times and traces; of those who
    withdrew only the code is there.
    Errors: InputError for fewer than two sites, a name or a folder that cannot be taken, stores of
    different studies or plans, and for a participant who is in two of them; otherwise as Store.
    """
    _check(sites, out)
    opened = {site: _opened(folder) for site, folder in sites.items()}
    try:
        name = _one_study(opened, sites)
        _check_plans(opened)
        _check_people(opened)
        return _written(name, opened, sites, out)
    finally:
        for db in opened.values():
            db.close()


def _check(sites: Mapping[str, Path], out: Path) -> None:
    if len(sites) < 2:
        raise InputError(f"{len(sites)} store to merge: expected two or more, as SITE=DIR")
    for site in sites:
        if not _SITE.fullmatch(site):
            raise InputError(f"site '{site}': expected 1 to 16 letters and digits, as in berlin=DIR")
    if len({site.lower() for site in sites}) < len(sites):
        raise InputError("two sites have the same name but for case: expected one name each")
    folders = [folder.resolve() for folder in sites.values()]
    if len(set(folders)) < len(folders):
        raise InputError("one folder is given for two sites: expected a folder each")
    if out.exists():
        raise InputError(f"{out}: exists: expected a new folder (--out)")
    check_place(out)


def _opened(folder: Path) -> sqlite3.Connection:
    db = database.open_to_read(folder)
    if db is None:
        raise InputError(f"{folder}: holds no data of a study (no {DATABASE})")
    db.row_factory = sqlite3.Row
    db.execute("BEGIN")  # one state of it, even while another process writes
    return db


def _one_study(opened: Mapping[str, sqlite3.Connection], sites: Mapping[str, Path]) -> str:
    names = {site: queries.study_name(db) for site, db in opened.items()}
    if len(set(names.values())) > 1:
        held = ", ".join(f"{sites[site]} holds '{name}'" for site, name in names.items())
        raise InputError(f"{held}: expected stores of one study")
    return next(iter(names.values()))


def _check_plans(opened: Mapping[str, sqlite3.Connection]) -> None:
    """Refuse plans whose ratings cannot be compared; pilots may have had any."""
    query = f"""SELECT DISTINCT s.part, p.origin, plan.meaning FROM session s JOIN plan ON plan.id = s.plan
      JOIN participant p ON p.id = s.participant WHERE p.origin <> '{PILOT}' AND NOT p.withdrawing"""
    first: dict[tuple[str, str], tuple[str, Mapping[str, Any]]] = {}
    for site, db in opened.items():
        for part, origin, text in db.execute(query):
            was_at, was = first.setdefault((part, origin), (site, from_json(text)))
            if different := signature_changes(was, from_json(text)):
                raise InputError(
                    f"part '{part}' had another plan at {site} than at {was_at} ({', '.join(different)}): its ratings "
                    "are not comparable, so they are studies of their own"
                )


def _check_people(opened: Mapping[str, sqlite3.Connection]) -> None:
    seen: dict[str, str] = {}
    for site, db in opened.items():
        for (sub,) in db.execute("SELECT sub FROM participant WHERE NOT withdrawing"):
            if sub in seen:
                raise InputError(
                    f"the stores of {seen[sub]} and {site} hold the same participant ({sub}): is one a copy of the "
                    "other? Give each store once"
                )
            seen[sub] = site


def _written(
    name: str, opened: Mapping[str, sqlite3.Connection], sites: Mapping[str, Path], out: Path
) -> list[SiteRows]:
    making = out.with_name(f".{out.name}.merging")
    shutil.rmtree(making, ignore_errors=True)
    try:
        make_folders(making)
        with translated(making / DATABASE), closing(database.open_to_write(making, name, __version__)) as into:
            with transaction(into, making / DATABASE):
                found = [_Copy(site, db, into).all() for site, db in opened.items()]
            into.execute("PRAGMA journal_mode = DELETE")  # all of it in one file
        for site, db in opened.items():
            _copy_traces(db, sites[site] / TRACES, making / TRACES)
        keep_private(*making.rglob("*"))
        making.rename(out)
    except BaseException:
        shutil.rmtree(making, ignore_errors=True)
        raise
    return found


def _copy_traces(db: sqlite3.Connection, folder: Path, into: Path) -> None:
    """Copy the traces of all who did not withdraw; a session that was cut off may lack one."""
    query = f"SELECT trace FROM showing WHERE trace <> '' AND session IN ({_KEPT_SESSIONS})"
    for (trace,) in db.execute(query):
        for each in filter(Path.is_file, (folder / trace, inputs_beside(folder / trace))):
            shutil.copy2(each, into / each.name)


_KEPT = "SELECT id FROM participant WHERE NOT withdrawing"
_KEPT_SESSIONS = f"SELECT id FROM session WHERE participant IN ({_KEPT})"


class _Copy:
    """Copies the rows of one site, parents first, each with a new id."""

    def __init__(self, site: str, source: sqlite3.Connection, into: sqlite3.Connection) -> None:
        self._site, self._source, self._into = site, source, into

    def all(self) -> SiteRows:
        people = self._table("participant", "WHERE NOT withdrawing", self._participant)
        plans = {row["id"]: self._plan(row) for row in self._source.execute("SELECT * FROM plan")}
        sessions = self._table(
            "session",
            f"WHERE participant IN ({_KEPT})",
            lambda row: {"participant": people[row["participant"]], "plan": plans[row["plan"]], **self._facts(row)},
        )
        of = f"WHERE session IN ({_KEPT_SESSIONS})"
        showings = self._table("showing", of, lambda row: {"session": sessions[row["session"]]})
        answers = self._table(
            "answer",
            of,
            lambda row: {"session": sessions[row["session"]], "showing": showings.get(row["showing"])},
        )
        events = self._table("event", of, lambda row: {"session": sessions[row["session"]]})
        told = {"session": sessions, "showing": showings, "shown": showings, "answer": answers}
        for old, new in events.items():
            data = from_json(self._source.execute("SELECT data FROM event WHERE id = ?", (old,)).fetchone()[0])
            _, what, row = data.get("seal", (0, "", 0))
            database.seal(self._into, new, what, told.get(what, {}).get(row, 0))
        gone = "SELECT code FROM withdrawn UNION SELECT code FROM participant WHERE withdrawing"
        for (code,) in self._source.execute(gone):
            # Their bytes were never here.
            self._into.execute("INSERT INTO withdrawn (code, cleaned) VALUES (?, 1)", (self._code(code),))
        return SiteRows(self._site, len(people), len(sessions), len(answers))

    def _table(self, table: str, where: str, changed: Callable[[sqlite3.Row], Row]) -> Ids:
        """Copy rows in the order of their ids; return the new id of each."""
        ids: Ids = {}
        for row in self._source.execute(f"SELECT * FROM {table} {where} ORDER BY id"):
            values = {name: row[name] for name in row.keys() if name != "id"} | changed(row)  # noqa: SIM118
            ids[row["id"]] = insert(self._into, table, **values)
        return ids

    def _participant(self, row: sqlite3.Row) -> Row:
        return {"code": self._code(row["code"])}

    def _code(self, code: str) -> str:
        merged = f"{self._site}-{code}"
        if len(merged) > _MOST_CODE:
            raise InputError(
                f"site {self._site}: '{merged}' has more than {_MOST_CODE} signs: expected a shorter name of the site"
            )
        return merged

    def _plan(self, row: sqlite3.Row) -> int:
        plan = (row["text"], row["meaning"])
        self._into.execute("INSERT OR IGNORE INTO plan (text, meaning) VALUES (?, ?)", plan)
        return int(self._into.execute("SELECT id FROM plan WHERE text = ? AND meaning = ?", plan).fetchone()[0])

    def _facts(self, row: sqlite3.Row) -> Row:
        facts = from_json(row["facts"])
        before = f"{self._site}-{facts['site']}" if "site" in facts else self._site  # of a store merged before
        return {"facts": to_json({**facts, "site": before})}
