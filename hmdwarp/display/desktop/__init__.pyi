from .desktop_display import DesktopDisplay as DesktopDisplay
from .window_system import choose_library as choose_library
from .window_system import window_view as window_view
