"""Puts the shipped cases into a wheel, and machine code of kernels, if ``HYDROSIM_SHIPPED`` names a
folder of `python -m hydrosim.jit.ship`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

MANIFEST = "manifest.json"  # as `hydrosim.jit.shipped` has it
PROGRAMS = (".py", ".pyc")
NOT_SHIPPED = "thesis"
"""Folder of a case with programs and the measurements that they read."""


class Included(BuildHookInterface):
    """The build hook of wheels (https://hatch.pypa.io/latest/plugins/build-hook/custom/)."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add cases and machine code. With the latter the wheel is for this interpreter and
        platform."""
        if version == "editable":
            return
        root = Path(__file__).resolve().parent
        for file in shipped_cases(root):
            build_data["force_include"][str(root / file)] = f"hydrosim/examples/{file.as_posix()}"
        folder = os.environ.get("HYDROSIM_SHIPPED")
        if folder:
            if not os.path.isfile(os.path.join(folder, MANIFEST)):
                found = f"HYDROSIM_SHIPPED: found no {MANIFEST} in {folder}"
                raise SystemExit(f"{found}; expected a folder of python -m hydrosim.jit.ship")
            build_data["force_include"][os.path.abspath(folder)] = "hydrosim/jit/shipped"
            build_data["pure_python"] = False
            build_data["infer_tag"] = True


def shipped_cases(root: Path) -> list[Path]:
    """Files of the cases, from ``root`` on, without programs beside them."""
    files = sorted(path.relative_to(root) for path in (root / "cases").rglob("*") if path.is_file())
    return [f for f in files if f.suffix not in PROGRAMS and NOT_SHIPPED not in f.parts]
