"""Exports a study into one folder, whole or not at all: tables, a README and a BIDS data set."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...errors import InputError, TraceError
from ...poses import PoseTrack, load_trace
from ...report import OutputFolder, counted
from ...resources import __version__, install_line, made_text
from ...run import DESKTOP, OPENXR
from ...scenes import inputs_beside, read_inputs
from ..design import Design, Show
from ..scales import Scale
from ..store import PERSON, PILOT, SIMULATED, Contents, Session, Showing
from . import export_rows as tables
from .export_rows import Column, Row, columns_for, columns_in, tsv_text

FRAME = "world"
# name, component, type, units: in the order of the columns of _motion.tsv.
CHANNELS = (
    ("latency", "n/a", "LATENCY", "s"),
    ("head_pos_x", "x", "POS", "m"),
    ("head_pos_y", "y", "POS", "m"),
    ("head_pos_z", "z", "POS", "m"),
    ("head_quat_x", "quat_x", "ORNT", "n/a"),
    ("head_quat_y", "quat_y", "ORNT", "n/a"),
    ("head_quat_z", "quat_z", "ORNT", "n/a"),
    ("head_quat_w", "quat_w", "ORNT", "n/a"),
)
_NO_CHANNELS = ("ACCEL", "ANGACCEL", "GYRO", "JNTANG", "MAGN", "MISC", "VEL")
_UNEVEN = 0.05  # of a median step: smaller deviations are the timer's


def tracking_system(facts: Mapping[str, Any]) -> tuple[str, str, str]:
    """Return what led the head of a showing: a label, a name, and the device's model or "".

    A window's headset is only emulated. A trace's file name stays private: it may name a person.
    """
    display, axes = facts.get("display", {}), facts.get("trace_axes")
    if facts.get("trace"):
        return "trace", f"head trace, replayed{f'; its axes: {axes}' if axes else ''}", ""
    if facts.get("source") == OPENXR:
        model = display.get("headset", "")
        return "hmd", f"{model or 'headset'}, by OpenXR runtime {_runtime(display) or 'unknown'}", model
    if facts.get("source") == DESKTOP:
        return "mouse", "mouse and keyboard of a desktop window", ""
    return "unknown", "not recorded", ""


@attrs.frozen
class Rates:
    """Sampling rates of a track."""

    nominal_hz: float  # one over the median step
    effective_hz: float  # steps over their duration
    uneven: float  # share of steps that differ from the median by more than a twentieth
    longest_s: float  # longest step

    @classmethod
    def of(cls, track: PoseTrack) -> Rates:
        """Compute the rates of a track of at least two samples."""
        steps = np.diff(track.time_ns)
        median = float(np.median(steps))
        off = np.abs(steps - median) > _UNEVEN * median
        return cls(1e9 / median, len(steps) * 1e9 / track.duration_ns, float(off.mean()), float(steps.max()) * 1e-9)

    def describe(self) -> str:
        return (
            f"Samples are as recorded, not resampled: {self.uneven:.1%} of the steps differ by more than "
            f"{_UNEVEN:.0%} from the median, "
            f"the longest is {self.longest_s:.4f} s. The channel 'latency' holds the instant of each."
        )


def motion_text(track: PoseTrack) -> str:
    """Return the _motion.tsv: no header, a row for each sample, columns as CHANNELS.

    Seconds to the microsecond, as the specification writes them; poses with every digit.
    """
    stream = io.StringIO()
    columns = (track.time_ns - track.start_ns, track.position_m, track.orientation_xyzw)
    for time_ns, position, orientation in zip(*(column.tolist() for column in columns), strict=True):
        whole, micro = divmod((time_ns + 500) // 1000, 1_000_000)
        stream.write("\t".join((f"{whole}.{micro:06d}", *map(repr, position), *map(repr, orientation))) + "\n")
    return stream.getvalue()


def motion_json(track: PoseTrack, task: Mapping[str, str], facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sidecar; of the session's facts only versions and what led the head are used."""
    rates, (_, system, model) = Rates.of(track), tracking_system(facts)
    return {
        **task,
        "SamplingFrequency": round(rates.nominal_hz, 6),
        "SamplingFrequencyEffective": round(rates.effective_hz, 6),
        "SamplingDescription": rates.describe(),
        "TrackingSystemName": system,
        "RecordingDuration": round(track.duration_ns * 1e-9, 6),
        "MotionChannelCount": len(CHANNELS),
        "LATENCYChannelCount": 1,
        "POSChannelCount": 3,
        "ORNTChannelCount": 4,
        **{f"{kind}ChannelCount": 0 for kind in _NO_CHANNELS},
        "TrackedPointsCount": 1,
        "MissingValues": "n/a",
        "SubjectArtefactDescription": "n/a",
        "Manufacturer": "n/a",
        "ManufacturersModelName": model or "n/a",
        "DeviceSerialNumber": "n/a",  # would identify the machine
        "SoftwareVersions": software(facts.get("hmdwarp", ""), facts.get("display", {})),
    }


