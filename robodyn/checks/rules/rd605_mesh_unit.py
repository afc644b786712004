"""Meshes have the size of their robot.

STL and OBJ have no unit, URDF reads them as metres, and CAD writes millimetres. A mesh longer than
20 m and 20 times the longest distance between joints; or shorter than 1 mm in a robot 100 times as large; or about
1000 times larger or smaller than the link's other mesh; or with factors that differ by 1000 between axes has the wrong
unit, and so has one with a scale of 1000 that is not there to be measured. The other rules leave it out. The examples
stand beside a file `millimetres.stl` of a part 200 mm long.
"""

from robodyn.checks.meshes.units import mesh_slips
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.support.wording import shown_path

_SCALED = """<robot name="arm">
  <link name="base"/>
  <link name="part">
    <visual><geometry><mesh filename="millimetres.stl" scale="0.001 0.001 0.001"/></geometry></visual>
  </link>
  <joint name="mount" type="fixed">
    <parent link="base"/>
    <child link="part"/>
    <origin xyz="0 0 0.3"/>
  </joint>
</robot>
"""


@rule(Severity.ERROR, good=_SCALED, bad=("0.001 0.001 0.001", "1 1 1"))
def check(context: Context) -> Faults:
    reported = set()
    for geometry, slip in context.once(mesh_slips).items():
        scale = None if geometry.shape is None else geometry.shape.get("scale")
        if geometry.shape is None or (slip.name.uri, scale) in reported:
            continue
        reported.add((slip.name.uri, scale))
        what = f"the mesh {shown_path(slip.name.uri)} has the wrong unit: {slip.how}"
        at = value_span(geometry.shape, "filename" if scale is None else "scale")
        yield Fault(at, what, _remedy(slip.factor), slip.longest, slip.longest / slip.factor)


def _remedy(factor: float) -> str:
    if factor > 1:
        return 'if the file is in millimetres, write scale="0.001 0.001 0.001"'
    return "if the file is in metres, leave the scale out; otherwise multiply it by 1000"
