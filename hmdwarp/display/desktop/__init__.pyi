from .desktop_display import DesktopDisplay as DesktopDisplay
from .window_system import WindowView as WindowView
from .window_system import choose_library as choose_library
