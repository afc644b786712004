"""The file must be well-formed XML with the root element <robot>.

Readers that recover from broken XML guess at what was meant, and drop links without a word.
Nothing after the first such place is checked.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule


@rule(Severity.ERROR, Stage.TEXT, bad=one_link().replace("</link>", ""), good=one_link())
def check(context: Context) -> Faults:
    for found in context.reading.found("RD001"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)
