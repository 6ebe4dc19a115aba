"""What a run has to hold, for CI: `--require`, `--baseline`, and the verdict."""

from __future__ import annotations

import functools
import math
import operator
import os
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Self
from xml.etree import ElementTree as Xml

import attrs
from markupsafe import Markup

from .. import metrics, report
from ..base import Declared, InputError, RequirementError, option, out_field, unknown_name

_COMPARE: dict[str, Callable[[float, float], bool]] = {
    ">=": operator.ge, "<=": operator.le, ">": operator.gt, "<": operator.lt
}  # fmt: skip
_ONE = re.compile(r"\s*([^<>]+?)\s*(>=|<=|>|<)\s*([-+\w.]+)\s*(?:,|$)")
_FIGURE = re.compile(r"(?:(.+):)?(?:quality\.|time_ms\.)?(\w+)\.(\w+)")
# The rows of a bench or a comparison that differ in nothing else show the same late frames.
_SAME = ("trace", "scene", "latency_ms", "size", "headset", "rate_hz")

ALL, PIXEL, PIXELS = "figures", "pixel", "pixels"  # names of tolerances beside keys of the summary
_HEADING = "For CI"
_option = functools.partial(option, study="a study has no such result", heading=_HEADING)
_STEP_SUMMARY = "GITHUB_STEP_SUMMARY"

Row = Mapping[str, Any]


@attrs.frozen
class Figure:
    """A figure of the summary: `psnr_db.mean`, `total_ms.median`, `forward:psnr_db.mean`."""

    text: str
    # A warp, warp+fill or strategy; "" for any.
    whose: str
    name: str
    kind: str

    @classmethod
    def of(cls, text: str) -> Self:
        """Return the figure that a text names. Errors: InputError for an unknown one."""
        tables = {
            **dict.fromkeys(metrics.QUALITY, ("mean", "p95")),
            **{f"{stage}_ms": ("median", "p95") for stage in metrics.STAGES},
        }
        known = [f"{name}.{kind}" for name, kinds in tables.items() for kind in kinds]
        found = _FIGURE.fullmatch(text.strip())
        if found is None or f"{found[2]}.{found[3]}" not in known:
            named = text if found is None else f"{found[2]}.{found[3]}"
            raise InputError(f"--require {text}: {unknown_name('figure', named, known)}")
        return cls(text.strip(), found[1] or "", found[2], found[3])

    def value(self, row: Row) -> float | None:
        """Return it from a row with the keys of summary.json, None where it was not measured."""
        table = row["quality"] if self.name in row["quality"] else row["time_ms"]
        value: float | None = table[self.name.removesuffix("_ms")][self.kind]
        return value

    def is_of(self, row: Row) -> bool:
        """Return whether a row is one of those that it speaks of."""
        return self.whose in ("", row["warp"], _pair(row), row.get("strategy", ""))


def _pair(row: Row) -> str:
    return f"{row['warp']}+{row['fill']}"


@attrs.frozen
class Finding:
    """What came of a requirement in one row."""

    requirement: str
    row: str
    # "measured 28.21 dB", or why nothing was.
    found: str
    holds: bool

    def line(self, *, named: bool = False) -> str:
        """Return it as a line; named: with its row."""
        where = f" ({self.row})" if named else ""
        return f"{'met' if self.holds else 'FAILED'} {self.requirement}: {self.found}{where}"


