from ._model import COLOURS as COLOURS
from ._model import MAX_COEFFICIENTS as MAX_COEFFICIENTS
from ._model import CameraDisplay as CameraDisplay
from ._model import Headset as Headset
from ._model import RadialLens as RadialLens
from ._model import camera_display as camera_display
from ._model import headset_names as headset_names
from ._model import load_headset as load_headset
