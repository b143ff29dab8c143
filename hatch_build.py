"""Puts machine code of kernels into a wheel, where ``HYDROSIM_SHIPPED`` names a folder of
`python -m hydrosim.jit.ship`; otherwise a wheel is what it is without this file."""

from __future__ import annotations

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

MANIFEST = "manifest.json"  # as `hydrosim.jit.shipped` has it


class ShippedKernels(BuildHookInterface):
    """The build hook of wheels (https://hatch.pypa.io/latest/plugins/build-hook/custom/)."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the folder, and say that the wheel is for this interpreter and platform."""
        folder = os.environ.get("HYDROSIM_SHIPPED")
        if folder and version != "editable":
            if not os.path.isfile(os.path.join(folder, MANIFEST)):
                found = f"HYDROSIM_SHIPPED: found no {MANIFEST} in {folder}"
                raise SystemExit(f"{found}; expected a folder of python -m hydrosim.jit.ship")
            build_data["force_include"][os.path.abspath(folder)] = "hydrosim/jit/shipped"
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