@attrs.frozen
class _Requirement:
    """One of them: a figure, or the ratio of two, against a number."""

    figure: Figure
    to: Figure | None
    relation: str
    limit: str

    @property
    def text(self) -> str:
        """Return it as in messages."""
        ratio = f"/{self.to.text}" if self.to is not None else ""
        return f"{self.figure.text}{ratio} {self.relation} {self.limit}"

    def findings(self, rows: Sequence[Row], others: Sequence[Row]) -> Iterator[Finding]:
        """Yield what came of it in each row that it is about."""
        among = [*rows, *others]
        about = [row for row in (among if self.figure.whose else rows) if self.figure.is_of(row)]
        if not about:
            there = report.listed([*dict.fromkeys(row.get("strategy") or _pair(row) for row in among)])
            why = f"there is no result of '{self.figure.whose}'; there is {there}"
            yield Finding(self.text, self.figure.whose, why, False)
        for row in about:
            who = f"{row['strategy']}: {_pair(row)}" if row.get("strategy") else _pair(row)
            where = f"{who}, {row['trace']} in {row['scene']}, {row['latency_ms']:g} ms"
            value, base = self.figure.value(row), 1.0 if self.to is None else self._base(row, among)
            if isinstance(base, str) or value is None or not base:
                of_base = f"{self.to.text if self.to else ''} is 0" if base == 0 else "not measured"
                yield Finding(self.text, where, base if isinstance(base, str) else of_base, False)
                continue
            holds = _COMPARE[self.relation](value / base, float(self.limit))
            yield Finding(self.text, where, f"measured {self._measured(value / base, holds)}", holds)

    def _measured(self, value: float, holds: bool) -> str:
        """Return a value and its unit, with as many digits as show the side of the limit."""
        written = (f"{value:.{digits}g}" for digits in range(4, 18))
        text = next(one for one in written if _COMPARE[self.relation](float(one), float(self.limit)) == holds)
        figure = report.figure_of(self.figure.name)
        if self.to is not None:
            return text
        return f"{text} ({figure.text(value)} {figure.unit})" if figure.scale != 1 else f"{text} {figure.unit}".rstrip()

    def _base(self, row: Row, among: Sequence[Row]) -> float | str | None:
        assert self.to is not None
        if not self.to.whose:
            return self.to.value(row)
        found = [
            other for other in among if self.to.is_of(other) and all(other.get(key) == row.get(key) for key in _SAME)
        ]
        if len(found) != 1:
            return f"there are {len(found)} results of '{self.to.whose}' beside it, expected one; name warp+fill"
        return self.to.value(found[0])


def _parse(text: str) -> tuple[_Requirement, ...]:
    found, end = [], 0
    while end < len(text):
        one = _ONE.match(text, end)
        if one is None or not math.isfinite(_number(one[3])):
            raise InputError(
                f"--require {text}: expected FIGURE>=NUMBER, several with commas, such as "
                f"'psnr_db.mean>=28, flip.p95<=0.08'; found '{text[end:].strip()}'"
            )
        figure, _, to = one[1].partition("/")
        found.append(_Requirement(Figure.of(figure), Figure.of(to) if to else None, one[2], one[3]))
        end = one.end()
    return tuple(found)


def _number(text: str) -> float:
    """Return the number that a text is, NaN for another text."""
    try:
        return float(text.encode("ascii"))
    except ValueError:
        return math.nan


@attrs.frozen
class Tolerance:
    """What two runs may differ by, beyond rounding."""

    # (part of a key, such as `filled` or `quality.flip`, how much, whether of the stored value)
    figures: tuple[tuple[str, float, bool], ...] = ()
    # Of pictures: levels of 255, and the share of the pixels that may differ by more.
    pixels: tuple[float, float] = (0.0, 0.0)
    text: str = ""

    @classmethod
    def of(cls, text: str) -> Self:
        """Read "psnr_db=0.05, figures=0.1%, pixel=2, pixels=0.1%". Errors: InputError."""
        known = [*metrics.QUALITY, *report.SECTIONS, report.ROWS, ALL, PIXEL, PIXELS]
        found, of_pictures = [], {PIXEL: 0.0, PIXELS: 0.0}
        for part in filter(None, (part.strip() for part in text.split(","))):
            name, _, number = (piece.strip() for piece in part.partition("="))
            if name.partition(".")[0] not in known:
                raise InputError(f"--tolerance {part}: {unknown_name('figure', name, known)}")
            is_share = number.endswith("%") and name != PIXEL
            value = _number(number.removesuffix("%")) / 100 if is_share else _number(number)
            if not 0 <= value < math.inf:
                raise InputError(f"--tolerance {part}: found '{number}', expected NAME=NUMBER or NAME=PERCENT%, from 0")
            if name in of_pictures:
                of_pictures[name] = value
            else:
                found.append((name, value, is_share))
        return cls(tuple(found), (of_pictures[PIXEL], of_pictures[PIXELS]), text)

    def allows(self, key: str, stored: Any, now: Any) -> bool:
        """Return whether a figure may change so, by the entries that name it most closely."""
        named = {name: f".{key}.".find(f".{name}.") for name, *_ in self.figures}
        found = [name for name, at in named.items() if at >= 0]
        closest = max(found, key=lambda name: (named[name] + len(name), len(name)), default=ALL)
        most = [
            much * abs(stored or 0.0) if is_share else much for name, much, is_share in self.figures if name == closest
        ]
        return report.is_same(key, stored, now, max(most, default=0.0))

    def diff(self, first: report.StoredRun, second: report.StoredRun) -> report.RunDiff:
        return report.diff_runs(first, second, self.allows, self.pixels, self.text and f"tolerance '{self.text}'")