def software(hmdwarp: str, display: Mapping[str, Any]) -> str:
    """Name the versions of hmdwarp and of the runtime, as far as known."""
    return ", ".join(filter(None, (f"hmdwarp {hmdwarp}".strip(), _runtime(display))))


def _runtime(display: Mapping[str, Any]) -> str:
    return " ".join(str(display[key]) for key in ("runtime", "runtime_version") if display.get(key))


def channels_text() -> str:
    """Return the _channels.tsv: one row for each column of _motion.tsv, in that order."""
    rows = ["name\tcomponent\ttype\ttracked_point\tunits\treference_frame"]
    rows += [
        f"{name}\t{component}\t{type_}\thead\t{units}\t{'n/a' if type_ == 'LATENCY' else FRAME}"
        for name, component, type_, units in CHANNELS
    ]
    return "\n".join(rows) + "\n"


def channels_json() -> dict[str, Any]:
    """Describe the reference frame."""
    text = (
        "world_from_head in the axes of OpenXR: +x right, +y up, +z backward, metres; the quaternion rotates from "
        "the head's axes to the world's. The origin is the display's own."
    )
    frame = {"SpatialAxes": "RSP", "RotationRule": "right-hand", "Description": text}
    return {"reference_frame": {"Description": "Axes of the channel", "Levels": {FRAME: frame}}}


VERSION = "1.9.0"
FOLDER = "bids"
EPOCH = datetime(1925, 1, 1)  # BIDS: dates shifted for privacy lie in 1925 or before
Progress = Callable[[int, int], None]

PARTICIPANTS = columns_in("participants")
SCANS = columns_in("scans")


def write_bids(
    out: OutputFolder,
    contents: Contents,
    design: Design,
    rows: Sequence[Row],
    readme: str,
    progress: Progress,
    *,
    motion: bool = True,
) -> tuple[int, list[str]]:
    """Write the data set, with the head motion if `motion`.

    contents: of one origin. rows: all answers (answer_rows and score_rows) of all sessions.
    Returns how many recordings were written, and why others were left out.
    """
    shows = {data.session.id: data.shows for data in tables.sessions_of(contents, design)}
    tree = _Tree(out, contents, design, tables.label_of(design.name), tables.all_scales(contents, design), shows)
    tree.head(readme)
    # One that was cut off was repeated, and no answer is about it: its poses stay in the store.
    recorded = [showing for showing in contents.showings if motion and showing.complete and showing.trace]
    written, left_out = 0, list[str]()
    for session in contents.sessions:
        own = [row for row in rows if (row["participant"], row["session"]) == (session.sub, session.number)]
        files = tree.behaviour(session, own)
        for showing in (showing for showing in recorded if showing.session == session.id):
            try:
                files.append(tree.motion(session, showing, len(files)))
                written += 1
            except (InputError, FileNotFoundError) as error:
                left_out.append(f"{showing.trace}: {str(error).splitlines()[0]}")
            progress(written + len(left_out), len(recorded))
        tree.scans(session, files)
    return written, left_out


