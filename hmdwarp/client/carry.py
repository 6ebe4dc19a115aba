"""Carry other rendered pictures along with the colour, by running the same warp on them.

So any warp carries anything: the inverse depth that fills read, the reflectivity of each surface. A
shown pixel gets it from the same rendered pixels as its colour, with the same coverage.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs
import moderngl

from ..frames import EyeImage, Needs
from ..geometry import view_map
from ..gpu.context import Gpu
from ..gpu.textures import COLOUR, Canvas, allocate
from .inputs import PassInputs, as_image
from .warps import Warp

PictureOf = Callable[[EyeImage], moderngl.Texture]


class Carry:
    """Runs the planned warp on pictures other than the colour."""

    def __init__(self, warp: Warp) -> None:
        self._warp = warp
        # Whether the warp can carry; one that samples a cube map cannot.
        self.works = warp.carries

    def along(self, inputs: PassInputs, picture_of: PictureOf, into: Canvas) -> None:
        """Warp `picture_of` each image and surface that the warp reads into `into`.

        picture_of: returns rgba16f with coverage in alpha, of the image's size; a peeled surface
        comes as an image of its own.
        """
        self._warp.run(
            attrs.evolve(
                inputs,
                rendered=_swapped(inputs.rendered, picture_of),
                others=tuple(_swapped(o, picture_of) for o in inputs.others),
                recent=(),
            ),
            into,
        )


def _swapped(image: EyeImage, picture_of: PictureOf) -> EyeImage:
    peeled = tuple(
        attrs.evolve(surface, colour=picture_of(as_image(image, surface))) for surface in image.get("peeled", ())
    )
    return attrs.evolve(image, colour=picture_of(image)).having(peeled=peeled or None)


def images_read(needs: Needs) -> int:
    """Return the largest number of rendered images that passes with these needs read.

    Includes the newest.
    """
    return 1 + needs.others.count + needs.others.recent + int(needs.get("views", 0))


def pictures_read(needs: Needs) -> int:
    """Return how many pictures with depth a warp with these needs reads for one eye, at most."""
    # Of recent frames nothing is carried.
    return (1 + int(needs.get("peeled", 0))) * (1 + needs.others.count + int(needs.get("views", 0)))


class ShownDepth:
    """The shown picture's inverse depth: that of each rendered pixel in the shown view.

    It is carried along with the colour, so it passes through a half float: 2^-11 of the depth. At
    1000 pixels a radian that moves what is 1 m away by 0.05 pixels when the head moves 10 cm more.
    """

    def __init__(
        self, gpu: Gpu, carry: Carry, pictures: int, rendered_size: tuple[int, int], shown_size: tuple[int, int]
    ) -> None:
        self._gpu, self._carry, self._size = gpu, carry, shown_size
        self._here, self._take = (gpu.shaders.compute("fills/shown_depth.comp", PASS=k) for k in range(2))
        self._rendered = [allocate(gpu.gl, rendered_size, COLOUR) for _ in range(pictures if carry.works else 0)]
        self._carried = Canvas(gpu.gl, shown_size)

    def run(self, inputs: PassInputs, into: moderngl.Texture) -> None:
        """Write r32f: -1 where the warp left a hole, and everywhere if it cannot carry."""
        if self._carry.works:
            free = iter(self._rendered)

            def seen_from_here(image: EyeImage) -> moderngl.Texture:
                forward, here = view_map(image.view, image.size, inputs.shown, self._size), next(free)
                image.inverse_depth.bind_to_image(0, read=True, write=False)
                here.bind_to_image(1, read=False, write=True)
                named = {"rendered_inverse_depth": 0, "here": 1, "rendered_size": image.size}
                self._here.uniforms.set(**named, H=forward.H, e=forward.e)
                self._here.run(*image.size)
                self._gpu.barrier()
                return here

            self._carry.along(inputs, seen_from_here, self._carried)
        else:
            self._carried.clear()
        self._gpu.barrier()
        self._carried.texture.bind_to_image(0, read=True, write=False)
        into.bind_to_image(1, read=False, write=True)
        self._take.uniforms.set(carried=0, shown_inverse_depth=1, shown_size=self._size)
        self._take.run(*self._size)
        self._gpu.barrier()

    def close(self) -> None:
        """Free its textures."""
        for texture in self._rendered:
            texture.release()
        self._carried.release()
