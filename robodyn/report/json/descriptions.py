"""What is found in a description, and on a machine, as JSON: `info`, `check` and `doctor`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robodyn.report.check_words import check_data
from robodyn.report.json.encode import finite, select, written
from robodyn.robot.urdf.parts import Joint, Limit

if TYPE_CHECKING:
    from robodyn.checks.check import Checked
    from robodyn.checks.overview import Overview
    from robodyn.checks.rule import Finding
    from robodyn.measure.doctor import Line


def overview_json(found: Overview) -> str:
    """Return a description at a glance; links and joints stand depth first."""
    counts = select(
        found,
        "links links_with_mass:massive joints joints_by_type:types mimic_joints:mimics loops merged_fixed_joints "
        "degrees_of_freedom:freedoms base_degrees_of_freedom:base_freedoms",
        links=len(found.branches),
        joints=sum(found.types.values()),
        merged_fixed_joints=found.types.get("fixed", 0),
    )
    links = [
        select(branch, "name line depth mass joint", joint=branch.joint and branch.joint.name)
        for branch in found.branches
    ]
    missing = [{"link": link, **select(each, "kind filename line")} for link, each in found.meshes.missing]
    return written(
        select(
            found,
            "robot:name file counts mass com com_frame:base at at_zero links joints meshes check notes next",
            counts=counts,
            mass=finite(found.mass),
            at_zero=not found.moved,
            links=links,
            joints=[_joint(branch.joint) for branch in found.branches if branch.joint],
            meshes=select(found.meshes, "references files:names missing", missing=missing),
            check=check_data(found.checked),
        )
    )


def _joint(joint: Joint) -> dict[str, Any]:
    return {
        **select(joint, "name line type parent child axis", **_without_axis(joint)),
        **select(joint.limit or Limit(), "lower upper effort velocity"),
        "mimic": joint.mimic and select(joint.mimic, "joint multiplier offset"),
    }


def _without_axis(joint: Joint) -> dict[str, None]:
    return {"axis": None} if joint.type in ("fixed", "floating") else {}


def check_json(checked: Checked) -> str:
    """Return {"findings": [...], "unread": [...], "summary": {...}}.

    Places count from 1; edits are byte offsets of the file.
    """
    return written(
        {
            "findings": list(map(_finding, checked.findings)),
            "unread": [select(each, "file error:why") for each in checked.unread],
            "summary": {"files": len(checked.files), **check_data(checked), "hidden": len(checked.hidden)},
        }
    )


def _finding(finding: Finding) -> dict[str, Any]:
    return select(
        finding,
        "file line column code name severity subject message remedy measured bound cause fix places",
        **_place(finding),
        places=[
            select(place, "line column subject message measured bound fix", **_place(place)) for place in finding.places
        ],
    )


def _place(finding: Finding) -> dict[str, Any]:
    return {
        "subject": finding.subject and select(finding.subject, "kind name"),
        "measured": finite(finding.measured),
        "bound": finite(finding.bound),
        "fix": finding.fix and select(finding.fix, "what safe edits"),
    }


def doctor_json(lines: tuple[Line, ...]) -> str:
    """Return {"ok": ..., "lines": [{group, name, found, verdict, remark, figures}]}."""
    from robodyn.measure.doctor import healthy

    return written({"ok": healthy(lines), "lines": lines})
