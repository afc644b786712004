"""Mass properties as URDF writes them."""

from __future__ import annotations

from robodyn.solids.inertia.properties import MassProperties


def inertial_element(body: MassProperties, indent: str = "    ") -> str:
    """The <inertial> element of a link, about the centre of mass in the axes of the link's frame.

    Numbers are the shortest that read back as the same floats, so that nothing is lost: `ixy` and so on are entries of
    the inertia matrix, -integral of x y dm. The smallest second moment of a plate or a needle is beyond its six floats.

    Args:
        indent: what each line starts with; children are indented by two more blanks.

    Returns:
        Five lines, the last without a line break.
    """
    I = body.inertia
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    inertia = " ".join(f'{name}="{_number(I[place])}"' for name, place in names.items())
    lines = (
        "<inertial>",
        f'  <origin xyz="{" ".join(map(_number, body.com))}" rpy="0 0 0"/>',
        f'  <mass value="{_number(body.mass)}"/>',
        f"  <inertia {inertia}/>",
        "</inertial>",
    )
    return "\n".join(indent + line for line in lines)


def _number(value: float) -> str:
    return repr(float(value))
