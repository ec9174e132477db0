"""What hatchling puts into a wheel besides the package: compiled kernels, if `tools/wheel.py` has made some."""

from __future__ import annotations

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ObjectsHook(BuildHookInterface):
    """Takes the folder that PERISTALSIS_OBJECTS names; the wheel is then one for this system and this Python."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the folder to the wheel; without one it stays a wheel for every system."""
        folder = os.environ.get("PERISTALSIS_OBJECTS")
        if folder and self.target_name == "wheel" and version == "standard":
            build_data["force_include"][folder] = "peristalsis/objects"
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
