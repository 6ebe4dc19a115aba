"""Who answers beside the one who looks: nobody, or a simulated participant for rehearsals."""

from ._base import Nobody, Respondent

__all__ = ["Nobody", "Respondent"]
