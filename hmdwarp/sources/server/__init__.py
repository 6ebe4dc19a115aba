"""The server: draw a scene for the eyes into a Frame. It knows no latency, warps or lenses."""

from .draw import MIRRORS as MIRRORS
from .draw import Server as Server
from .passes import ArrivingLight as ArrivingLight
from .passes import ConvergedLight as ConvergedLight
from .passes import Lighting as Lighting
from .passes import ScenePasses as ScenePasses
from .passes import clear_depth as clear_depth
from .passes import draw_moving as draw_moving
from .targets import BYTES_BINDING as BYTES_BINDING
from .targets import Framebuffers as Framebuffers
from .targets import Multisampled as Multisampled
from .targets import Renderer as Renderer
from .targets import Target as Target
from .targets import TargetPool as TargetPool
from .targets import display_bytes as display_bytes
from .upload import DeformingMesh as DeformingMesh
from .upload import SceneBuffers as SceneBuffers
from .upload import SceneTextures as SceneTextures
from .upload import moving_parts as moving_parts
from .visibility import Visibility as Visibility
from .visibility import boxes_of as boxes_of
from .visibility import clip_from_eye as clip_from_eye
from .visibility import draws_of as draws_of
from .visibility import eye_from_scene as eye_from_scene
