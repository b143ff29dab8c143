"""Files to read. Opening a pipe or a device would wait without end, so only plain files are
accepted."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def no_file(path: Path) -> str:
    """Reason why a path cannot be read, in words; empty if it is a plain file."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return "there is no such file"
    except (OSError, ValueError) as error:  # a name that is too long, or no valid name
        return f"cannot be read ({getattr(error, 'strerror', None) or error})"
    if stat.S_ISDIR(mode):
        return "is a directory"
    if not stat.S_ISREG(mode):
        return "is a pipe or a device, not a file"
    return "" if os.access(path, os.R_OK) else "may not be read"