@attrs.frozen
class _Tree:
    out: OutputFolder
    contents: Contents
    design: Design
    task: str
    scales: dict[str, Scale]
    shows: dict[int, Mapping[str, Show]]  # planned showings of each session, by key

    def head(self, readme: str) -> None:
        """Write the files of the whole data set."""
        self._json("dataset_description.json", {
            "Name": self.design.title,
            "BIDSVersion": VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [{"Name": "hmdwarp", "Version": __version__, "Description": made_text()}],
        })  # fmt: skip
        self.out.write_text(f"{FOLDER}/README", readme)
        people: dict[str, list[Session]] = {}
        for session in self.contents.sessions:
            people.setdefault(session.sub, []).append(session)
        # By the random word, so that the order of arrival does not show.
        rows = [{
            "participant_id": f"sub-{sub}",
            "part": ", ".join(dict.fromkeys(session.part for session in sessions)),
            "origin": sessions[-1].origin,
            "sessions": len(sessions),
            "status": sessions[-1].status,
        } for sub, sessions in sorted(people.items())]  # fmt: skip
        self._text("participants.tsv", tsv_text(rows, PARTICIPANTS))
        gone, side = self.contents.withdrawn, sidecar(PARTICIPANTS)
        if gone and all(session.origin == PERSON for session in self.contents.sessions):  # their origin is not known
            side["Withdrawn"] = {"Description": f"{gone} withdrew; all their data were erased", "Count": gone}
        self._json("participants.json", side)

    def behaviour(self, session: Session, rows: Sequence[Row]) -> list[Row]:
        """Write a session's answers and the times of its trials; return the rows for _scans.tsv."""
        stem = f"beh/{self._stem(session)}"
        columns = columns_for(rows, ("phase", "kind", *(["text"] if any(row["text"] for row in rows) else [])))
        self._text(f"{self._folder(session)}/{stem}_beh.tsv", tsv_text(rows, columns))
        self._json(f"{self._folder(session)}/{stem}_beh.json", self._task(session) | sidecar(columns, self.scales))
        shown = (showing for showing in self.contents.showings if showing.session == session.id and showing.complete)
        self._events(session, stem, tables.event_rows(session, self.shows[session.id], shown))
        return [{"filename": f"{stem}_beh.tsv", "acq_time": _shifted(session.started_utc, session.started_utc)}]

    def _events(
        self, session: Session, stem: str, rows: Sequence[Row], columns: Sequence[Column] = tables.EVENTS
    ) -> None:
        self._text(f"{self._folder(session)}/{stem}_events.tsv", tsv_text(rows, columns))
        machine = session.facts.get("machine", {})
        system = " ".join(str(machine[key]) for key in ("system", "release") if key in machine)
        made_by = {"SoftwareName": "hmdwarp", "SoftwareVersion": session.facts.get("hmdwarp", __version__)}
        self._json(
            f"{self._folder(session)}/{stem}_events.json",
            self._task(session)
            | {"StimulusPresentation": {"OperatingSystem": system or "n/a", **made_by}}
            | sidecar(columns),
        )

    def motion(self, session: Session, showing: Showing, run: int) -> Row:
        """Write the head motion of a showing, and what was done in it. Errors: InputError."""
        trace = self.contents.folder / "traces" / showing.trace
        track, acted = load_trace(trace).track, inputs_beside(trace)
        if len(track) < 2:
            raise TraceError("a single pose is no motion")
        facts = self._facts(session, showing)
        events = [row | {"onset": 0.0} for row in tables.event_rows(session, self.shows[session.id], [showing])]
        columns = tables.RUN_EVENTS
        if acted.is_file():
            try:
                events += tables.input_rows(read_inputs(acted), track.start_ns + track.epoch_ns)
            except InputError as error:
                how = "mend that line, or delete the file to do without, and export again with --force"
                raise InputError(f"{error}; {how}") from error
            columns = tables.INPUT_EVENTS
        self._events(session, f"motion/{self._stem(session)}_run-{run:02d}", events, columns)
        stem = f"motion/{self._stem(session)}_tracksys-{tracking_system(facts)[0]}_run-{run:02d}"
        folder = self._folder(session)
        self._text(f"{folder}/{stem}_motion.tsv", motion_text(track))
        self._json(f"{folder}/{stem}_motion.json", motion_json(track, self._task(session), facts))
        self._text(f"{folder}/{stem}_channels.tsv", channels_text())
        self._json(f"{folder}/{stem}_channels.json", channels_json())
        return {
            "filename": f"{stem}_motion.tsv",
            "acq_time": _shifted(session.started_utc, showing.started_utc),
            "trial": showing.trial,
            "condition": showing.condition,
            "presentation": showing.presentation,
        }

    def _facts(self, session: Session, showing: Showing) -> Mapping[str, Any]:
        """Return the facts of the run of the program that showed it; a session may be resumed."""
        facts, shown = session.facts, (showing.key, showing.presentation)
        for event in self.contents.events:  # in their order: the clock may have been set back meanwhile
            if event.session != session.id:
                continue
            if event.kind == "showing" and (event.key, event.data["presentation"]) == shown:
                break
            facts = (event.kind == "resume" and event.data) or facts
        return facts

    def scans(self, session: Session, files: Sequence[Row]) -> None:
        """List the files with their times since the beginning of the session."""
        name = f"{self._folder(session)}/sub-{session.sub}_ses-{session.number:02d}_scans"
        self._text(f"{name}.tsv", tsv_text(files, SCANS))
        self._json(f"{name}.json", sidecar(SCANS))

    def _task(self, session: Session) -> dict[str, Any]:
        asked = (scale.prompt or scale.items[0].text for scale in self.design.scales)
        return {
            "TaskName": self.design.name,
            "TaskDescription": f"{self.design.title} Conditions are shown one after the other, and rated after each.",
            "Instructions": " ".join(["After each trial:", *asked]),
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


def sidecar(columns: Sequence[Column], scales: dict[str, Scale] | None = None) -> dict[str, Any]:
    """Describe columns, and the values of the scales, for a JSON sidecar."""
    out: dict[str, Any] = {}
    for column in columns:
        out[column.name] = {"Description": column.description}
        if column.levels:
            out[column.name]["Levels"] = dict(column.levels)
        if column.units:
            out[column.name]["Units"] = column.units
    if scales and "scale" in out:
        out["scale"]["Levels"] = {name: _about(scale) for name, scale in scales.items()}
        items = {item.key: item.described for scale in scales.values() for item in scale.items}
        out["item"]["Levels"] = items | {
            score.name: score.title or score.name for scale in scales.values() for score in scale.scores
        }
    return out


def _about(scale: Scale) -> str:
    if not scale.has_answers:
        return scale.title
    words = ", ".join(f"{value:g} {word}" for value, word in scale.anchors.items())
    anchors, source = f" ({words})" if words else "", f"; source: {scale.source}" if scale.source else ""
    return f"{scale.title}: {scale.least:g} to {scale.most:g} by {scale.step:g}, {scale.direction}{anchors}{source}"


def _shifted(start_utc: str, at_utc: str) -> str | None:
    """Shift an instant of a session to 1925; None if the machine's clock was set back meanwhile."""
    passed = datetime.fromisoformat(at_utc) - datetime.fromisoformat(start_utc)
    return (EPOCH + passed).isoformat(timespec="milliseconds") if passed >= timedelta(0) else None


# Older versions wrote some of them; a forced export removes what they hold of withdrawn people.
OWNED = (
    *("ratings.*", "ratings_short.csv", "sessions/*.csv", "preferences.csv", "sickness.tsv", "questionnaires.tsv"),
    *("revisions.tsv", "remarks.csv", "columns.json", "bids/**/*"),
)


_WHOSE = {
    PERSON: ("a person", "people"),
    PILOT: ("a pilot, who tried the study out", "pilots, who tried the study out"),
    SIMULATED: ("a program that answered instead of a person", "programs that answered instead of people"),
}
_OF_MOTION = """Head motion is personal data all the same: minutes of it identify a person among
hundreds. Give the folder bids/ only to recipients to whom the participants agreed."""
_ONE = {PERSON: "person", PILOT: "pilot", SIMULATED: "simulated participant"}


@attrs.frozen
class ExportOptions:
    """What to export."""

    origin: str = PERSON  # one of store.ORIGINS
    parquet: bool | None = None  # True: an error where it cannot be written; None: if possible
    force: bool = False  # into a folder that holds files; those of an older export go
    motion: bool = True  # write the head motion too


@attrs.frozen
class Exported:
    """Result of an export."""

    folder: Path
    notes: tuple[str, ...]  # what was written, in sentences


def export(
    contents: Contents,
    design: Design,
    out: Path,
    options: ExportOptions | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Exported:
    """Export a study.

    out: a new or empty folder, unless forced: an older export may hold people who have withdrawn
    since.
    Errors: InputError for a folder that is not empty, a study without such sessions, or a plan that
    is not theirs; MachineError for a full disk, and where Parquet is required and pyarrow is
    missing.
    """
    options = options or ExportOptions()
    kept = tables.of_origin(contents, options.origin)
    if not kept.sessions:
        raise InputError(no_sessions(contents, options.origin, "export"))
    if not options.force and out.is_dir() and any(out.iterdir()):
        raise InputError(
            f"{out}: exists and is not empty: an older export may hold participants who have withdrawn since; "
            "choose another folder, or replace it with --force"
        )
    answers = tables.answer_rows(kept, design)
    ratings = [row for row in answers if tables.is_rated(row)]
    with OutputFolder(out, owned=OWNED, last="README", force=options.force, private=True) as folder:
        notes = [_counts(kept, ratings, options.origin)]
        if changed := sum(session.plan != design.text for session in kept.sessions):
            ran = "each is written by the plan it ran with"
            notes.append(f"the study's file was changed after {counted(changed, 'session')}: {ran}")
        said = ("declined to take part", "left before the consent was given")
        for count, what in zip(tables.without_consent(contents, options.origin), said, strict=True):
            notes += [f"{counted(count, 'person')} {what}: in no table"] if count else []
        notes += _tables(folder, kept, design, answers, ratings, options.parquet)
        text = _readme(design, kept, ratings, options)
        rows = [*answers, *tables.score_rows(kept, design)]
        written, left_out = write_bids(folder, kept, design, rows, text, progress, motion=options.motion)
        recordings = f"with {counted(written, 'recording')} of head motion: personal data"
        notes.append(f"bids/: a BIDS data set {recordings if options.motion else 'without head motion'}")
        notes += [f"left out: {why}" for why in left_out]
        folder.write_text("README", text)
    return Exported(Path(out), tuple(notes))


def _tables(
    folder: OutputFolder,
    contents: Contents,
    design: Design,
    answers: Sequence[Row],
    ratings: Sequence[Row],
    parquet: bool | None,
) -> list[str]:
    columns = columns_for(ratings)
    folder.write_bytes("ratings.csv", tables.csv_text(ratings, columns).encode())
    described = columns_for(answers, ("phase", "kind", "text"))
    folder.write_json("columns.json", sidecar(described, tables.all_scales(contents, design)))
    notes = ["ratings.csv: one row for each rating"]
    if parquet is None and importlib.util.find_spec("pyarrow") is None:
        return [*notes, f"no ratings.parquet: the package pyarrow is not installed ({install_line('study')})"]
    if parquet is not False:
        tables.write_parquet(folder.path("ratings.parquet"), ratings, columns, design.title)
        notes.append("ratings.parquet: the same with typed columns")
    return notes


def _counts(contents: Contents, ratings: Sequence[Row], origin: str) -> str:
    people = len({session.sub for session in contents.sessions})
    rated = sum(row["value"] is not None for row in ratings)
    missing = f", {len(ratings) - rated} missing" if len(ratings) > rated else ""
    whose = _WHOSE[origin][people != 1]
    sessions, ratings_ = counted(len(contents.sessions), "session"), counted(rated, "rating")
    return f"{counted(people, 'participant')} ({whose}) in {sessions}, {ratings_}{missing}"


def no_sessions(contents: Contents, origin: str, verb: str) -> str:
    """Say that there are no sessions of that origin to `verb`, and what to do."""
    there = {session.origin for session in contents.sessions if session.consented} - {origin}
    run = "run one with --pilot" if origin == PILOT else "run one"
    hint = f"{run} first, or check the folder of --store"
    if PERSON in there:
        hint = f"it holds sessions of people: leave out --{origin}"
    elif there:
        other = min(there)
        hint = f"it holds {other} ones: use --{other}"
    elif none := sum(tables.without_consent(contents, origin)):
        hint = f"{counted(none, 'session')} ended without the consent, and count nowhere; {hint}"
    return f"{contents.folder}: no session of a {_ONE[origin]} to {verb}: {hint}"


def _readme(design: Design, contents: Contents, ratings: Sequence[Row], options: ExportOptions) -> str:
    scales = ", ".join(
        f"{scale.name} ({scale.least:g} to {scale.most:g}, {scale.direction})" if scale.has_answers else scale.name
        for scale in design.scales
    )
    conditions = "\n".join(
        f"  {part.name}: {', '.join(condition.name for condition in part.conditions)}" for part in design.parts
    )
    return f"""{design.title}

Study "{design.name}", exported by hmdwarp {__version__} ({made_text()}): {_counts(contents, ratings, options.origin)}.
Asked after each trial: {scales}.
Conditions, by part of the study:
{conditions}

ratings.csv, and ratings.parquet where pyarrow is installed: the same table with one row per rating,
missing ones included, and what was shown. columns.json: meaning, units and values of each column.
bids/: a BIDS data set with all answers, those between the trials and to questionnaires included,
{"with" if options.motion else "without"} the motion of the heads.
In bids/ authors, licence and institution are left for you to fill in.
Missing values are n/a, in Parquet null. Numbers have decimal points. Of corrected answers the last
one counts. A text that begins with = + - or @ (blanks, apostrophes, a tab or a line end before it
count as well) and is no number has an apostrophe put before it, so that no spreadsheet runs it:
take that one off for the text as it was typed, as 'hmdwarp study analyse' does. Parquet has it as
typed.

Privacy: participants are random words, which cannot be traced back from this folder. It holds no
date and no time of day: instants count from the beginning of a session, which BIDS writes as
1925-01-01. {_OF_MOTION if options.motion else "It holds no head motion."}
Participants who withdraw later must be erased here too, by hand: delete this folder and export again.
"""
