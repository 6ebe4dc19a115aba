"""Several contexts in one thread. Each is current while it is used, and the one before it again
afterwards."""

from __future__ import annotations

import subprocess
import sys
from contextlib import closing

import contexts
import moderngl
import numpy as np
import pytest
from commands import hmdwarp

from hmdwarp.base import InputError, MachineError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import SCALAR, Canvas, Gpu, allocate, context, download, egl, reset_status_of, upload
from hmdwarp.gpu.context import contexts_kept
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server


@pytest.fixture(autouse=True)
def as_shipped():
    with contexts.as_shipped():
        yield


def works(gpu: Gpu) -> bool:
    """Whether what is written through this context comes back."""
    texture, image = allocate(gpu.gl, (3, 2), SCALAR), np.arange(6, dtype=np.float32).reshape(2, 3)
    upload(texture, image)
    same = np.array_equal(download(texture), image)
    texture.release()
    return same


def test_contexts_hand_back_to_the_one_before_and_their_pictures_do_not_mix(gpu):
    """Also after an error, and where one steps aside."""
    mine = Canvas(gpu.gl, (4, 4))
    upload(mine.texture, np.full((4, 4, 4), 0.5))
    with Gpu() as second:
        theirs = Canvas(second.gl, (4, 4))
        upload(theirs.texture, np.full((4, 4, 4), 0.25))
        with pytest.raises(RuntimeError, match="inside"), gpu.current():
            assert works(gpu) and (download(mine.texture) == 0.5).all()
            raise RuntimeError("inside")
        assert works(second) and (download(theirs.texture) == 0.25).all()
        second.step_aside()
        assert works(gpu)
        with second.current():
            assert works(second)
        assert works(gpu)
    assert works(gpu) and (download(mine.texture) == 0.5).all()
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


def test_a_closed_one_is_current_nowhere():
    """In a process of its own. A context that EGL destroyed while it was current keeps every
    window's (GLX) out of the thread."""
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


# --- devices -------------------------------------------------------------------------------------


def test_a_device_is_chosen_by_its_number(monkeypatch, gpu):
    for index, name in enumerate([egl.renderer_of(device, context.WANTED) for device in egl.devices()]):
        monkeypatch.setenv(egl.VARIABLE, str(index))
        with Gpu() as chosen:
            assert chosen.renderer == name and works(chosen)
    for wanted in ("99", "Voodoo 2"):
        monkeypatch.setenv(egl.VARIABLE, wanted)
        with pytest.raises(InputError, match=rf"^HMDWARP_EGL_DEVICE={wanted} names no device here, .* of 0\b"):
            Gpu()
    assert works(gpu)


# --- a context that is lost ----------------------------------------------------------------------


def lose(monkeypatch) -> None:
    """From now on the driver's own function says that it has reset the GPU. At the lowest layer,
    because nothing resets llvmpipe."""
    monkeypatch.setattr(context, "reset_status_of", lambda gl: lambda: 0x8253)


def test_a_lost_context_is_one_plain_error(gpu, monkeypatch):
    gpu.check_not_lost()
    assert reset_status_of(gpu.gl)() == 0
    lose(monkeypatch)
    with pytest.raises(MachineError, match=r"was reset, .* lost \(.*0x8253.*start again") as caught, Gpu():
        raise RuntimeError("what a driver says once its context is gone")
    assert "\n" not in str(caught.value)
    with pytest.raises(MachineError), Gpu():
        pass


COMMANDS = {
    "replay": ("replay", "look-around", "--scene", "planes", "--size", "48x40", "--seconds", "0.1", "--quiet"),
    "bench": ("bench", "look-around", "--size", "48x40", "--instants", "1", "--warp", "none", "--quiet"),
    "live": ("live", "--source", "offscreen", "--trace", "look-around", "--size", "48x40", "--pictures", "5"),
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_command_whose_context_is_lost_ends_with_3_and_leaves_nothing(monkeypatch, tmp_path, command):
    lose(monkeypatch)
    done = hmdwarp(*command, "--out", tmp_path / "out")
    assert done.returncode == 3, done.stdout + done.stderr
    assert "was reset" in done.stderr.splitlines()[-1]
    assert {path.name for path in (tmp_path / "out").glob("*")} <= {"cases"}  # a bench keeps which case failed


def test_a_context_is_used_again_with_its_programs_and_what_it_lent():
    """Textures of a scene that is drawn again are sent once, those of another one are freed."""
    room, planes, view = load_scene("room"), load_scene("planes"), View(Pose((0, 1.6, 0)), Fov.symmetric(1, 1))
    used = []
    with contexts_kept():
        for scene in (room, room, planes):
            with Gpu() as gpu, closing(Server(gpu, scene)) as server:
                picture = download(server.draw(view, (16, 12)).colour)
                used.append((gpu.gl, gpu.shaders, server.textures[0], picture))
    first, second, third = used
    assert first[:3] == second[:3] and first[:2] == third[:2] and first[2] is not third[2]
    np.testing.assert_array_equal(first[3], second[3])
    assert isinstance(first[2].mglo, moderngl.InvalidObject)
    with Gpu() as gpu:
        assert gpu.gl is not first[0] and works(gpu)
