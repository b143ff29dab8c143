"""A validated case written out: every key that it has or could have left out, so that the text says
all that a run depends on, whatever later versions take for granted."""

from __future__ import annotations

import os
from enum import Enum
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml
from pydantic import BaseModel

from hydrosim.case.elements import BuildContext
from hydrosim.documents.layers import DUMPER, FILES
from hydrosim.documents.units import Scale
from hydrosim.scene.arrangement import arrange_joints

if TYPE_CHECKING:
    from hydrosim.case.schema import CaseFile


def resolved_case_text(data: CaseFile, folder: Path) -> str:
    """A case file (YAML) that says of each key of ``data`` what is taken for it: in SI and radians,
    with the defaults, relative paths, which begin at ``folder``, as absolute ones."""
    output = data.output.model_copy(update={"step": data.output_step})
    place = folder / "case.yaml"
    forces = {
        name: element.with_fitted_numbers(BuildContext(f"forces.{name}", place))
        for name, element in data.forces.items()
    }
    changes = {"output": output, "environment": data.water, "bodies": _bodies(data)}
    changes["forces"] = forces
    whole = data.model_copy(update=changes)
    return yaml.dump(
        _plain(whole, folder),
        Dumper=DUMPER,
        default_flow_style=None,  # what is in one piece stands in one line
        sort_keys=False,
        allow_unicode=True,
        width=100,
    )


def _bodies(data: CaseFile) -> dict[str, Any]:
    """The bodies. Those that joints carry have neither degrees of freedom nor a start."""
    joints = {name: joint.build() for name, joint in data.joints.items()}
    carried = arrange_joints(joints, list(data.bodies)).children
    without = {"dofs": None, "initial": None}
    return {
        name: body.model_copy(update=without if name in carried else {})
        for name, body in data.bodies.items()
    }


def _plain(value: Any, folder: Path) -> Any:
    """A value as YAML has it; None is left out of mappings."""
    match value:
        case BaseModel():
            fields = type(value).model_fields
            return _plain({fields[key].alias or key: item for key, item in value}, folder)
        case dict():
            return {
                str(key): os.path.abspath(folder / item) if _is_file(key, item) else plain
                for key, item in value.items()
                if (plain := _plain(item, folder)) is not None
            }
        case tuple() | list():
            return [_plain(item, folder) for item in value]
        case Scale():
            return value.text or value.value
        case Enum():
            return str(value)
    return "infinite" if value == inf else value


def _is_file(key: object, item: object) -> bool:
    return key in FILES and isinstance(item, str)
