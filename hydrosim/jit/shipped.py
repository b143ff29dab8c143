"""Machine code of kernels that was shipped with the package; `hydrosim.jit.ship` makes it.

It is executed, so it is read from the package's folder `HOME` alone. The manifest there must name
these sources and versions. The processor must have all `FEATURES`. Each file must have the checksum
in the manifest. Otherwise kernels are compiled, as they are without shipped code.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

HOME = Path(__file__).parent / "shipped"
MANIFEST = "manifest.json"
MANIFEST_ENTRIES = {"kernels", "made with", "processor", "files"}  # of a manifest
PROCESSOR = "x86-64-v3"
NO_MORE_FEATURES = ""  # features beyond `FEATURES`, in LLVM's notation: none
FEATURES = (
    "+avx,+avx2,+bmi,+bmi2,+cx16,+f16c,+fma,+lzcnt,+movbe,+popcnt,+sahf"
    ",+sse3,+sse4.1,+sse4.2,+ssse3,+xsave"
)
"""Features of every processor of that kind (System V ABI of x86-64, section 3.1.1)."""


def read_manifest() -> dict[str, Any]:
    """The manifest that `hydrosim.jit.ship` wrote. It is empty if nothing was shipped, and, with a
    warning, if it cannot be read."""
    path = HOME / MANIFEST
    try:
        manifest = dict(json.loads(path.read_bytes()))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError):
        manifest = {}
    if manifest.keys() >= MANIFEST_ENTRIES:
        return manifest
    warnings.warn(
        f"{path} is damaged: kernels are compiled, which takes longer. Install hydrosim again.",
        stacklevel=2,
    )
    return {}


SHIPPED = read_manifest()


def shipped_files(kernels: str, features: str) -> Mapping[str, str]:
    """SHA-256 (hex) of the usable files by name. ``kernels`` names the sources and versions;
    ``features`` are those of this processor, in numba's notation."""
    return {} if refusal_reason(SHIPPED, kernels, features) else SHIPPED["files"]


def read_shipped(name: str, digest: str) -> bytes | None:
    """The content of a file of `HOME`; None, with a warning, if it has another ``digest``."""
    path = HOME / name
    try:
        content = path.read_bytes()
    except OSError:
        content = b""
    if hashlib.sha256(content).hexdigest() == digest:
        return content
    warnings.warn(
        f"{path} is damaged: its kernel is compiled, which takes longer. Install hydrosim again.",
        stacklevel=2,
    )
    return None


def describe_shipped(kernels: str, features: str) -> str:
    """One line on the shipped kernels; empty if none were shipped."""
    if not SHIPPED:
        return ""
    reason = refusal_reason(SHIPPED, kernels, features)
    used = f"not used: {reason}" if reason else "used"
    return f"{len(SHIPPED['files'])} kernels for {PROCESSOR} came with the package, {used}"


def refusal_reason(manifest: Mapping[str, Any], kernels: str, features: str) -> str:
    """Reason why the shipped kernels are not used; empty if they are."""
    if not manifest:
        return "nothing was shipped"
    if manifest["kernels"] != kernels:
        return (
            f"sources or versions differ from those of the shipped kernels: {manifest['made with']}"
        )
    lacking = set(FEATURES.split(",")).difference(features.split(","))
    if lacking:
        return f"the processor lacks {', '.join(sorted(lacking))}"
    return ""
