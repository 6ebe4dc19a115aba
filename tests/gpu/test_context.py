"""Several contexts in one thread.

Each is current while it is used, and the one before it again afterwards.
"""

from __future__ import annotations

import subprocess
import sys

import moderngl
import numpy as np
import pytest

from hmdwarp.errors import MachineError
from hmdwarp.gpu import SCALAR, Canvas, Gpu, allocate, context, download, upload


def works(gpu: Gpu) -> bool:
    """Whether what is written through this context comes back."""
    texture, image = allocate(gpu.gl, (3, 2), SCALAR), np.arange(6, dtype=np.float32).reshape(2, 3)
    upload(texture, image)
    same = np.array_equal(download(texture), image)
    texture.release()
    return same


def test_a_second_context_hands_back_to_the_first(gpu):
    with Gpu() as second:
        assert works(second)
        with gpu.current():
            assert works(gpu)
        assert works(second)
    assert works(gpu)


def test_pictures_of_two_contexts_do_not_mix(gpu):
    mine = Canvas(gpu.gl, (4, 4))
    upload(mine.texture, np.full((4, 4, 4), 0.5))
    with Gpu() as second:
        theirs = Canvas(second.gl, (4, 4))
        upload(theirs.texture, np.full((4, 4, 4), 0.25))
        with gpu.current():
            assert (download(mine.texture) == 0.5).all()
        assert (download(theirs.texture) == 0.25).all()
    assert (download(mine.texture) == 0.5).all()
    mine.release()


def test_contexts_close_in_any_order(gpu):
    second, third = Gpu(), Gpu()
    second.close()
    assert works(third)
    third.close()
    assert works(gpu)
    second.close()
    third.close()
    assert works(gpu), "closing again is nothing"


def test_current_gives_back_after_an_error(gpu):
    with Gpu() as second:
        with pytest.raises(RuntimeError, match="inside"), gpu.current():
            raise RuntimeError("inside")
        assert works(second)
    assert works(gpu)


def test_step_aside_leaves_the_one_before_current(gpu):
    second = Gpu()
    second.step_aside()
    assert works(gpu)
    with second.current():
        assert works(second)
    assert works(gpu)
    second.close()
    assert works(gpu)


def test_a_closed_one_is_current_nowhere():
    """In a process of its own.

    A context that EGL destroyed while it was current keeps every window's (GLX) out of the thread.
    """
    code = (
        "import ctypes; from hmdwarp.gpu.context import Gpu; egl = ctypes.CDLL('libEGL.so.1'); now = "
        "egl.eglGetCurrentContext;"
        "now.restype = ctypes.c_void_p; gpu = Gpu(); assert now(), 'not by EGL'; gpu.close(); assert not now(), "
        "'still current'"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=120)
    if "not by EGL" in done.stderr or "libEGL" in done.stderr:
        pytest.skip("contexts here are not made by EGL")
    assert done.returncode == 0, done.stderr


def test_what_a_gpu_says_of_itself(gpu):
    assert gpu.gl.version_code >= context.WANTED
    assert gpu.renderer == gpu.gl.info["GL_RENDERER"]
    assert gpu.max_texture_size >= 16384 // 2, "OpenGL 4.3 promises 16384, software renderers may have less"
    assert gpu.is_software == (
        "llvmpipe" in gpu.renderer.lower()
        or "swiftshader" in gpu.renderer.lower()
        or "softpipe" in gpu.renderer.lower()
    )


@pytest.mark.parametrize("display", ["", ":99"])
def test_a_machine_without_opengl_is_told_what_to_install(monkeypatch, display):
    def refuse(**settings):
        raise Exception(f"no {'egl' if 'context' in settings else 'window'} today")  # moderngl raises bare Exception

    monkeypatch.setattr(moderngl, "create_context", refuse)
    monkeypatch.setenv("DISPLAY", display)
    with pytest.raises(
        MachineError, match=r"no OpenGL 4\.3 here \(egl: device 0: no egl today.*libegl1.*hmdwarp doctor"
    ) as caught:
        context.create_context()
    assert ("window system: no window today" in str(caught.value)) == bool(display)
    assert "\n" not in str(caught.value)
