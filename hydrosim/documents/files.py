"""Files that are read: a pipe or a device would be waited for, for ever."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def no_file(path: Path) -> str:
    """Why there is nothing to be read at a path, in words; empty if there is a plain file."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return "there is no such file"
    except (OSError, ValueError) as error:  # a name that is too long, or no name at all
        return f"cannot be read ({getattr(error, 'strerror', None) or error})"
    if stat.S_ISDIR(mode):
        return "is a directory"
    if not stat.S_ISREG(mode):
        return "is a pipe or a device, not a file"
    return "" if os.access(path, os.R_OK) else "may not be read"
