"""What a run's figures have to be, for CI: `--require`, and its results as JUnit XML."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Self
from xml.etree import ElementTree as Xml

import attrs

from .. import metrics, report
from ..errors import InputError, RequirementError, nearest, unknown_name
from ..options import Declared, option, out_field

_COMPARE: dict[str, Callable[[float, float], bool]] = {
    ">=": operator.ge, "<=": operator.le, ">": operator.gt, "<": operator.lt
}  # fmt: skip
_ONE = re.compile(r"\s*([^<>]+?)\s*(>=|<=|>|<)\s*([-+\w.]+)\s*(?:,|$)")
_FIGURE = re.compile(r"(?:(.+):)?(?:quality\.|time_ms\.)?(\w+)\.(\w+)")
# The rows of a bench or a comparison that differ in nothing else show the same late frames.
_SAME = ("trace", "scene", "latency_ms", "size", "headset", "rate_hz")

_PIXEL = "pixel"  # name of the pictures' tolerance
_HEADING = "For CI"

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
        is_time = self.name not in row["quality"]
        entry = row["time_ms"][self.name.removesuffix("_ms")] if is_time else row["quality"][self.name]
        value: float | None = entry[self.kind]
        return value

    def is_of(self, row: Row) -> bool:
        """Return whether a row is one of those that it speaks of."""
        return self.whose in ("", row["warp"], _pair(row), row.get("strategy", ""))


def _pair(row: Row) -> str:
    return f"{row['warp']}+{row['fill']}"


@attrs.frozen
class Requirement:
    """One of them: a figure, or the ratio of two, against a number."""

    text: str
    figure: Figure
    to: Figure | None
    relation: str
    limit: float

    def verdicts(self, rows: Sequence[Row], others: Sequence[Row]) -> Iterator[tuple[str, str]]:
        """Yield (which row, why it does not hold, or "") of each row that it speaks of."""
        spoken = [row for row in ([*rows, *others] if self.figure.whose else rows) if self.figure.is_of(row)]
        if not spoken:
            there = report.listed([*dict.fromkeys(row.get("strategy") or _pair(row) for row in [*rows, *others])])
            yield self.figure.whose, f"{self.text}: there is no result of '{self.figure.whose}'; there is {there}"
        for row in spoken:
            who = f"{row['strategy']}: {_pair(row)}" if row.get("strategy") else _pair(row)
            where = f"{who}, {row['trace']} in {row['scene']}, {row['latency_ms']:g} ms"
            value, why = self._value(row, [*rows, *others])
            if not why and not _COMPARE[self.relation](value, self.limit):
                why = f"it is {value:.6g}"
            yield where, f"{self.text}: {why} ({where})" if why else ""

    def _value(self, row: Row, among: Sequence[Row]) -> tuple[float, str]:
        value, base = self.figure.value(row), 1.0 if self.to is None else self._base(row, among)
        if isinstance(base, str):
            return 0.0, base
        if value is None or base is None:
            return 0.0, "it was not measured"
        if base == 0:
            return 0.0, f"{self.to.text if self.to else ''} is 0"
        return value / base, ""

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


def _parse(text: str) -> tuple[Requirement, ...]:
    found, end = [], 0
    while end < len(text):
        one = _ONE.match(text, end)
        limit = _number(one[3]) if one is not None else None
        if one is None or limit is None:
            raise InputError(
                f"--require {text}: expected FIGURE>=NUMBER, several with commas, such as "
                f"'psnr_db.mean>=28, flip.p95<=0.08'; found '{text[end:].strip()}'"
            )
        figure, _, to = one[1].partition("/")
        found.append(
            Requirement(one[0].strip(" ,"), Figure.of(figure), Figure.of(to) if to else None, one[2], limit)
        )  # fmt: skip
        end = one.end()
    return tuple(found)


def _number(text: str) -> float | None:
    try:
        value = float(text.encode("ascii"))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


@attrs.frozen
class Tolerance:
    """What two runs may differ by: metrics in their units, and pictures in levels of 255."""

    metrics: dict[str, float] = attrs.field(factory=dict)
    levels: float = 0.0

    def diff(self, first: report.StoredRun, second: report.StoredRun) -> report.RunDiff:
        """Return what differs between two runs. Errors: as report.diff_runs."""
        return report.diff_runs(first, second, self.metrics, self.levels)


def _tolerances(text: str) -> Tolerance:
    """Return tolerances by metric, and of pictures. Errors: InputError for another name."""
    found: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, _, number = part.partition("=")
        known = [*metrics.QUALITY, _PIXEL]
        if name.strip() not in known:
            near = nearest(name, known)
            raise InputError(
                f"--tolerance {part}: expected NAME=NUMBER, NAME one of {', '.join(known)}"
                + (f"; did you mean '{near}'?" if near else "")
            )
        try:
            found[name.strip()] = float(number.encode("ascii"))
        except ValueError as error:
            raise InputError(f"--tolerance {part}: expected a number after '=', found '{number}'") from error
        if not 0 <= found[name.strip()] < math.inf:
            raise InputError(f"--tolerance {part}: expected a number from 0")
    return Tolerance({name: value for name, value in found.items() if name != _PIXEL}, found.get(_PIXEL, 0.0))


def tolerance_field() -> Any:
    """Return the field of `--tolerance`: of metrics by name, and of pictures in levels of 255."""
    return option(
        Tolerance(),
        f"What two runs may differ by, such as 'psnr_db=0.05, {_PIXEL}=2'; {_PIXEL}: levels of 255.",
        kind=str,
        default="",
        parse=_tolerances,
        study="a study has no such result",
        heading=_HEADING,
    )


@attrs.frozen(kw_only=True)
class Baseline(Declared):
    """A stored run that another has to equal."""

    baseline: Path | None = option(
        None,
        "Folder of a stored replay, or its summary.json: end with status 4 where this one differs, times left out; "
        "see hmdwarp diff.",
        study="a study has no such result",
        heading=_HEADING,
    )
    tolerance: Tolerance = tolerance_field()

    def __attrs_post_init__(self) -> None:
        if self.baseline is None and self.tolerance != Tolerance():
            raise InputError("--tolerance without --baseline: nothing is compared; name a run, or leave it out")

    def stored(self, beside: Path) -> report.StoredRun | None:
        """Return the stored run, None without one. beside: where the new one goes.

        Errors: InputError where it is no replay, or would be overwritten.
        """
        if self.baseline is None:
            return None
        if self.baseline.absolute() == beside.absolute():
            raise InputError(f"--baseline {self.baseline}: this run goes there too; give it another --out")
        return report.StoredRun.of(self.baseline)

    def differences(self, stored: report.StoredRun | None, folder: Path, command: str) -> list[str] | None:
        """Return what a new run differs in, None without a stored one; where it does, write a page.

        Errors: InputError for files that cannot be read.
        """
        if stored is None:
            return None
        found = self.tolerance.diff(stored, report.StoredRun.of(folder))
        if not found.is_equal:
            report.write_text(folder / report.DIFF_PAGE, found.page(command))
        return [f"baseline: {line}" for line in found.lines()]


def hold(missed: Sequence[str]) -> None:
    """End where results do not hold. Errors: RequirementError, a line each."""
    if missed:
        raise RequirementError("\n".join(missed))


@attrs.frozen(kw_only=True)
class Requirements(Declared):
    """What results have to hold. Errors: InputError for what no figure is, or no number."""

    require: tuple[Requirement, ...] = option(
        (),
        "Exit with status 4 unless the results meet: 'psnr_db.mean>=28, flip.p95<=0.08'; a ratio of two with /, "
        "of one warp or strategy alone as NAME:FIGURE.",
        kind=str,
        default="",
        parse=_parse,
        study="a study has no such result",
        heading=_HEADING,
    )
    junit: Path | None = out_field(
        None,
        "Also write what --require and --baseline found to this file, as JUnit XML.",
        study="see --require",
        heading=_HEADING,
    )

    def prepare(self, *, force: bool, has_baseline: bool | None = None) -> None:
        """Check before a run what can be checked. Errors: InputError.

        has_baseline: None for a command that takes none.
        """
        if self.junit is not None and not self.require and not has_baseline:
            others = "" if has_baseline is None else " or --baseline"
            raise InputError(f"--junit {self.junit}: expected --require{others} too, whose results it holds")
        if self.junit is not None:
            report.refuse_existing(self.junit, force=force)

    def missed(
        self, rows: Sequence[Row], others: Sequence[Row] = (), differences: Sequence[str] | None = None
    ) -> list[str]:
        """Return a line for each that does not hold, and write the file of `--junit`.

        rows, others: with the keys of summary.json; others: those of comparisons, which count only
        where they are named. differences: from a stored run, None without one.
        Errors: as report.write_bytes.
        """
        found = [
            (one.text, where, [why] * bool(why)) for one in self.require for where, why in one.verdicts(rows, others)
        ]
        if differences is not None:
            found.append(("--baseline", "equal to the stored run", list(differences)))
        if self.junit is not None:
            report.write_bytes(self.junit, _junit(found))
        return [line for _, _, lines in found for line in lines]


def _junit(found: Sequence[tuple[str, str, Sequence[str]]]) -> bytes:
    suite = Xml.Element(
        "testsuite", name="hmdwarp", tests=str(len(found)), failures=str(sum(bool(lines) for *_, lines in found))
    )
    for name, where, lines in found:
        case = Xml.SubElement(suite, "testcase", classname=where, name=name)
        if lines:
            Xml.SubElement(case, "failure", message=lines[0]).text = "\n".join(lines[1:]) or None
    return bytes(Xml.tostring(suite, encoding="utf-8", xml_declaration=True))
