"""What lies between server and client: frames enter when they are drawn and come out when they have arrived."""

from .constant import ConstantLink

__all__ = ["ConstantLink"]
