"""The programs that a description is meant for read its meshes."""

from robodyn.checks.consumers.meshes import READS, unread
from robodyn.checks.examples import a_mesh
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.support.wording import count

_KNOWN = "; ".join(
    f"{target}: {' '.join(reads.suffixes)} for {' and '.join(reads.kinds)}, and {reads.otherwise} otherwise"
    f" ({reads.source})"
    for target, reads in READS.items()
)


@rule(
    Severity.NOTE,
    explanation=f"""With a target named, formats of meshes that it does not read are reported, once each. They read
{_KNOWN}. The examples stand beside the meshes that they name, and are checked for mujoco.""",
    good=a_mesh("part.stl"),
    bad=("stl", "dae"),
)
def check(context: Context) -> Faults:
    """Silent unless a target is named."""
    for target in context.asked.targets:
        for suffix, uses in unread(context, target).items():
            reads = READS[target]
            named = count(len(uses), "shape has one", "shapes have one")
            what = f"{target} does not read {suffix or 'files without a suffix'} and {reads.otherwise}: {named}"
            yield Fault(uses[0].at, what, f"it reads {' '.join(reads.suffixes)} ({reads.source})")
