"""report.html: complete, escaped, self-contained, and whole in a real browser."""

import base64
import html
import io
import json
import re
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import needs
import numpy as np
import pytest
from PIL import Image

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.metrics import REGIONS, Alike, Compared, MeasuringProcesses, QualityJob, QualityPool, aggregate
from hmdwarp.report import WorstFrame, render_report

from .samples import a_baseline, a_scene, a_summary, some_rows, some_worst

COMMAND = 'hmdwarp replay "my trace.csv" --scene room --out <folder> & more'
NOTES = ["3 poses were <predicted>."]


def render(**changes) -> str:
    rows, baseline_rows = some_rows(0, seconds=4), some_rows(1, seconds=4, worse=2)
    given = {"summary": a_summary(rows), "baselines": [a_baseline(rows, baseline_rows)], "rows": rows}
    given |= {"baselines_rows": [baseline_rows], "worst": some_worst(), "command": COMMAND, "notes": NOTES}
    return render_report(**{**given, **changes})


@pytest.fixture(scope="module")
def text() -> str:
    return render()


class Page(HTMLParser):
    """Text, tags and attributes; fails on tags that do not close in order."""

    VOID = frozenset({"meta", "img", "br", "wbr", "input", "path", "use", "rect"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.words, self.attributes, self.tags, self._open = [], [], [], []
        self.feed(text)
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag not in self.VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, name, value) for name, value in attrs]

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self._open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def test_everything_is_on_the_page(text):
    page = Page(text)
    summary = a_summary(some_rows(0, seconds=4))
    wanted = [COMMAND, NOTES[0]]
    words = "llvmpipe (LLVM 15.0.6, 256 bits)|Mesa 22.3.6|wall clock|look-around|rift-dk1|640×400|200 ms|360 frames"
    words += "|PSNR|SSIM|FLIP|Holes|Flicker|How to read this|4.20 s, right eye|72 of 720 pictures measured"
    wanted += words.split("|")
    wanted += [f"{summary['quality']['psnr_db']['mean']:.2f}", f"{summary['time_ms']['total']['p95']:.2f}", "★"]
    assert [word for word in wanted if word not in page.text] == []
    assert page.tags.count("img") == 12 and page.tags.count("svg") == 7


def test_the_error_is_told_by_region():
    """Of each region its share, PSNR and FLIP; no section where nothing was measured."""
    words = " ".join(Page(render()).words)
    assert re.search(r"silhouettes\s+6\.20\s+24\.70\s+0\.1600", words)
    unmeasured = {name: {"share": None, "psnr_db": None, "flip": None} for name in REGIONS}
    for regions in (unmeasured, {}):
        assert "Where the error lies" not in render(
            summary={**a_summary(), "regions": regions}, baselines=[], baselines_rows=[]
        )


def addresses(page: Page) -> list[str]:
    """What attributes name; there is no tag that loads."""
    assert not {"script", "link", "iframe", "object", "embed"} & set(page.tags)
    names = {"src", "href", "xlink:href", "srcset", "poster", "action", "data"}
    return [value for _, name, value in page.attributes if name in names]


def test_the_page_fetches_no_file(text):
    """Only data: addresses and fragments of the page itself, in attributes and in style sheets."""
    found = addresses(Page(text))
    assert found and all(a.startswith(("data:image/", "#")) for a in found)
    assert set(re.findall(r"url\(([^)]{0,3})", text)) <= {"#" + c + d for c in "p" for d in "0123456789abcdef"}


def test_texts_of_the_user_are_escaped():
    text = render(
        command="</code><script>alert(1)</script>",
        notes=["<b>bold</b>"],
        summary={**a_summary(), "trace": "<i>x</i>.csv"},
    )
    assert "<script" not in text and "<b>bold" not in text and "<i>x" not in text
    assert "<b>bold</b>" in Page(text).text


def test_pictures_are_whole_and_have_their_size(text):
    for tag, name, value in Page(text).attributes:
        if (tag, name) == ("img", "src"):
            with Image.open(io.BytesIO(base64.b64decode(value.split(",", 1)[1]))) as image:
                image.load()
                assert image.size == (320, 200)


def test_worst_frames_come_from_what_the_pool_kept():
    truth, shown, rendered, other = a_scene(0), a_scene(2), a_scene(9), a_scene(5)
    view = View(Pose(), Fov.symmetric(1.5, 1.0))
    alike = Alike(np.full(truth.shape[:2], 0.25, np.float32), 0.5)
    pool = QualityPool(MeasuringProcesses(0), worst=1)
    compared = Compared(shown, truth, view)
    pool.submit((3, 1), QualityJob(compared, rendered_picture=rendered, alike=alike, beside=(("none", other),)))
    (kept,) = pool.worst
    frame = WorstFrame.of(0.5, kept.key[1], kept)
    assert [name for name, _ in frame.panels] == ["truth", "late frame", "warped", "none", "error (FLIP 0 to 0.5)"]
    assert all(
        np.array_equal(picture, source)
        for (_, picture), source in zip(frame.panels, (truth, rendered, shown, other), strict=False)
    )
    assert "0.50 s, right eye" in render(worst=[frame])


def test_the_axes_of_the_trace_are_on_the_page():
    axes = "ros (world=-y,z,x head=-y,z,x), assumed; the motion agrees"
    assert f"in axes {axes} ·" in Page(render(summary={**a_summary(), "trace_axes": axes})).text


