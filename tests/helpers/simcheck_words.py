"""What simcheck says where it names a defect precisely, by the rule that names it here.

Words are judged generously: those of its checks, and those of the engines that it passes on. What is not listed it has
no words for.
"""

from __future__ import annotations

import re

PRECISE = {
    "RD001": r"XML parse error",
    "RD002": r"undefined entity|DOCTYPE|DTD",
    "RD003": r"unbound prefix",
    "RD004": r"xacro|unbound prefix",
    "RD005": r"repeated element|unknown|unrecognized|not recognized",
    "RD006": r"\biyx|\bizx|\bizy",
    "RD007": r"unreadable|not a (finite )?number|not finite|NaN|needs \d|needs radius|without a valid|bad format"
    r"|attribute missing|infinite|no damping and no friction",
    "RD010": r"version",
    "RD101": r"missing link",
    "RD102": r"more than one parent",
    "RD103": r"cycle",
    "RD104": r"root links",
    "RD105": r"duplicate link",
    "RD106": r"duplicate joint",
    "RD107": r"no name|unnamed|not named",
    "RD108": r"\btype\b",
    "RD110": r"names?\b.*(slash|digit|same|character)",
    "RD111": r"kinematics.attached",
    "RD112": r"kinematics.attached",
    "RD113": r"geometry.scale|authored in|\bunits?\b",
    "RD201": r"explicit mass",
    "RD202": r"no <inertial>|mass is zero",
    "RD203": r"unreadable (mass|inertia)|all-zero inertia|no <inertial>|mass is zero",
    "RD204": r"all-zero inertia|mjMINVAL",
    "RD205": r"mass is zero|explicit mass",
    "RD206": r"not positive definite",
    "RD207": r"triangle inequality",
    "RD208": r"placeholder|default|copied",
    "RD209": r"tiny|smaller than a solid",
    "RD210": r"joins parts of",
    "RD213": r"twice|again",
    "RD214": r"no <inertial>",
    "RD301": r"too large for its geometry",
    "RD302": r"centre of mass is .* outside",
    "RD303": r"smaller than a solid",
    "RD304": r"inertia.density",
    "RD305": r"\bunits?\b",
    "RD404": r"mirror|twin|opposite",
    "RD405": r"mirror|twin|opposite",
    "RD501": r"zero axis",
    "RD502": r"axis has length",
    "RD503": r"is above upper",
    "RD504": r"has no lower/upper|lower == upper|joints.limits: .* range is",
    "RD505": r"no <limit>",
    "RD506": r"(effort|velocity) limit|no (effort|velocity)|limit.*(effort|velocity)",
    "RD507": r"degrees|\bdeg\b",
    "RD508": r"\bsoft\b|safety",
    "RD509": r"negative damping or friction",
    "RD510": r"mimics missing|missing: 'joint'",
    "RD511": r"mimics itself|mimic (cycle|loop)|repeated in equality",
    "RD512": r"joints.mimic: .*(range|limit)",
    "RD513": r"continuous joint",
    "RD514": r"no axis|has no <axis>",
    "RD515": r"joints.limits: .*travels|(velocity|effort) limit|\bunits?\b",
    "RD601": r"mesh .*not found|unreadable mesh",
    "RD603": r"outside|escapes",
    "RD606": r"must be positive|scale|without a valid size",
    "RD608": r"<geometry> is missing",
    "RD609": r"geometry.visual_match",
    "RD610": r"overlap|start inside|interpenetrat",
    "RD611": r"\bflat\b|zero volume|no volume|kg/m\^3|coplanar|volume.* too small",
    "RD621": r"material",
    "RD622": r"colou?r|rgba",
    "RD623": r"texture",
    "RD701": r"reference|ros2_control|transmission|plugin",
    "RD702": r"ros2_control|command_interface|state_interface",
    "RD703": r"transmission|reduction",
    "RD704": r"ros2_control|\bmin\b.*\bmax\b",
    "RD705": r"ros2_control",
    "RD706": r"srdf",
    "RD707": r"srdf|group",
    "RD708": r"srdf|group",
    "RD709": r"srdf|adjacent|disable_collisions",
    "RD801": r"torque|effort",
    "RD803": r"effort",
    "RD804": r"damping",
}


def precise(code: str, words: str) -> bool:
    pattern = PRECISE.get(code)
    return pattern is not None and re.search(pattern, words, re.IGNORECASE) is not None
