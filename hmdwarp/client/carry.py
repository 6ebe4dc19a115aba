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
from ..gpu import Gpu
from ..gpu.textures import COLOUR, Canvas, Owner, allocate, bind_images
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
        rendered, *others = (_swapped(image, picture_of) for image in (inputs.rendered, *inputs.others))
        self._warp.run(attrs.evolve(inputs, rendered=rendered, others=tuple(others), recent=()), into)


def _swapped(image: EyeImage, picture_of: PictureOf) -> EyeImage:
    surfaces = image.get("peeled", ())
    peeled = tuple(attrs.evolve(surface, colour=picture_of(as_image(image, surface))) for surface in surfaces)
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


class ShownDepth(Owner):
    """The shown picture's inverse depth: that of each rendered pixel in the shown view.

    It is carried along with the colour, so it passes through a half float: 2^-11 of the depth. At
    1000 pixels a radian that moves what is 1 m away by 0.05 pixels when the head moves 10 cm more.
    """

    def __init__(
        self, gpu: Gpu, carry: Carry, pictures: int, rendered_size: tuple[int, int], shown_size: tuple[int, int]
    ) -> None:
        self._gpu, self._carry, self._size = gpu, carry, shown_size
        self._here, self._take = (gpu.shaders.compute("fills/shown_depth.comp", PASS=k) for k in range(2))
        count = pictures if carry.works else 0
        self._rendered = [self.own(allocate(gpu.gl, rendered_size, COLOUR)) for _ in range(count)]
        self._carried = self.own(Canvas(gpu.gl, shown_size))

    def run(self, inputs: PassInputs, into: moderngl.Texture) -> None:
        """Write r32f: -1 where the warp left a hole, and everywhere if it cannot carry."""
        if self._carry.works:
            free = iter(self._rendered)

            def seen_from_here(image: EyeImage) -> moderngl.Texture:
                forward, here = view_map(image.view, image.size, inputs.shown, self._size), next(free)
                units = bind_images({"rendered_inverse_depth": image.inverse_depth}, {"here": here})
                self._here.uniforms.set(rendered_size=image.size, H=forward.H, e=forward.e, **units)
                self._here.run(*image.size)
                self._gpu.barrier()
                return here

            self._carry.along(inputs, seen_from_here, self._carried)
        else:
            self._carried.clear()
        self._gpu.barrier()
        units = bind_images({"carried": self._carried}, {"shown_inverse_depth": into})
        self._take.uniforms.set(shown_size=self._size, **units)
        self._take.run(*self._size)
        self._gpu.barrier()
