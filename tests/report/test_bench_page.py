"""The bench's page.

Escaped, accessible, and its charts by the chosen measure; what it says: test_words.py.
"""

import re

import needs
import pytest

from hmdwarp.report.bench.page import bench_page

from .bench_samples import a_bench, a_row, some_rows
from .test_page import Page, in_chromium, probe_of

WARPS = ("none", "rotation", "forward", "backward", "mesh_adaptive", "iterative:seed=forward,steps=3")
COMMAND = 'hmdwarp bench --out "<folder>" & more'


def a_small_bench(**changes) -> dict:
    rows = some_rows(WARPS, latencies=(200.0, 800.0), traces=("look-around",))
    return a_bench(rows=rows, command=COMMAND, **changes)


@pytest.fixture(scope="module")
def text() -> str:
    return bench_page(a_small_bench(notes=["The trace is <short>."])).html()


def test_the_tables_can_be_read_without_seeing_them(text):
    page = Page(text)
    attributes = page.attributes
    scopes = [value for tag, name, value in attributes if (tag, name) == ("th", "scope")]
    assert len(scopes) == page.tags.count("th") and set(scopes) == {"col", "row"}
    assert page.tags.count("caption") == page.tags.count("table") == 2
    assert text.count("<fieldset") == text.count("<legend") == 1 and page.tags.count("input") == 2
    said = [value for tag, name, value in attributes if (tag, name) == ("div", "aria-label")]
    assert len(said) == page.tags.count("table") + page.tags.count("svg") and all(len(words) > 15 for words in said)
    assert len(re.findall(r'role="img"[^>]*aria-label', text)) == page.tags.count("svg") + text.count('class="marked"')
    links = {value[1:] for tag, name, value in attributes if (tag, name) == ("a", "href")}
    assert links <= {value for tag, name, value in attributes if (tag, name) == ("section", "id")} and len(links) == 3
    assert page.tags.count("h1") == 1 and 'lang="en"' in text


def everything_nasty(value, nasty: str):
    """The same data with each text in it, but for the few that mean something to the page, made
    nasty.
    """
    if isinstance(value, dict):
        return {
            key: entry if key in ("clock", "name") else everything_nasty(entry, nasty) for key, entry in value.items()
        }
    if isinstance(value, list):
        return [everything_nasty(entry, nasty) for entry in value]
    return f"{nasty}{value}" if isinstance(value, str) else value


@pytest.mark.parametrize(
    "nasty", ["<script>alert(1)</script></code></style><i>", '" onload="x $x_1$ {{ 7*7 }} --> ]]> &amp; 漢字 ']
)
def test_texts_of_the_input_are_escaped(nasty):
    rows = [a_row(warp, fill, notes=["odd"]) for warp in ("none", "forward") for fill in ("none", "interpolate")]
    data = everything_nasty(a_bench(rows=rows, notes=["a note"]), nasty)
    data["rows"][0] = {**data["rows"][0], "effects": [nasty]}
    text = bench_page(data).html()
    page = Page(text)
    assert not {"script", "i"} & set(page.tags)
    assert not [name for _, name, _ in page.attributes if name.startswith("on")]
    found = page.text
    shown = " ".join(nasty.split())
    expected = "hmdwarp bench --out|look-around|forward|interpolate|llvmpipe|a note|odd|The GPU timer"
    assert [word for word in expected.split("|") if f"{shown}{word}" not in found.replace(f"{shown} ", shown)] == []


# Of the versions of a chart one is shown, by the choice of the measure.
PROBE = probe_of(
    "before, after: [seen('.by-flip svg'), seen('.by-psnr_db svg')]",
    """
  const seen = s => [...document.querySelectorAll(s)].filter(e => e.getBoundingClientRect().width > 0).length;
  const before = [seen(".by-flip svg"), seen(".by-psnr_db svg")];
  document.querySelectorAll("input[value=psnr_db]").forEach(e => e.click());
""",
)


@pytest.mark.slow
@needs.programs("chromium")
def test_a_measure_is_chosen_for_all_charts_in_chromium(text, tmp_path):
    found, console = in_chromium(text, tmp_path, probe=PROBE)
    assert console == "" and (found["before"], found["after"]) == ([2, 0], [0, 2])
