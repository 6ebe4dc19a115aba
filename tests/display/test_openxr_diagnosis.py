"""Everything that can keep a headset from showing anything has words of its own and something to do
about it.
"""

from __future__ import annotations

import platform
from pathlib import Path

from hmdwarp.display.openxr.diagnosis import LOST, STAGES, diagnose, manifest, manifest_text, missing_extensions

ACTIVE = "active is runtime.json, library librt.so"
DIFFERENT = [
    ("binding", "AttributeError"), ("runtime", "RuntimeUnavailableError"), ("instance", "RuntimeFailureError"),
    ("instance", "LimitReachedError"), ("instance", "ExtensionNotPresentError"),
    ("instance", "ApiVersionUnsupportedError"), ("headset", "FormFactorUnavailableError"),
    ("session", "GraphicsDeviceInvalidError"), ("session", "OutOfMemoryError"), ("running", "InstanceLostError"),
]  # fmt: skip


def test_every_trouble_has_words_of_its_own_and_a_remedy():
    told = [diagnose(stage, error, "why\nso", "Runtime 1", ACTIVE) for stage, error in DIFFERENT]
    assert len({words for words, _ in told}) == len(DIFFERENT)
    others = ("InstanceLostError", "SomethingNewError", "died", "OSError", "LimitReachedError")
    told += [diagnose(stage, error) for stage in STAGES for error in others]
    assert all(words and remedy and "\n" not in words for words, remedy in told)
    for error in LOST:
        words, remedy = diagnose("running", error, "", "Runtime 1")
        assert words.startswith("Runtime 1 went away") and "restart" in remedy
    words, _ = diagnose("session", "OutOfMemoryError", "no\n  memory", "Runtime 1")
    assert words == "Runtime 1 failed when a session was made: OutOfMemoryError: no memory"


def test_one_graphics_extension_is_enough_and_the_clock_is_wanted():
    clock = "XR_KHR_convert_timespec_time"
    for graphics in ("XR_KHR_opengl_enable", "XR_MNDX_egl_enable"):
        assert missing_extensions("R", [graphics, clock]) == ("", "")
    assert "XR_KHR_opengl_enable or XR_MNDX_egl_enable" in missing_extensions("R", [clock])[0]
    assert clock in missing_extensions("R", ["XR_MNDX_egl_enable"])[0]


def test_manifest_follows_the_loader(tmp_path):
    """XR_RUNTIME_JSON first, even if it is wrong.

    Then the user's folder, the one for this processor before the general one.
    """
    home = {"HOME": str(tmp_path), "XDG_CONFIG_DIRS": str(tmp_path / "none")}
    folder = tmp_path / ".config" / "openxr" / "1"
    folder.mkdir(parents=True)
    general = folder / "active_runtime.json"
    general.write_text('{"runtime": {"library_path": "librt.so"}}', encoding="utf-8")
    assert manifest(home) == general
    assert "librt.so" in manifest_text(home)
    own = folder / f"active_runtime.{platform.machine()}.json"
    own.write_text("{", encoding="utf-8")
    assert manifest(home) == own
    assert "no runtime manifest" in manifest_text(home)
    named = {**home, "XR_RUNTIME_JSON": str(tmp_path / "absent.json")}
    assert manifest_text(named).endswith("absent.json: no such file: expected a JSON file")
    nobodys = manifest({**home, "XDG_CONFIG_HOME": str(tmp_path / "empty")})
    assert nobodys in (None, Path("/etc/openxr/1/active_runtime.json"))
