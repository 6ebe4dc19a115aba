"""The panel without a window.

Its drawing against NumPy, what it leaves behind, its numbers, its widgets led by events of their
own.
"""

from __future__ import annotations

import math
import os
import sys
from itertools import count

import numpy as np
import pytest

from hmdwarp.display import CONTROLS, Command, Status, control
from hmdwarp.display.controls import KEPT
from hmdwarp.display.desktop.control_panel import PANEL_REMEDY, installed, make_control_panel

if not installed():
    pytest.skip(f"the panel's package is not installed: {PANEL_REMEDY}", allow_module_level=True)

from imgui_bundle import imgui  # noqa: E402

from hmdwarp.display.desktop.control_panel import widgets  # noqa: E402
from hmdwarp.display.desktop.control_panel.imgui_input import NoInput  # noqa: E402
from hmdwarp.display.desktop.control_panel.panel import CALM_HZ, ControlPanel  # noqa: E402
from hmdwarp.display.desktop.control_panel.renderer import CORNER, Batch, PanelRenderer  # noqa: E402

SIZE = (400, 780)


def status(**changes) -> Status:
    """A run in full swing."""
    values = {
        "latency": 200.0,
        "warp": "forward",
        "fill": "none",
        "guard": 1.0,
        "scene": "room",
        "effects": "auto",
        "lens": "auto",
    }
    values |= {"view": "both", "vsync": True, "help": False, "full_screen": False, "panel": True}
    choices = {
        "warp": ("forward", "mesh"),
        "fill": ("none", "stretch"),
        "scene": ("planes", "room"),
        "effects": ("auto", "none"),
    }
    made = Status(values=values, choices=choices, budget_ms=1e3 / 60, stage_ms={"warp": 4.0, "lens": 2.0})
    for k in range(KEPT):
        made.total_ms.append(6 + math.sin(k))
        made.age_ms.append(200 + k % 7)
        made.pose_age_ms.append(1.0)
        made.holes.append(0.03 if k % 2 else math.nan)
        made.period_ms.append(16.7)
    for name, value in changes.items():
        setattr(made, name, value)
    return made


@pytest.fixture
def screen(gpu):
    """A framebuffer in place of a window's."""
    with gpu.current():
        texture = gpu.gl.texture(SIZE, 4)
        framebuffer = gpu.gl.framebuffer([texture])
        framebuffer.clear(0.2, 0.4, 0.6, 1.0)
        yield framebuffer
        framebuffer.release()
        texture.release()


class Hand(NoInput):
    """A mouse led by the test, in pixels of the panel, with the events that a window would have
    sent.
    """

    def __init__(self) -> None:
        super().__init__()
        self.place, self.events = None, []

    @property
    def cursor(self):
        return None if self.place is None else (self.place[0] + self.left, self.place[1])

    def take(self):
        events, self.events = self.events, []
        return events

    def move(self, x: float, y: float) -> None:
        self.place = (x, y)
        self.events.append(lambda io: io.add_mouse_pos_event(x, y))

    def press(self, down: bool) -> None:
        self.events.append(lambda io: io.add_mouse_button_event(0, down))


@pytest.fixture
def hand():
    return Hand()


@pytest.fixture
def panel(gpu, screen, hand):
    made = ControlPanel(gpu.gl, hand, screen, count(1, 1 / 60).__next__)
    yield made
    made.close()


def pixels(framebuffer) -> np.ndarray:
    """(h, w, 4) floats in 0..1, row 0 at the bottom."""
    w, h = framebuffer.size
    return np.frombuffer(framebuffer.read(components=4), np.uint8).reshape(h, w, 4) / 255.0


def settle(panel: ControlPanel, told: Status, refreshes: int = 4) -> list[Command]:
    """Draw until widgets have sizes; everything asked for meanwhile."""
    commands = []
    for _ in range(refreshes):
        panel._painted_s = -1.0  # or it would lay the last picture over again
        commands += panel.draw(told, SIZE)
    return commands