def tolerance_field() -> Any:
    return _option(
        Tolerance(),
        "What two runs may differ by, such as 'figures=0.1%, psnr_db=0.05, pixel=2, pixels=0.1%': figures by number or "
        "percentage, pixels by levels of 255 and how many may differ by more.",
        kind=str,
        default="",
        parse=Tolerance.of,
    )


@attrs.frozen(kw_only=True)
class Verdict:
    """What came of a run's requirements and of the comparison with its baseline."""

    findings: Sequence[Finding] = ()
    # None without a baseline.
    diff: report.RunDiff | None = None
    # The baseline that this run replaces.
    stores: Path | None = None

    @property
    def holds(self) -> bool:
        is_equal = self.diff is None or self.diff.is_equal or self.stores is not None
        return is_equal and all(one.holds for one in self.findings)

    @property
    def headline(self) -> str:
        """The verdict in one line."""
        every, failed = report.counted(len(self.findings), "requirement"), len(self.failures())
        parts = [
            f"{failed} of {every}" if failed else f"{every} met" if self.findings else "",
            f"baseline: {self.diff.told()}" if self.diff is not None else "",
            f"{'' if self.holds else 'not '}stored in {self.stores}" if self.stores is not None else "",
        ]
        return f"{'PASSED' if self.holds else 'FAILED'}: {'; '.join(filter(None, parts)) or 'nothing was required'}"

    def failures(self) -> list[str]:
        """Return the requirements that do not hold, a line each."""
        several = len({one.row for one in self.findings}) > 1
        return [one.line(named=several) for one in self.findings if not one.holds]

    def text(self) -> str:
        """Return the whole verdict for a terminal, the headline first."""
        found = [] if self.diff is None else self.diff.lines()
        page = [f"pictures and charts: {self.diff.second.named / report.DIFF_PAGE}"] if found and self.diff else []
        return "\n".join([self.headline, *self.failures(), *found, *page])

    def section(self) -> report.Section:
        styles = ["yes" if one.holds else "no" for one in self.findings]
        found = report.Sentences([one.line() for one in self.findings], styles, "said")
        link = report.Text(Markup('Pictures and charts: <a href="{0}">{0}</a>').format(report.DIFF_PAGE))
        differences = [*self.diff.blocks(), link] if self.diff is not None and not self.diff.is_equal else []
        return report.Section(self.headline, [found, *differences])

    def entry(self) -> dict[str, Any]:
        """Return the `gate` of summary.json."""
        baseline = None if self.diff is None else {"stored": str(self.diff.first.named), **self.diff.entry()}
        found = [attrs.asdict(one) for one in self.findings]
        return {"passed": self.holds, "verdict": self.headline, "requirements": found, "baseline": baseline}

    def junit(self, seconds: float) -> bytes:
        """Return it as JUnit XML, a test each; the first is the run itself, which took so long."""
        cases = [("hmdwarp", "run", "")]
        cases += [(one.row, one.requirement, "" if one.holds else one.found) for one in self.findings]
        if self.diff is not None:
            changed = {one.key: " -> ".join(one.texts()[:2]) for one in self.diff.figures}
            cases += [("baseline", key, changed.get(key, "")) for key in self.diff.compared]
            cases += [("baseline", "all else", "\n".join(self.diff.lines(figures=False)))]
        failed = [bool(why) and (self.stores is None or of != "baseline") for of, _, why in cases]
        about = {"tests": str(len(cases)), "failures": str(sum(failed)), "time": f"{seconds:.3f}"}
        suite = Xml.Element("testsuite", about, name="hmdwarp")
        for (of, name, why), is_failure in zip(cases, failed, strict=True):
            took = f"{seconds if name == 'run' else 0:.3f}"
            case = Xml.SubElement(suite, "testcase", classname=of, name=name, time=took)
            if is_failure:
                Xml.SubElement(case, "failure", message=why.partition("\n")[0]).text = why
        return bytes(Xml.tostring(suite, encoding="utf-8", xml_declaration=True))


