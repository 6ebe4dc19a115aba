"""What a scene calls for beyond static, opaque, matt geometry."""

from __future__ import annotations

import enum


class SceneEffect(enum.Flag):
    """Effects a scene declares from its own content; the frame carries them and the plan alone looks at them.

    So far every scene is static and matt; an effect gets its member here together with its pass.
    """

    NONE = 0
