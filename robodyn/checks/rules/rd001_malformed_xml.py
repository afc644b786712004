"""The file must be well-formed XML with the root element <robot>.

Readers that recover from broken XML guess at what was meant, and drop links without a word.
Nothing after the first such place is checked.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Faults, Severity, Stage, rule, text_faults


@rule(Severity.ERROR, Stage.TEXT, good=one_link(), bad=("</link>", ""))
def check(context: Context) -> Faults:
    return text_faults(context, "RD001")
