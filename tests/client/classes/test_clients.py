"""Client classes: what each can do is what plans for it use, by every route that chooses one."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import pytest
from together import together

import hmdwarp.client.classes
from hmdwarp.base import InputError, PlanError, UnknownNameError
from hmdwarp.client import every_fill, every_warp
from hmdwarp.client.classes import client_names, load_client
from hmdwarp.client.fills import fills
from hmdwarp.client.warps import warps
from hmdwarp.frames.layers import layers
from hmdwarp.gpu import Gpu, ShaderLibrary, flatten
from hmdwarp.link.codec import Coding
from hmdwarp.pipeline import PipelineOptions, build_plan_for
from hmdwarp.run import RunOptions, replay

FOLDER = Path(hmdwarp.client.classes.__file__).parent
BY_ITSELF = re.compile(r"\batomic\w+\(|\bimageAtomic\w+\(|\bshared\b|\bbarrier\(|\bbuffer\b")


def test_a_better_class_can_all_that_a_worse_one_can():
    classes = [load_client(f"class-{number}") for number in (1, 2, 3)]
    for worse, better in zip(classes[:-1], classes[1:], strict=True):
        assert better.has(worse.scene) and better.compute_shaders >= worse.compute_shaders
        assert better.budget_ms > worse.budget_ms and better.decoder_mpx_s > worse.decoder_mpx_s
        assert better.download_mbit_s > worse.download_mbit_s


def _plan(client: str, warp: str, fill: str):
    return build_plan_for(PipelineOptions(client=client, warp=warp, fill=fill, lens="none"), None, None)


@together("number, name, warp", [(k, *both) for k, both in enumerate(product(client_names(), every_warp()))])
def test_no_plan_for_a_client_uses_what_it_lacks(number, name, warp):
    """By what the steps read, and by settings of fills; of these each warp has every third."""
    client, sent = load_client(name), {layer.readable() for layer in layers if layer.drawn_by}
    for fill in every_fill()[number % 3 :: 3]:
        try:
            plan = _plan(name, warp, fill)
        except PlanError as error:
            assert f"client '{name}' cannot run warp '{warp.partition(':')[0]}" in str(error)
            continue
        read = {each for step in plan.steps for each in step.reads}
        if client.scene == "none":
            assert not {each for each in read if each.startswith("client.")}
        if client.scene == "reduced":
            assert all(getattr(each.settings, "share", 0.0) < 1 for each in (plan.choice, *plan.fills))
        if not client.more_layers:
            assert not read & sent
        if not client.compute_shaders:
            assert not plan.warp.needs_compute and not any(
                each.entry.needs_compute_for(each.settings) for each in plan.fills
            )


@together("warp, fill", product(warps.names(), fills.names()))
def test_a_client_with_everything_can_run_everything(warp, fill):
    assert _plan("class-3", warp, fill).steps == _plan("", warp, fill).steps


def test_the_thesis_s_own_assignment():
    """Section 1.3: which class can do what, where its time does not decide."""
    allowed = {
        ("none", "none"): (1, 2, 3),
        ("environment", "none"): (1, 2, 3),
        ("forward", "interpolate"): (2, 3),
        ("backward", "none"): (2, 3),
        ("forward", "model"): (2, 3),
        ("forward", "model:share=1"): (3,),
    }
    for (warp, fill), classes in allowed.items():
        for number in (1, 2, 3):
            if number in classes:
                _plan(f"class-{number}", warp, fill)
            else:
                with pytest.raises(PlanError, match=f"client 'class-{number}' cannot run warp '{warp}'"):
                    _plan(f"class-{number}", warp, fill)


class Recorder(ShaderLibrary):
    """Remembers the compute shaders that are asked for."""

    def __init__(self, gl) -> None:
        super().__init__(gl)
        self.texts: list[str] = []

    def compute(self, path, **defines):
        self.texts.append("\n".join(flatten(path, defines).lines))
        return super().compute(path, **defines)


@pytest.mark.parametrize("fill", ["interpolate:size=5", "interpolate:size=7"])
def test_larger_kernels_run_over_a_list_so_they_take_compute_shaders(fill):
    _plan("class-1", "rotation", "interpolate")
    with pytest.raises(PlanError, match=f"fill '{fill}' cannot do without compute shaders"):
        _plan("class-1", "rotation", fill)


@pytest.mark.parametrize(
    "entry",
    [each for each in (*warps, *fills) if not each.needs_compute and getattr(each, "kind", "") != "draw"],
    ids=lambda e: e.name,
)
def test_passes_without_compute_shaders_share_nothing_between_pixels(gpu: Gpu, entry):
    before, gpu.shaders = gpu.shaders, Recorder(gpu.gl)
    try:
        entry(gpu, (9, 7), (8, 6)).close()
        texts = gpu.shaders.texts
    finally:
        gpu.shaders = before
    assert texts or not getattr(entry, "is_pass", True)
    # Which groups of pixels run at all is a fragment shader's geometry: a list that is only read.
    texts = [re.sub(r"#ifdef HIDES.*?#else|//[^\n]*", "", text, flags=re.DOTALL) for text in texts]
    assert not [found[0] for text in texts for found in BY_ITSELF.finditer(text)]


# --- the chooser --------------------------------------------------------------------------------


def test_a_class_brings_its_budget_and_download_where_nothing_else_was_said():
    known = PipelineOptions.of({"client": "class-2", "warp": "auto", "codec": "h264"})
    assert (known.budget_ms, known.network.bandwidth.mbit) == (2.8, 50.0)
    said = PipelineOptions.of({"client": "class-2", "warp": "auto", "budget": 4.0, "codec": "h264", "bandwidth": "7"})
    assert (said.budget_ms, said.network.bandwidth.mbit) == (4.0, 7.0)
    uncoded = PipelineOptions.of({"client": "class-2", "warp": "forward"})
    assert (uncoded.budget_ms, uncoded.network.bandwidth) == (None, None)


def test_a_decoder_that_is_too_slow_is_told(gpu, tmp_path):
    """2 eyes x 2 pictures (colour, depth) x 96x80 px x 60 Hz: 1.84 Mpx/s."""
    slow = tmp_path / "slow.toml"
    slow.write_text('summary = "a slow decoder"\nscene = "none"\ncompute_shaders = true\ndecoder_mpx_s = 1.8\n')
    usual = {"trace": "still", "scene": "planes", "size": (96, 80), "rate_hz": 60.0, "seconds": 0.1, "lens": "none"}
    usual |= {"guard": 1.0}
    with pytest.raises(InputError, match="are 2 Mpx/s to decode: client 'slow' decodes 1.8"):
        replay(RunOptions(**usual, out=tmp_path / "coded", client=str(slow), coding=Coding("h264")))
    replay(RunOptions(**usual, out=tmp_path / "out", client=str(slow)))  # nothing is decoded


# --- files --------------------------------------------------------------------------------------

GOOD = (FOLDER / "class-2.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (GOOD.replace('"reduced"', '"some"'), "scene is 'some': expected none, reduced or whole"),
        (GOOD.replace("budget_ms = 2.8", "budget_ms = 0"), "budget_ms is 0: expected"),
        (GOOD.replace("decoder_mpx_s", "decoder"), "decoder"),
        (GOOD.replace("compute_shaders = true", "compute_shaders = 1"), "compute_shaders is 1: expected true or false"),
        (GOOD.replace("scene =", "#"), "scene is missing"),
        ("summary = ", "this is no TOML"),
    ],
)
def test_a_bad_file_gets_one_line_that_names_file_and_key(tmp_path, text, told):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_client(str(path))
    assert str(path) in str(caught.value) and told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_names_and_files():
    with pytest.raises(UnknownNameError, match=r"unknown client 'clas-2'.*class-2"):
        load_client("clas-2")
    with pytest.raises(InputError, match=r"no\.toml: no such file"):
        load_client("no.toml")
