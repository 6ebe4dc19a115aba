"""Style of the control panel: one font, few colours, sizes in pixels at a content scale of 1."""

from __future__ import annotations

from pathlib import Path

import imgui_bundle
from imgui_bundle import imgui, implot

WIDTH = 330  # of the panel
FONT_SIZE = 15.0

Rgba = tuple[float, float, float, float]
# Dark enough to read on over a white wall, light enough to see movement through.
BACKGROUND: Rgba = (0.055, 0.065, 0.080, 0.86)
TEXT: Rgba = (0.90, 0.92, 0.94, 1.0)
DIM: Rgba = (0.60, 0.64, 0.69, 1.0)
FAINT: Rgba = (0.60, 0.64, 0.69, 0.55)
FIELD: Rgba = (0.16, 0.19, 0.23, 0.90)
TOUCHED: Rgba = (0.22, 0.27, 0.33, 0.95)
ACCENT: Rgba = (0.30, 0.76, 0.70, 1.0)
LINE: Rgba = (1.0, 1.0, 1.0, 0.10)
BAD: Rgba = (0.98, 0.42, 0.36, 1.0)
WARN: Rgba = (0.98, 0.76, 0.30, 1.0)
LIMIT: Rgba = (0.98, 0.76, 0.30, 0.8)
CLEAR: Rgba = (0.0, 0.0, 0.0, 0.0)
# Stages, in plan order: Okabe and Ito's colours, which colour-blind people can tell apart,
# lightened for a dark background.
STAGES: tuple[Rgba, ...] = (
    (0.34, 0.71, 0.91, 1.0),
    (0.90, 0.62, 0.00, 1.0),
    (0.00, 0.72, 0.55, 1.0),
    (0.92, 0.58, 0.76, 1.0),
    (0.94, 0.89, 0.26, 1.0),
    (0.84, 0.42, 0.10, 1.0),
    (0.25, 0.52, 0.80, 1.0),
    (0.72, 0.74, 0.78, 1.0),
)


def u32(colour: Rgba) -> int:
    """Return the colour as draw lists expect it."""
    return imgui.color_convert_float4_to_u32(colour)


def add_font() -> None:
    """Add Roboto, which the package includes; its digits all have one width.

    Dear ImGui's own font where a repackager left it out.
    """
    path = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto" / "Roboto-Regular.ttf"
    fonts = imgui.get_io().fonts
    if path.is_file():
        fonts.add_font_from_file_ttf(str(path), FONT_SIZE)
    else:
        fonts.add_font_default()


def apply(scale: float) -> None:
    """Set sizes for a content scale, and the colours. May be called again for another scale."""
    style = imgui.get_style()
    style.font_size_base = FONT_SIZE
    style.font_scale_dpi = scale
    for name, value in _SIZES.items():
        setattr(style, name, value * scale)
    for name, (x, y) in _PAIRS.items():
        setattr(style, name, imgui.ImVec2(x * scale, y * scale))
    for colour, rgba in _COLOURS.items():
        style.set_color_(colour, imgui.ImVec4(*rgba))
    _apply_to_plots(scale)


def _apply_to_plots(scale: float) -> None:
    style = implot.get_style()
    style.plot_padding = imgui.ImVec2(0, 0)
    style.plot_border_size = 0.0
    style.plot_min_size = imgui.ImVec2(10 * scale, 10 * scale)
    for colour, value in ((implot.Col_.frame_bg, CLEAR), (implot.Col_.plot_bg, (1.0, 1.0, 1.0, 0.045))):
        style.set_color_(colour, imgui.ImVec4(*value))


_SIZES = {
    "window_rounding": 0.0,
    "window_border_size": 0.0,
    "frame_rounding": 4.0,
    "grab_rounding": 3.0,
    "grab_min_size": 10.0,
    "popup_rounding": 4.0,
    "scrollbar_size": 9.0,
    "scrollbar_rounding": 4.0,
    "popup_border_size": 1.0,
}
_PAIRS = {
    "window_padding": (12.0, 10.0),
    "frame_padding": (7.0, 2.5),
    "item_spacing": (7.0, 4.0),
    "item_inner_spacing": (5.0, 4.0),
    "cell_padding": (4.0, 1.5),
}
_COLOURS: dict[int, Rgba] = {
    imgui.Col_.window_bg: BACKGROUND,
    imgui.Col_.popup_bg: (0.09, 0.10, 0.125, 0.97),
    imgui.Col_.border: LINE,
    imgui.Col_.text: TEXT,
    imgui.Col_.text_disabled: DIM,
    imgui.Col_.frame_bg: FIELD,
    imgui.Col_.frame_bg_hovered: TOUCHED,
    imgui.Col_.frame_bg_active: TOUCHED,
    imgui.Col_.slider_grab: ACCENT,
    imgui.Col_.slider_grab_active: ACCENT,
    imgui.Col_.check_mark: ACCENT,
    imgui.Col_.button: FIELD,
    imgui.Col_.button_hovered: TOUCHED,
    imgui.Col_.button_active: (0.20, 0.45, 0.43, 1.0),
    imgui.Col_.header: (0.20, 0.45, 0.43, 0.75),
    imgui.Col_.header_hovered: TOUCHED,
    imgui.Col_.header_active: (0.20, 0.45, 0.43, 1.0),
    imgui.Col_.separator: LINE,
    imgui.Col_.scrollbar_bg: CLEAR,
    imgui.Col_.scrollbar_grab: (1.0, 1.0, 1.0, 0.18),
    imgui.Col_.text_selected_bg: (0.20, 0.45, 0.43, 0.9),
}
