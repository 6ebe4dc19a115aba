"""Objects in JSON files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...errors import InputError


def read_json(path: Path, wanted: str = "an object") -> dict[str, Any]:
    """Return the object in a JSON file. wanted: in words. Errors: InputError."""
    try:
        data = json.loads(path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file ({error})") from error
    except json.JSONDecodeError as error:
        raise InputError(f"{path}, line {error.lineno}: not JSON ({error.msg})") from error
    # A number of thousands of digits, or brackets nested without end.
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON that can be read ({error})") from error
    if not isinstance(data, dict):
        raise InputError(f"{path}: found a {type(data).__name__}; expected {wanted}")
    return data
