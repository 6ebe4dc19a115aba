"""Questions to drivers and runtimes that may crash or hang.

'hmdwarp doctor' asks each one in a process of its own.

    python -m hmdwarp.cli._probes gl|devices|openxr|window

Prints one JSON object per line as knowledge grows; the last whole line counts, so a crash still
leaves what came before it.
"""

from __future__ import annotations

import json
import sys

GL_LIMITS = {
    "max_texture_size": "GL_MAX_TEXTURE_SIZE",
    "max_work_group_invocations": "GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS",
    "max_work_group_size": "GL_MAX_COMPUTE_WORK_GROUP_SIZE",
    "max_work_groups": "GL_MAX_COMPUTE_WORK_GROUP_COUNT",
    "max_storage_block_bytes": "GL_MAX_SHADER_STORAGE_BLOCK_SIZE",
    "max_storage_blocks": "GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS",
}
# Both are needed for a 64-bit depth test in one pass; there is a 32-bit path for everything.
INT64_EXTENSIONS = {"GL_ARB_gpu_shader_int64", "GL_NV_shader_atomic_int64"}


def report(known: dict[str, object]) -> None:
    print(json.dumps(known), flush=True)


def gl() -> None:
    """Report the OpenGL context that replay would use: renderer, limits, timers that measure."""
    from ..errors import HmdwarpError
    from ..gpu.context import Gpu

    try:
        with Gpu() as gpu:
            about = {"renderer": gpu.renderer, "version": gpu.version, "software": gpu.is_software}
            about |= {"clock": gpu.timer.clock, "atomic_int64": gpu.gl.extensions >= INT64_EXTENSIONS}
            report({"stage": "done", **about, **{name: gpu.gl.info[key] for name, key in GL_LIMITS.items()}})
    except HmdwarpError as error:
        report({"stage": "context", "error": str(error)})


def devices() -> None:
    """Report the devices that EGL knows, one after the other, with what draws on each."""
    from ..gpu import WANTED, egl

    known: list[dict[str, object]] = []
    try:
        found = egl.devices()
    except OSError as error:
        report({"stage": "list", "error": str(error)})
        return
    for device in found:
        report({"stage": f"device {device.index}", "devices": known})
        known.append({"index": device.index, "file": device.file, "renderer": egl.renderer_of(device, WANTED)})
    report({"stage": "done", "devices": known})


def openxr() -> None:
    """Report each step on the way to a headset: binding, runtime, service, headset."""
    known: dict[str, object] = {"stage": "binding"}
    report(known)
    try:
        # Without libGL this is an AttributeError, with a foreign loader an OSError.
        import xr
    except Exception as error:
        report({**known, "error": f"{type(error).__name__}: {error}"})
        return
    known |= {"binding": str(xr.PYOPENXR_VERSION), "loader": str(xr.version.XR_CURRENT_API_VERSION)}

    def advance(stage: str) -> None:
        known["stage"] = stage
        report(known)

    try:
        advance("runtime")
        names = [_text(entry.extension_name) for entry in xr.enumerate_instance_extension_properties()]
        known["extensions"] = sorted(names)
        advance("instance")
        application = xr.ApplicationInfo(application_name="hmdwarp doctor", api_version=xr.Version(1, 0, 0))
        instance = xr.create_instance(xr.InstanceCreateInfo(application_info=application, enabled_extension_names=[]))
        try:
            properties = xr.get_instance_properties(instance)
            known["runtime"] = _text(properties.runtime_name)
            known["runtime_version"] = str(xr.Version(properties.runtime_version))
            advance("headset")
            system = xr.get_system(instance, xr.SystemGetInfo(xr.FormFactor.HEAD_MOUNTED_DISPLAY))
            known["headset"] = _text(xr.get_system_properties(instance, system).system_name)
            advance("done")
        finally:
            xr.destroy_instance(instance)
    except Exception as error:
        report({**known, "error": type(error).__name__, "message": str(error)})


def window() -> None:
    """Report whether a desktop window with OpenGL 4.3 opens; it stays hidden."""
    import warnings

    from ..display.desktop import choose_library

    choose_library()
    import glfw

    warnings.simplefilter("ignore", glfw.GLFWError)
    if not glfw.init():
        report({"stage": "display", "error": _text(glfw.get_error()[1] or "no display")})
        return
    try:
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, 4)
        glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, 3)
        glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
        if not glfw.create_window(64, 64, "hmdwarp doctor", None, None):
            report({"stage": "window", "error": _text(glfw.get_error()[1] or "no window")})
            return
        monitor = glfw.get_primary_monitor()
        mode = glfw.get_video_mode(monitor) if monitor else None
        size, refresh_hz = (list(mode.size), mode.refresh_rate) if mode else (None, None)
        report({"stage": "done", "size": size, "refresh_hz": refresh_hz})
    finally:
        glfw.terminate()


def _text(value: bytes | str) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


if __name__ == "__main__":
    {"gl": gl, "devices": devices, "openxr": openxr, "window": window}[sys.argv[1]]()