def test_without_baseline_worst_frames_notes_or_any_measurement():
    rows = [{"frame": 0, "eye": 0, "time_s": 0.0, "angular_speed_deg_s": 1.0, "linear_speed_m_s": 0.0}]
    nothing = {"baselines": [], "baselines_rows": [], "worst": [], "notes": []}
    text = render(summary={**a_summary(), **aggregate([])}, rows=rows, **nothing)
    page = Page(text)
    assert "★" not in page.text and "Worst frames" not in page.text and "<h2>Notes</h2>" not in text
    assert page.text.count("not measured") == 5 and "–" in page.text


def test_the_same_run_gives_the_same_page():
    first, second = (render_report(a_summary(), rows=some_rows(seconds=1), command="x") for _ in range(2))
    assert first == second


CHROMIUM = needs.program("chromium")
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--hide-scrollbars", "--enable-logging=stderr", "--virtual-time-budget=5000",
]  # fmt: skip
# Chromium's own remarks on the machine (no D-Bus, no GPU) are no messages of the page.
PAGE_MESSAGE = re.compile(r":CONSOLE[:(]\d+")


def probe_of(found: str, before: str = "") -> str:
    """A script that puts what it found into the page, as JSON. before: what it does first."""
    return f"""<script>
const faults = [];
addEventListener("error", e => faults.push("error: " + (e.message || e.target.outerHTML.slice(0, 80))), true);
addEventListener("unhandledrejection", e => faults.push("rejected: " + e.reason));
addEventListener("securitypolicyviolation", e => faults.push("blocked: " + e.blockedURI));
addEventListener("load", () => {{
  const box = e => {{ const b = e.getBoundingClientRect(); return [b.width, b.height]; }};
  const out = document.createElement("pre");
  {before}
  out.id = "probe";
  out.textContent = JSON.stringify({{
    faults,
    requests: performance.getEntriesByType("resource").map(e => e.name).filter(n => !n.startsWith("data:")),
    wider: document.documentElement.scrollWidth - innerWidth,
    paper: getComputedStyle(document.body).backgroundColor,
    {found}
  }});
  document.body.append(out);
}});
</script>"""


PROBE = probe_of("""
    images: [...document.images].map(i => [i.complete, i.naturalWidth, i.naturalHeight, ...box(i)]),
    charts: [...document.querySelectorAll("svg")].map(box),
    line: getComputedStyle(document.querySelector(".chart path[style*='--series-1']")).stroke,
""")


def in_chromium(
    text: str, tmp_path: Path, *, width: int = 1280, dark: bool = False, probe: str = PROBE
) -> tuple[dict, str]:
    """What a probe inside a copy of the page found, and the page's own console messages."""
    policy = re.search(r'<meta http-equiv="Content-Security-Policy"[^>]*>', text)[0]
    # The probe is the only thing that the page's own policy would not let run; all the rest of it
    # stays in force.
    allowed = policy.replace("default-src 'none'", "default-src 'none'; script-src 'unsafe-inline'")
    copy = tmp_path / "copy.html"
    copy.write_text(text.replace(policy, allowed + probe), encoding="utf-8")
    options = [f"--blink-settings=preferredColorScheme={0 if dark else 1}", f"--window-size={width},900"]
    command = [CHROMIUM, *FLAGS, *options, f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", copy.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    found = re.search(r'<pre id="probe">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found, done.stderr[-2000:]
    return json.loads(html.unescape(found[1])), "\n".join(
        line for line in done.stderr.splitlines() if PAGE_MESSAGE.search(line)
    )


@pytest.mark.slow
@needs.programs("chromium")
class TestInChromium:
    @pytest.mark.parametrize("width, dark", [(1280, False), (1280, True), (500, False)])
    def test_whole_quiet_and_alone(self, text, width, dark, tmp_path):
        found, console = in_chromium(text, tmp_path, width=width, dark=dark)
        assert console == "" and found["faults"] == [] and found["requests"] == []
        assert len(found["images"]) == 12 and len(found["charts"]) == 7
        for complete, natural_width, natural_height, shown_width, shown_height in found["images"]:
            assert complete and natural_width > 0 and natural_height > 0 and shown_width > 50 and shown_height > 50
        assert all(w > 200 and h > 80 for w, h in found["charts"])
        assert found["wider"] <= 0  # nothing sticks out sideways, tables scroll in their own box
        darkness = sum(map(int, re.findall(r"\d+", found["paper"])[:3]))
        assert darkness < 150 if dark else darkness > 600
        assert found["line"] == "rgb(0, 114, 178)"

    def test_the_probe_sees_faults(self, tmp_path):
        """Otherwise the test above proves nothing.

        A broken picture, a request and an exception must show.
        """
        text = render(worst=[])
        broken = '<img src="data:image/png;base64,AAAA"><img src="https://example.invalid/x.png">'
        broken += '<script>console.error("oh"); throw new Error("ah")</script>'
        found, console = in_chromium(text.replace("</main>", broken + "</main>"), tmp_path)
        assert [i[1] for i in found["images"]] == [0, 0]
        assert any("blocked" in f for f in found["faults"]) and any("ah" in f for f in found["faults"])
        assert "oh" in console
