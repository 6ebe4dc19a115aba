"""The study as a BIDS data set: what every question was answered, how every head moved, and what all of it is.

No date leaves: instants are told from the beginning of a session, which BIDS writes as a date of 1925.
Source: BIDS specification 1.9 (bids-specification.readthedocs.io), "Behavioral experiments" and "Motion".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from typing import Any

import attrs

from ...errors import TraceError
from ...poses import load_trace
from ...report import OutputFolder
from ...version import __version__
from ..design import Design
from ..scales import Scale
from ..store import PERSON, Contents, Session, Showing
from .columns import COLUMNS, Column, columns_for, label_of
from .motion import TRACKSYS, channels_json, channels_text, motion_json, motion_text, software
from .rows import Row, scales_asked
from .text import tsv_text

VERSION = "1.9.0"
FOLDER = "bids"
EPOCH = datetime(1925, 1, 1)  # BIDS: dates that were shifted for privacy lie in 1925 or before
Progress = Callable[[int, int], None]

PARTICIPANTS = (
    Column("participant_id", "text", "sub- and the participant's random word"),
    Column("part", "text", "Parts of the study, in the order of the sessions"),
    Column("sessions", "whole", "How many sittings there were"),
    Column(
        "status", "text", "How the last sitting ended", levels=next(c for c in COLUMNS if c.name == "status").levels
    ),
)
SCANS = (
    Column("filename", "text", "File that the row is about"),
    Column("acq_time", "text", "When the showing began: 1925-01-01 is no date, but the beginning of the session"),
    Column("trial", "whole", "Trial whose head motion it is, 0 for the practice"),
    Column("condition", "text", "What was shown"),
    Column("presentation", "whole", "Which showing of the trial it is"),
)


@attrs.frozen
class Left:
    """How many motion files were written, and why others were not."""

    motions: int
    why_not: tuple[str, ...]


def write_bids(
    out: OutputFolder, contents: Contents, design: Design, rows: Sequence[Row], readme: str, progress: Progress
) -> Left:
    """contents: of one origin. rows: all answers (rows.answer_rows and the scores), which are distributed over the sessions."""
    tree = _Tree(out, contents, design, label_of(design.name), scales_asked(contents, design))
    tree.head(readme)
    count, motions, why_not = sum(_has_motion(one) for one in contents.showings), 0, []
    for session in contents.sessions:
        files = tree.behaviour(
            session, [row for row in rows if (row["participant"], row["session"]) == (session.sub, session.number)]
        )
        for showing in (one for one in contents.showings if one.session == session.id and _has_motion(one)):
            try:
                files.append(tree.motion(session, showing, len(files)))
                motions += 1
            except (TraceError, FileNotFoundError) as error:
                why_not.append(f"{showing.trace}: {str(error).splitlines()[0]}")
            progress(motions + len(why_not), count)
        tree.scans(session, files)
    return Left(motions, tuple(why_not))


def _has_motion(showing: Showing) -> bool:
    """What was broken off was shown again, and no answer is about it: such poses are kept to the store."""
    return bool(showing.complete and showing.trace)


@attrs.frozen
class _Tree:
    out: OutputFolder
    contents: Contents
    design: Design
    task: str
    scales: dict[str, Scale]

    def head(self, readme: str) -> None:
        """What stands above the participants."""
        self._json("dataset_description.json", {
            "Name": self.design.title,
            "BIDSVersion": VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [{"Name": "hmdwarp", "Version": __version__}],
        })  # fmt: skip
        self.out.write_text(f"{FOLDER}/README", readme)
        people: dict[str, list[Session]] = {}
        for session in self.contents.sessions:
            people.setdefault(session.sub, []).append(session)
        # By the random word: the order they came in is nobody's business.
        rows = [{
            "participant_id": f"sub-{sub}",
            "part": ", ".join(dict.fromkeys(one.part for one in sessions)),
            "sessions": len(sessions),
            "status": sessions[-1].status,
        } for sub, sessions in sorted(people.items())]  # fmt: skip
        self._text("participants.tsv", tsv_text(rows, PARTICIPANTS))
        self._json("participants.json", {**described(PARTICIPANTS), **self._withdrawn()})

    def _withdrawn(self) -> dict[str, Any]:
        """Of people: the store does not keep of which kind one was who withdrew, as it keeps nothing of them."""
        if not self.contents.withdrawn or any(one.origin != PERSON for one in self.contents.sessions):
            return {}
        told = f"{self.contents.withdrawn} withdrew; nothing of them is in here or was kept"
        return {"Withdrawn": {"Description": told, "Count": self.contents.withdrawn}}

    def behaviour(self, session: Session, rows: Sequence[Row]) -> list[Row]:
        """All answers of a session. Rows for _scans.tsv."""
        name = f"beh/{self._stem(session)}_beh"
        columns = columns_for(rows, ("phase", "kind"))
        self._text(f"{self._folder(session)}/{name}.tsv", tsv_text(rows, columns))
        self._json(f"{self._folder(session)}/{name}.json", {**self._task(session), **described(columns, self.scales)})
        return [{"filename": f"{name}.tsv", "acq_time": _shifted(session.started_utc, session.started_utc)}]

    def motion(self, session: Session, showing: Showing, run: int) -> Row:
        """One showing's head. Errors: TraceError for a trace that cannot be read."""
        track = load_trace(self.contents.folder / "traces" / showing.trace).track
        if len(track) < 2:
            raise TraceError("a single pose is no motion")
        stem = f"motion/{self._stem(session)}_tracksys-{TRACKSYS}_run-{run:02d}"
        folder = self._folder(session)
        self._text(f"{folder}/{stem}_motion.tsv", motion_text(track))
        self._json(f"{folder}/{stem}_motion.json", motion_json(track, self._task(session), session.facts))
        self._text(f"{folder}/{stem}_channels.tsv", channels_text())
        self._json(f"{folder}/{stem}_channels.json", channels_json())
        return {
            "filename": f"{stem}_motion.tsv",
            "acq_time": _shifted(session.started_utc, showing.started_utc),
            "trial": showing.trial,
            "condition": showing.condition,
            "presentation": showing.presentation,
        }

    def scans(self, session: Session, files: Sequence[Row]) -> None:
        """What was recorded when, from the beginning of the session on."""
        name = f"{self._folder(session)}/sub-{session.sub}_ses-{session.number:02d}_scans"
        self._text(f"{name}.tsv", tsv_text(files, SCANS))
        self._json(f"{name}.json", described(SCANS))

    def _task(self, session: Session) -> dict[str, str]:
        return {
            "TaskName": self.design.name,
            "TaskDescription": f"{self.design.title} Conditions are shown one after the other, and rated after each.",
            "SoftwareVersions": software(session.facts.get("hmdwarp", __version__), session.facts.get("display", {})),
        }

    def _folder(self, session: Session) -> str:
        return f"sub-{session.sub}/ses-{session.number:02d}"

    def _stem(self, session: Session) -> str:
        return f"sub-{session.sub}_ses-{session.number:02d}_task-{self.task}"

    def _text(self, name: str, text: str) -> None:
        self.out.write_text(f"{FOLDER}/{name}", text)

    def _json(self, name: str, value: dict[str, Any]) -> None:
        self.out.write_json(f"{FOLDER}/{name}", value)


