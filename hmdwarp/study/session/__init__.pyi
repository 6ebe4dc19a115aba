from .program import run_session as run_session
from .session_context import head_angles_deg as head_angles_deg
from .session_facts import facts_of as facts_of
from .session_options import SessionOptions as SessionOptions
from .sickness import counting as counting
from .sickness import why_sick as why_sick
from .trial_runner import first_picture_wait_s as first_picture_wait_s
