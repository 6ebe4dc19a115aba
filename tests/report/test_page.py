"""report.html: escaped, self-contained, and whole in a real browser."""

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
from web.browser import Browser

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.metrics import Alike, Compared, MeasuringThreads, QualityJob, QualityPool, metrics
from hmdwarp.report import WorstFrame, columns_of, render_live_report, render_report
from hmdwarp.report.bench.page import bench_page

from .samples import a_baseline, a_column, a_live_summary, a_scene, a_summary, some_rows, some_worst

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


def addresses(page: Page) -> list[str]:
    """What attributes name, those of scripts too; there is no other tag that loads."""
    assert not {"link", "iframe", "object", "embed"} & set(page.tags)
    names = {"src", "href", "xlink:href", "srcset", "poster", "action", "data"}
    return [value for _, name, value in page.attributes if name in names]


def test_texts_of_the_user_are_escaped():
    text = render(
        command="</code><script>alert(1)</script>",
        notes=["<b>bold</b>"],
        summary={**a_summary(), "trace": "<i>x</i>.csv"},
    )
    assert text.count("<script") == 1 and "<b>bold" not in text and "<i>x" not in text
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
    alike, flip = Alike(np.full(truth.shape[:2], 0.25, np.float32), 0.5), np.full(truth.shape[:2], 64, np.uint8)
    pool = QualityPool(MeasuringThreads(0), worst=1)
    compared = Compared(shown, truth, view)
    pool.submit((3, 1), QualityJob(compared, rendered_picture=rendered, alike=alike, beside=(("none", other, flip),)))
    (kept,) = pool.worst
    frame = WorstFrame(0.5, kept.key[1], columns_of(kept), kept.result.values)
    own, others = "error (FLIP 0 to 0.5)", "error of none"
    names = [[name for name, _ in column] for column in frame.columns]
    assert names == [["truth", "late frame"], ["warped", own], ["none", others]]
    for column, pictures in zip(frame.columns, ((truth, rendered), (shown,), (other,)), strict=True):
        assert all(np.array_equal(one, picture) for (_, one), picture in zip(column, pictures, strict=False))
    assert np.array_equal(frame.columns[1][1][1], frame.columns[2][1][1])  # both have FLIP 0.25
    assert "0.50 s, right eye" in render(worst=[frame])


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
    line: getComputedStyle(document.querySelector(".chart [style*='stroke: var(--series-1)']")).stroke,
""")


def in_chromium(
    text: str, tmp_path: Path, *, width: int = 1280, dark: bool = False, probe: str = PROBE
) -> tuple[dict, str]:
    """What a probe inside a copy of the page found, and the page's own console messages."""
    policy = re.search(r'<meta http-equiv="Content-Security-Policy"[^>]*>', text)[0]
    # The probe is the only thing that the page's own policy would not let run; all the rest of it
    # stays in force.
    others = re.sub("; script-src '[^']*'", "", policy)
    allowed = others.replace("default-src 'none'", "default-src 'none'; script-src 'unsafe-inline'")
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


def page_of(kind: str) -> str:
    from .bench_samples import a_bench, a_row

    if kind == "bench":
        return bench_page(a_bench(rows=[a_row(warp) for warp in ("none", "forward", "mesh")])).html()
    return render() if kind == "replay" else render_live_report(a_live_summary(), a_column(), command="")


@pytest.mark.parametrize("kind", ["replay", "bench", "live"])
def test_a_page_fetches_no_file_and_names_nothing_twice(kind):
    """Only data: addresses and fragments of the page itself, in attributes and in style sheets."""
    text = page_of(kind)
    page = Page(text)
    assert all(a.startswith(("data:image/", "#")) for a in addresses(page))
    assert set(re.findall(r"url\((.)", text)) <= {"#"}
    ids = [value for _, name, value in page.attributes if name == "id"]
    assert len(ids) == len(set(ids)) and text == page_of(kind)
    used, given = set(re.findall(r"var\((--[\w-]+)\)", text)), set(re.findall(r'(--[\w-]+)(?::|", )', text))
    assert used <= given


@pytest.mark.slow
@needs.programs("chromium")
class TestInChromium:
    @pytest.mark.parametrize("kind, charts", [("replay", 3), ("bench", 1), ("live", 6)])
    @pytest.mark.parametrize("width, dark", [(1280, True), (500, False)])
    def test_whole_quiet_and_alone(self, kind, charts, width, dark, tmp_path):
        found, console = in_chromium(page_of(kind), tmp_path, width=width, dark=dark)
        assert console == "" and found["faults"] == [] and found["requests"] == []
        assert len(found["images"]) == 24 * (kind == "replay")
        for complete, natural_width, natural_height, shown_width, shown_height in found["images"]:
            assert complete and natural_width > 0 and natural_height > 0 and shown_width > 50 and shown_height > 50
        seen = [box for box in found["charts"] if box[0]]
        charts += (kind == "replay") * sum(bool(metric.chart) for metric in metrics)
        assert len(seen) == charts and all(w > 200 and h > 80 for w, h in seen)
        assert found["wider"] <= 0  # nothing sticks out sideways, tables scroll in their own box
        darkness = sum(map(int, re.findall(r"\d+", found["paper"])[:3]))
        assert darkness < 150 if dark else darkness > 600
        assert found["line"] == "rgb(0, 114, 178)"

    def test_a_slider_covers_what_was_warped_with_the_truth(self, text, tmp_path):
        """By keys and by touch, also where a picture is enlarged; without scripts there is none."""
        (tmp_path / "page.html").write_text(text, encoding="utf-8")
        enlarged, box = "document.querySelectorAll('.zoom:has(:checked) img')", "one => one.getBoundingClientRect()"
        with Browser((390, 780)) as browser:
            browser.open((tmp_path / "page.html").as_uri())
            browser.until("document.querySelectorAll('.slides .over').length === 6")
            browser.does("(globalThis.slider = document.querySelector('.slider input')).focus()")
            for kind in ("rawKeyDown", "keyUp") * 3:
                browser.send("Input.dispatchKeyEvent", type=kind, key="ArrowRight", windowsVirtualKeyCode=39)
            cut = "[...document.querySelectorAll('.over')].map(one => getComputedStyle(one).clipPath)"
            assert browser.does(cut) == ["inset(0px 97% 0px 0px)"] * 2 + ["inset(0px 100% 0px 0px)"] * 4
            browser.does("document.querySelector('.slides .over').click()")
            boxes = browser.does(f"[...{enlarged}].map({box}).map(one => one.toJSON())")
            assert boxes[0] == boxes[1] and boxes[0]["width"] == browser.does("innerWidth")
            at = browser.does(f"(({box})(slider)).toJSON()")
            where = {"x": at["x"] + 0.75 * at["width"], "y": at["y"] + at["height"] / 2}
            for kind, points in (("touchStart", [where]), ("touchEnd", [])):
                browser.send("Input.dispatchTouchEvent", type=kind, touchPoints=points)
            # The thumb is at most 10 % of the control, and its middle goes to the finger.
            browser.until("Math.abs(slider.value - 75) <= 5")
            browser.send("Input.dispatchKeyEvent", type="rawKeyDown", key="Escape", windowsVirtualKeyCode=27)
            assert browser.does(f"{enlarged}.length") == 0 and browser.said == []
            browser.send("Emulation.setScriptExecutionDisabled", value=True)
            browser.open((tmp_path / "page.html").as_uri())
            browser.until("document.readyState === 'complete' && document.images.length === 18")
            assert browser.does("getComputedStyle(document.querySelector('.slider')).display") == "none"
