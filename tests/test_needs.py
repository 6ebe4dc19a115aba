"""A run names what it left out, and how to get it."""

from __future__ import annotations

import needs
import pytest


def test_omitted_tests_are_reported_in_one_line():
    """Each remedy once, with all that it brings; other skips are no lack."""
    skipped = [
        ("a", "Skipped: " + needs.missing("Xvfb", needs.APT + "xvfb")),
        ("b", "Skipped: " + needs.missing("Xvfb", needs.APT + "xvfb")),
        ("b", "Skipped: " + needs.missing("Xvfb", needs.APT + "xvfb")),
        ("c", "Skipped: " + needs.missing("chromium", needs.APT + "chromium")),
        ("d", "Skipped: " + needs.missing("OpenXR runtime", "needs root,\nwhich needs a password (sudo)")),
        ("e", "Skipped: root may write anywhere"),
    ]
    assert needs.left_out(skipped) == (
        "left out: 3 for lack of Xvfb, chromium (Debian, Ubuntu: sudo apt-get install chromium xvfb); "
        "1 for lack of OpenXR runtime (needs root, which needs a password (sudo))"
    )
    assert needs.left_out(skipped[-1:]) is None


def test_every_program_has_a_package():
    assert set(needs.TOOLS["other_names"]) <= set(needs.TOOLS["packages"])
    with pytest.raises(KeyError):
        needs.programs("a program that .ci/tools.toml lacks")
