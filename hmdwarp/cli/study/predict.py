"""hmdwarp study predict: which picture measure follows the ratings, over one study or several."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import typer

from ...options import Declared, option
from .._options import JSON, Said, as_json, takes
from ._options import origin_of, pilot_field, simulated_field


@attrs.frozen
class PredictOptions(Declared):
    """Whose ratings to predict."""

    studies: tuple[str, ...] = option(
        attrs.NOTHING,
        "Studies: .toml files with their data beside them, or names of shipped ones.",
        kind=list,
        positional=True,
        metavar="STUDY",
        names_files=True,
    )
    scale: str = option("", "Scale of the ratings; by default the first that all studies have.")
    pilot: bool = pilot_field()
    simulated: bool = simulated_field()


@takes(PredictOptions, JSON)
def predict(said: Said) -> None:
    """Say which picture measure follows the ratings best, over all studies given, and how surely.

    Pictures must have been measured (`study measure`). The choice of the measure is tested on
    people who took no part in it.
    """
    from ...errors import InputError
    from ...study.analysis import SourceOptions, ratings_from
    from ...study.prediction import pooled, prediction_data

    options = PredictOptions.of(said)
    places = [Path(name).resolve() for name in options.studies]
    if doubled := [name for name, place in zip(options.studies, places, strict=True) if places.count(place) > 1]:
        raise InputError(f"{doubled[0]} is given twice: its people would count twice")
    source = SourceOptions({}, "", None, origin_of(options.pilot, options.simulated))
    found = {name: ratings_from(name, None, source).long for name in options.studies}
    scale, rows = pooled(found, options.scale)
    data = prediction_data(rows, scale)
    if data is None:
        raise InputError("no picture of these studies was measured: 'hmdwarp study measure STUDY' first")
    if said["json"]:
        typer.echo(as_json({"scale": scale, "studies": list(options.studies), **data}))
    else:
        _print(data, scale, options.studies)


def _print(data: dict[str, Any], scale: str, studies: tuple[str, ...]) -> None:
    from ...report import listed
    from ...report.study import prediction_lines
    from .._show import console, paragraph
    from .analyse import lines_as_table

    paragraph(f"Ratings on {scale} of {listed(studies)}.")
    if data["measures"]:
        typer.echo()
        console().print(lines_as_table("What goes with the ratings", *prediction_lines(data["measures"])))
    for sentence in data["sentences"]:
        typer.echo()
        paragraph(sentence)
