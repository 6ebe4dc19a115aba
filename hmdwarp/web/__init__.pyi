from .door import Door as Door
from .door import Lock as Lock
from .es_shaders import STEPS as STEPS
