"""Experimenter's console: shows how the session goes, and sends the experimenter's commands."""

from ._base import Console, ConsoleState, NoConsole, Question
from .console_commands import checked_answer, clock, parse_line, subject_of
from .key_entry import KeyEntry
from .line_console import LineConsole, news
from .message_socket import MessageSocket
from .screen_text import HELP, Scene, end_of, gauge, plain, scale_line
from .terminal_console import KINDS, TerminalConsole, make_console

__all__ = [
    "HELP",
    "KINDS",
    "Console",
    "ConsoleState",
    "KeyEntry",
    "LineConsole",
    "MessageSocket",
    "NoConsole",
    "Question",
    "Scene",
    "TerminalConsole",
    "checked_answer",
    "clock",
    "end_of",
    "gauge",
    "make_console",
    "news",
    "parse_line",
    "plain",
    "scale_line",
    "subject_of",
]
