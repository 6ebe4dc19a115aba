from .program import facts_of as facts_of
from .program import run_session as run_session
from .runner import counting as counting
from .runner import why_sick as why_sick
from .session_context import head_angles_deg as head_angles_deg
from .session_options import SessionOptions as SessionOptions
from .trial_runner import first_picture_wait_s as first_picture_wait_s
from .wording import HeadRange as HeadRange