@attrs.frozen(kw_only=True)
class Requirements(Declared):
    """What results have to hold. Errors: InputError for what no figure is, or no number."""

    require: tuple[_Requirement, ...] = _option(
        (),
        "Exit with status 4 unless the results meet: 'psnr_db.mean>=28, flip.p95<=0.08'; a ratio of two with /, "
        "of one warp or strategy alone as NAME:FIGURE.",
        kind=str,
        default="",
        parse=_parse,
    )
    junit: Path | None = out_field(
        None,
        "Also write the run's time and what --require and --baseline found to this file, as JUnit XML.",
        study="see --require",
        heading=_HEADING,
    )
    # When the run began.
    began_s: float = attrs.field(init=False, factory=time.monotonic)

    def prepare(self, *, force: bool) -> None:
        """Check before a run what can be checked. Errors: InputError."""
        if self.junit is not None:
            report.refuse_existing(self.junit, force=force)

    def judge(self, rows: Sequence[Row], others: Sequence[Row] = ()) -> Verdict:
        """Return what came of the requirements.

        rows: as summary.json. others: of comparisons, which count only where they are named.
        """
        return Verdict(findings=[found for one in self.require for found in one.findings(rows, others)])

    def end(self, verdict: Verdict) -> None:
        """Write the files of `--junit` and GitHub. Errors: RequirementError by the verdict."""
        if self.junit is not None:
            report.write_bytes(self.junit, verdict.junit(time.monotonic() - self.began_s))
        page = os.environ.get(_STEP_SUMMARY)
        if page and (verdict.findings or verdict.diff):
            try:
                with Path(page).open("a", encoding="utf-8") as file:
                    headline, *lines = verdict.text().splitlines()
                    file.write("\n".join([f"### hmdwarp {headline}", "", "```text", *lines, "```", "", ""]))
            except OSError as error:
                raise report.write_error(error, Path(page)) from error
        if not verdict.holds:
            raise RequirementError(verdict.text())


@attrs.frozen(kw_only=True)
class Gate(Requirements):
    """What a replay has to hold, and a stored run that it has to equal."""

    baseline: Path | None = _option(
        None,
        "Folder of a stored replay, or its summary.json: end with status 4 where this one differs, times left out; "
        "see hmdwarp diff.",
    )
    tolerance: Tolerance = tolerance_field()
    update_baseline: bool = _option(
        False,
        "Store this run as the --baseline, in place of the one that is there, where the requirements are met.",
    )

    def __attrs_post_init__(self) -> None:
        for said, flag in ((self.tolerance != Tolerance(), "--tolerance"), (self.update_baseline, "--update-baseline")):
            if said and self.baseline is None:
                raise InputError(f"{flag} without --baseline: nothing is compared; name a run, or leave it out")

    def judge_of(self, out: Path) -> Callable[[Any, report.StoredRun], Verdict] | None:
        """Return what judges a replay that goes to `out`, None where nothing is required of it.

        Errors: InputError where the baseline is no replay, or would be overwritten.
        """
        stored = None
        if self.baseline is None and self.junit is None and not self.require:
            return None
        if self.baseline is not None and self.baseline.absolute() == out.absolute():
            raise InputError(f"--baseline {self.baseline}: this run goes there too; give it another --out")
        if self.baseline is not None and (self.baseline.exists() or not self.update_baseline):
            stored = report.StoredRun.of(self.baseline)
        return lambda result, new: attrs.evolve(
            self.judge([new.summary], result.against),
            diff=None if stored is None else self.tolerance.diff(stored, new),
            stores=self.baseline if self.update_baseline else None,
        )

    def store(self, verdict: Verdict, folder: Path) -> None:
        """Store the run of a folder as the baseline, if that is wanted. Errors: as OutputFolder."""
        place = verdict.stores
        if place is None or not verdict.holds:
            return
        summary = {name: value for name, value in report.StoredRun.of(folder).summary.items() if name != "gate"}
        if place.suffix == ".json":
            report.write_json(place, summary)
            return
        with report.OutputFolder(place, owned=("images/*.png",), force=True) as out:
            for name in summary["digests"]:
                out.write_bytes(name, (folder / name).read_bytes())
            out.write_json("summary.json", summary)