def place_of(panel: ControlPanel, told: Status, name: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """Corners of the widget of a control, as Dear ImGui has it.

    Seen by asking after each one is drawn.
    """
    found = {}
    drawn = dict(panel._widgets._by_kind)

    def looking(kind):
        def draw(one, value, status):
            wanted = drawn[kind](one, value, status)
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            found[one.name] = (low.x, low.y), (high.x, high.y)
            return wanted

        return draw

    with pytest.MonkeyPatch.context() as patch:
        for kind in drawn:
            patch.setitem(panel._widgets._by_kind, kind, looking(kind))
        settle(panel, told, 1)
    return found[name]


# --- the drawing --------------------------------------------------------------------------------


def inside(points: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (n, 3) of points in a triangle, by areas; NaN outside."""
    a, b, c = triangle

    def area(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (r[..., 0] - p[..., 0]) * (q[..., 1] - p[..., 1])

    shares = np.stack([area(b, c, points), area(c, a, points), area(a, b, points)], axis=-1) / area(a, b, c)
    return np.where((shares >= 0).all(axis=-1, keepdims=True), shares, np.nan)


def blended(size, corners, indices, batches, atlas) -> np.ndarray:
    """(h, w, 4), row 0 at the top: every triangle over what is there, pixel by pixel in float64.

    Source: Porter and Duff 1984, over.
    """
    w, h = size
    out = np.zeros((h, w, 4))
    xs, ys = np.meshgrid(np.arange(w) + 0.5, np.arange(h) + 0.5)
    centres = np.stack([xs, ys], axis=-1).reshape(-1, 2)
    for batch in batches:
        left, top, right, bottom = batch.clip
        clipped = (centres[:, 0] > left) & (centres[:, 0] < right) & (centres[:, 1] > top) & (centres[:, 1] < bottom)
        for triple in indices[batch.first : batch.first + batch.count].reshape(-1, 3):
            three = corners[triple]
            shares = inside(centres, three["position_px"].astype(float))
            hit = clipped & ~np.isnan(shares[:, 0])
            colour = shares[hit] @ (three["tint"] / 255.0) * texel(atlas, shares[hit] @ three["ink_uv"].astype(float))
            beneath = out.reshape(-1, 4)[hit]
            alpha = colour[:, 3:]
            out.reshape(-1, 4)[hit] = np.concatenate([colour[:, :3] * alpha, alpha], axis=1) + (1 - alpha) * beneath
    return out


def texel(atlas: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Bilinear, edges held; atlas (h, w, 4), row 0 at v = 0."""
    h, w = atlas.shape[:2]
    at = uv * (w, h) - 0.5
    low = np.floor(at).astype(int)
    (fx, fy), out = (at - low).T[..., None], 0
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        weight = (fx if dx else 1 - fx) * (fy if dy else 1 - fy)
        out = out + weight * atlas[np.clip(low[:, 1] + dy, 0, h - 1), np.clip(low[:, 0] + dx, 0, w - 1)]
    return out


def test_triangles_lie_where_numpy_has_them(gpu):
    """Random tints, textures and overlaps, clipped, over an odd size."""
    rng = np.random.default_rng(7)
    size, corners = (37, 29), np.zeros(12, CORNER)
    # Thirds of a pixel off the grid: no pixel's centre lies on an edge, where either triangle may
    # have it.
    corners["position_px"] = rng.integers(-4, 40, (12, 2)) + 1 / 3
    corners["ink_uv"] = rng.random((12, 2))
    corners["tint"] = rng.integers(0, 256, (12, 4))
    atlas = rng.integers(0, 256, (8, 8, 4), np.uint8)
    with gpu.current():
        texture = gpu.gl.texture((8, 8), 4, atlas.tobytes())
        renderer = PanelRenderer(gpu.gl)
        indices = np.arange(12, dtype=np.uint32)
        batches = [Batch(texture, 0, 6, (3, 2, 30, 25)), Batch(texture, 6, 6, (-5, -5, 99, 99))]
        renderer.draw(corners, indices, batches, size)
        found = np.frombuffer(renderer.picture.read(), np.uint8).reshape(size[1], size[0], 4)[::-1] / 255.0
        renderer.picture.release()
        texture.release()
    wanted = blended(size, corners, indices, batches, atlas / 255.0)
    # Four layers are each rounded to 1/255, and rgba8 texels come 1.5/255 off on llvmpipe: 4 * 2.5
    # steps. The edges themselves are snapped to 1/256 of a pixel, which a centre at 1/3 and more
    # from the grid lines of integer corners may still meet.
    off = np.abs(found - wanted).max(axis=2) * 255
    assert (off > 10).mean() < 0.005
    assert (wanted[..., 3] > 0).mean() > 0.3


def test_it_lies_over_the_picture_as_its_alpha_says(gpu, screen, panel):
    """What is put down is colour times alpha already; beside and below it nothing changes."""
    settle(panel, status())
    before = np.broadcast_to(np.round(np.array([0.2, 0.4, 0.6, 1.0]) * 255) / 255, (SIZE[1], SIZE[0], 4))
    screen.clear(0.2, 0.4, 0.6, 1.0)
    panel._painted_s = 1e9
    panel.draw(status(), SIZE)
    found = pixels(screen)
    over = np.zeros((SIZE[1], SIZE[0], 4))
    w, h = panel._renderer.picture.size
    over[:, SIZE[0] - w :] = np.frombuffer(panel._renderer.picture.read(), np.uint8).reshape(h, w, 4) / 255.0
    wanted = over + (1 - over[..., 3:]) * before
    assert np.abs(found - wanted).max() <= 1.01 / 255  # one rounding
    assert np.array_equal(found[: SIZE[1] - panel._layout.height], before[: SIZE[1] - panel._layout.height])
    assert np.array_equal(found[:, : SIZE[0] - w], before[:, : SIZE[0] - w])
    assert w == 330 and 400 < panel._layout.height < SIZE[1]


def test_the_next_pass_does_not_notice_it(gpu, panel):
    """Pictures of a scene with blending, culling and depth are the same bits with a panel drawn
    between any two refreshes.
    """
    from hmdwarp.client import needs_of
    from hmdwarp.geometry import Fov, Pose, View
    from hmdwarp.gpu import download
    from hmdwarp.pipeline import PipelineOptions, PoseRequest, Source, Target, build_pipeline, plans_for
    from hmdwarp.poses import Origin, PoseSample
    from hmdwarp.scenes import load_scene

    class OneEye:
        def views(self, world_from_head):
            return (View(world_from_head, Fov.symmetric(1.4, 1.2)),)

    class Turning:
        def head_at(self, time_ns):
            share = time_ns * 1e-9
            return PoseSample(
                time_ns, Pose((0.3 * share, 1.6, 1.0), (0, np.sin(share), 0, np.cos(share))), Origin.MEASURED
            )

    options = PipelineOptions(
        scene="greenhouse", latency_ms=20, warp="mesh", fill="stretch", lens="none", size=(96, 120)
    )
    scene = load_scene(options.scene)
    plans = plans_for(options, None, scene)
    requested = PoseRequest(Turning(), None, options.size, 1.0, needs_of(plans))

    def shown(between) -> list[np.ndarray]:
        out, target = [], Target(gpu, OneEye(), 100.0, 20_000_000)
        with build_pipeline(options, Source(options, scene), target, plans, requested) as made:
            for k in range(4):
                made.loop.draw(k * 10_000_000)
                between()
                refresh = made.loop.show(k * 10_000_000)
                between()
                if refresh is not None:
                    out.append(download(refresh.eyes[0].shown.texture))
        return out

    alone, beside = shown(lambda: None), shown(lambda: settle(panel, status(), 1))
    assert len(alone) == len(beside) >= 2
    for one, other in zip(alone, beside, strict=True):
        assert np.array_equal(one, other)
    assert alone[0][..., 3].mean() > 0.7


def test_objects_are_made_in_the_first_refreshes_only(gpu, panel):
    settle(panel, status(), 6)
    renderer = panel._renderer
    things = (
        renderer.picture.glo,
        renderer._array.glo,
        renderer._corners.buffer.glo,
        renderer._indices.buffer.glo,
        *renderer._atlases,
    )
    settle(panel, status(missed=1234567890, notice="0123456789"), 40)
    assert things == (
        renderer.picture.glo, renderer._array.glo, renderer._corners.buffer.glo, renderer._indices.buffer.glo,
        *renderer._atlases,
    )  # fmt: skip


def test_buffers_grow_with_what_is_drawn(gpu):
    with gpu.current():
        renderer = PanelRenderer(gpu.gl)
        white = gpu.gl.texture((1, 1), 4, b"\xff" * 4)
        for times in (1, 30_000, 2):
            corners = np.zeros(3 * times, CORNER)
            corners["position_px"] = np.tile([(-9, -9), (40, -9), (-9, 40)], (times, 1))
            corners["tint"] = 255
            indices = np.arange(3 * times, dtype=np.uint32)
            renderer.draw(corners, indices, [Batch(white, 3 * times - 3, 3, (0, 0, 8, 8))], (8, 8))
            assert set(renderer.picture.read()) == {255}
        white.release()
        renderer.picture.release()


# --- when it is drawn ---------------------------------------------------------------------------


def test_untouched_it_is_drawn_fifteen_times_a_second_and_seen_at_every_refresh(gpu, screen, hand):
    panel = ControlPanel(gpu.gl, hand, screen, count(10, 1 / 90).__next__)
    painted = []
    paint = panel._renderer.paint
    panel._renderer.paint = lambda *a: (painted.append(1), paint(*a))[1]
    while panel._clock() < 10.6:  # at first it is drawn at every refresh
        panel.draw(status(), SIZE)
    painted.clear()
    for _ in range(90):
        screen.clear(1, 1, 1, 1)
        panel.draw(status(), SIZE)
        assert pixels(screen)[-20, -20, 0] < 0.5  # its background over white
    assert len(painted) == pytest.approx(CALM_HZ, abs=2)
    painted.clear()
    for k in range(20):
        hand.move(100 + k, 100)
        panel.draw(status(), SIZE)
    assert len(painted) == 20
    panel.close()
    panel.close()  # twice does no harm


def test_turned_off_it_draws_and_hears_nothing(panel, screen, hand):
    settle(panel, status())
    panel.on = False
    hand.move(100, 100)
    screen.clear(1, 1, 1, 1)
    assert panel.draw(status(), SIZE) == []
    assert pixels(screen).min() == 1.0
    assert not panel.wants_mouse and not panel.wants_keys
    assert panel.column == 0
    panel.on = True
    assert panel.column == 330
    panel.draw(status(), SIZE)
    assert pixels(screen).min() < 0.5
    assert panel.wants_mouse


@pytest.mark.parametrize("size", [(1, 1), (200, 90), (0, 300), (2000, 40), (500, 900)])
@pytest.mark.parametrize("scale", [1.0, 2.5])
def test_any_window_will_do(gpu, screen, size, scale):
    panel = make_control_panel(None, gpu.gl, into=screen, scale=scale)
    for _ in range(3):
        assert panel.draw(status(), size) == []
    if min(size):
        assert panel._renderer.picture.size == (min(round(330 * scale), size[0]), size[1])
    panel.close()


def test_a_run_that_has_not_begun_has_a_panel_too(panel):
    settle(panel, Status())
    few = Status(budget_ms=10.0)
    few.holes.append(math.nan)
    few.total_ms.append(3.0)
    settle(panel, few)
    infinite = status()
    infinite.period_ms.append(math.inf)
    settle(panel, infinite)


# --- what is asked for by it --------------------------------------------------------------------


def test_every_control_is_there_with_its_key(panel):
    """Those of the run as rows, the display's own as buttons; moving is the window's."""
    for listed in CONTROLS:
        assert listed.of_display == (listed.name in widgets.ACTIONS)
        if not listed.of_display:
            place_of(panel, status(), listed.name)
            assert listed.kind in widgets.Widgets(str)._by_kind
        assert widgets.keys_of(listed, str)
    assert widgets.keys_of(control("latency"), str) == "[ ]"
    assert widgets.keys_of(control("quit"), str) == "Esc"


def test_a_slider_of_latency_follows_the_hand(panel, hand):
    told = status()
    settle(panel, told)
    (left, top), (right, bottom) = place_of(panel, told, "latency")
    hand.move(left + 3, (top + bottom) / 2)
    settle(panel, told, 2)
    hand.press(True)
    asked = settle(panel, told, 2)
    for share in (0.25, 0.5, 0.75):
        hand.move(left + share * (right - left), (top + bottom) / 2 + 60)  # the hand may slip off the row
        assert panel.wants_mouse
        asked += settle(panel, told, 2)
    hand.press(False)
    asked += settle(panel, told, 2)
    values = [command.value for command in asked]
    assert {command.control for command in asked} == {"latency"}
    assert values == sorted(set(values)) and values[0] == 0.0
    assert values[-1] == pytest.approx(0.75 * 2500, abs=60)  # the grab's width is left out at both ends
    assert all(value % 10 == 0 for value in values)


def test_a_slider_of_the_guard_waits_for_the_hand_to_let_go(panel, hand):
    """It builds the whole pipeline anew: once, not at every pixel."""
    told = status()
    settle(panel, told)
    (left, top), (right, bottom) = place_of(panel, told, "guard")
    middle = (top + bottom) / 2
    hand.move(left + 5, middle)
    settle(panel, told, 2)
    hand.press(True)
    asked = settle(panel, told, 2)
    for share in (0.2, 0.4, 0.5):
        hand.move(left + share * (right - left), middle)
        asked += settle(panel, told, 2)
    assert asked == []
    hand.press(False)
    (command,) = settle(panel, told, 3)
    assert command.control == "guard"
    assert command.value == pytest.approx(2.0, abs=0.1)
    assert command.value == pytest.approx(round(command.value / 0.05) * 0.05)


def test_a_number_can_be_typed(panel, hand):
    """Ctrl and click: any number, to the digit; then Enter.

    Meanwhile the window's keys are silent.
    """
    told = status()
    settle(panel, told)
    (left, top), (right, bottom) = place_of(panel, told, "latency")
    hand.move((left + right) / 2, (top + bottom) / 2)
    settle(panel, told, 2)
    hand.events.append(lambda io: io.add_key_event(imgui.Key.mod_ctrl, True))
    hand.press(True)
    settle(panel, told, 1)
    hand.press(False)
    hand.events.append(lambda io: io.add_key_event(imgui.Key.mod_ctrl, False))
    settle(panel, told, 3)
    assert panel.wants_keys
    for letter in "1234":
        hand.events.append(lambda io, letter=letter: io.add_input_character(ord(letter)))
    hand.events.append(lambda io: io.add_key_event(imgui.Key.enter, True))
    hand.events.append(lambda io: io.add_key_event(imgui.Key.enter, False))
    asked = settle(panel, told, 8)
    assert asked[-1] == Command("latency", 1234.0)
    assert not panel.wants_keys


def click(panel: ControlPanel, hand: Hand, told: Status, x: float, y: float) -> list[Command]:
    hand.move(x, y)
    asked = settle(panel, told, 2)
    hand.press(True)
    asked += settle(panel, told, 2)
    hand.press(False)
    return asked + settle(panel, told, 3)


def middle(box) -> tuple[float, float]:
    (left, top), (right, bottom) = box
    return (left + right) / 2, (top + bottom) / 2


def test_a_choice_is_chosen_from_its_list(panel, hand):
    told = status()
    settle(panel, told)
    box = place_of(panel, told, "warp")
    x, y = middle(box)
    assert click(panel, hand, told, x, y) == []
    height = box[1][1] - box[0][1]
    asked = click(panel, hand, told, x, y + 2.4 * height)  # the second of two
    assert asked == [Command("warp", "mesh")]
    assert settle(panel, told, 4) == []  # asked for once


def test_switches_say_what_they_switch_to(panel, hand):
    told = status()
    settle(panel, told)
    (left, top), (_, bottom) = place_of(panel, told, "effects")
    row = bottom - top + 3.0  # the lens is the row below, its box at the left
    assert click(panel, hand, told, left + 8, (top + bottom) / 2 + row) == [Command("lens", "none")]
    x, y = middle(place_of(panel, told, "view"))  # the last of its two buttons
    assert click(panel, hand, told, x, y) == [Command("view", "flat")]
    told.values["view"] = "flat"
    assert click(panel, hand, told, x, y) == []


def test_a_refused_value_is_shown_as_it_is_again(panel, hand):
    """A request is shown at once, and for half a second only if the run does not take it."""
    told = status()
    settle(panel, told)
    x, y = middle(place_of(panel, told, "view"))
    assert click(panel, hand, told, x, y) == [Command("view", "flat")]
    assert panel._widgets._requested["view"].value == "flat"
    settle(panel, told, 40)
    assert not panel._widgets._requested
    assert click(panel, hand, told, x, y) == [Command("view", "flat")]


def test_buttons_ask_for_what_the_display_does(panel, hand):
    told = status()
    settle(panel, told)
    asked = [
        click(panel, hand, told, x, panel._layout.height - 10 - 24 * row - 10) for row in (2, 1, 0) for x in (80, 240)
    ]
    assert asked == [[Command(name)] for name in widgets.ACTIONS]


# --- numbers ------------------------------------------------------------------------------------


@pytest.mark.parametrize("most", [1e-6, 0.07, 1.0, 1.01, 9.99, 16.7, 33.4, 99.9, 100.0, 101.0, 2512.0])
def test_an_axis_ends_at_a_round_number_a_little_above(most):
    assert most * (1 - 1e-6) <= widgets.ceiling(most) <= 1.5 * most + 1e-9


@pytest.mark.parametrize("most", [0.0, -1.0, math.nan, math.inf])
def test_an_axis_has_an_end(most):
    assert widgets.ceiling(most) == 1.0


def test_numbers_are_read_as_they_are_meant():
    named = {plot.name: plot for plot in widgets.plots_of(status())}
    passes, holes = named["all passes"], named["holes before the fill"]
    assert widgets.number_text(4.26, passes) == "4.3 of 16.7 ms"
    assert widgets.number_text(123.4, holes) == "123 %"
    assert widgets.number_text(None, holes) == "-"
    assert widgets.calm(holes.values) == pytest.approx(3.0)  # those that were counted alone, as percent
    assert widgets.calm([]) is None
    assert widgets.calm([math.nan]) is None


def test_stages_keep_their_colours_when_others_come_and_go():
    stages = widgets.Stages()
    stages._take({"warp": 4.0, "lens": 2.0})
    lens = stages._colour("lens")
    stages._take({"warp": 4.0, "fill": 1.0, "lens": 2.0})
    assert stages._colour("lens") == lens != stages._colour("fill")
    stages._take({"warp": 4.0})
    assert stages._shown() == ["warp"]


# --- without the package ------------------------------------------------------------------------


def test_without_the_package_there_is_no_panel(gpu, screen, monkeypatch):
    monkeypatch.setitem(sys.modules, "imgui_bundle", None)
    assert make_control_panel(None, gpu.gl, into=screen) is None


def test_the_package_leaves_glfw_alone(gpu, screen, monkeypatch):
    """It would have every program started from here take its own library of that name."""
    monkeypatch.delenv("PYGLFW_LIBRARY", raising=False)
    panel = make_control_panel(None, gpu.gl, into=screen)
    assert "PYGLFW_LIBRARY" not in os.environ
    panel.close()


def test_the_doctor_tells_of_it(monkeypatch):
    import importlib.metadata

    from hmdwarp.cli import _checks as doctor

    (check,) = (check for check in doctor.CHECKS if check.name == "extra panel")
    monkeypatch.setattr(doctor, "CHECKS", [check])
    monkeypatch.setattr(doctor, "run_probe", lambda question: {})

    def found():
        (finding,) = doctor.examine()
        return finding

    assert found().state == doctor.OK and "imgui-bundle" in found().detail

    def absent(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", absent)
    assert found().state == doctor.OPTIONAL and found().remedy == PANEL_REMEDY