def described(columns: Sequence[Column], scales: dict[str, Scale] | None = None) -> dict[str, Any]:
    """Sidecar entries of columns; of the scales asked, what their values mean."""
    told: dict[str, Any] = {}
    for column in columns:
        told[column.name] = {"Description": column.description}
        if column.levels:
            told[column.name]["Levels"] = dict(column.levels)
        if column.units:
            told[column.name]["Units"] = column.units
    if scales and "scale" in told:
        told["scale"]["Levels"] = {name: _about(scale) for name, scale in scales.items()}
        told["item"]["Levels"] = {item.key: item.text for scale in scales.values() for item in scale.items}
        told["item"]["Levels"] |= {one.name: one.title or one.name for scale in scales.values() for one in scale.scores}
    return told


def _about(scale: Scale) -> str:
    good = "low is good" if scale.low_is_good else "high is good"
    anchors = ", ".join(f"{value:g} {word}" for value, word in scale.anchors.items())
    source = f"; source: {scale.source}" if scale.source else ""
    return (
        f"{scale.title}: {scale.least:g} to {scale.most:g} by {scale.step:g}, {good}"
        + (f" ({anchors})" if anchors else "")
        + source
    )


def _shifted(start_utc: str, at_utc: str) -> str | None:
    """An instant of a session on BIDS's calendar; None where the machine's clock was set back in between."""
    passed = datetime.fromisoformat(at_utc) - datetime.fromisoformat(start_utc)
    return (EPOCH + passed).isoformat(timespec="milliseconds") if passed >= timedelta(0) else None
