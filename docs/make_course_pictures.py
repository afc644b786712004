"""Draw the pictures of the course, small SVG files: `python docs/make_course_pictures.py`.

Robots, momenta, inertias and free bodies are those that robodyn computes; a test draws them again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from math import atan2, cos, hypot, pi, sin, sqrt
from pathlib import Path

import numpy as np

import robodyn
from robodyn.report.equations.free_body import STYLE, drawings

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "course" / "pictures"
AXES = {"x": "#d6336c", "y": "#2b8a3e", "z": "#2f7fd6"}
BLUE, GREEN, RED, VIOLET, GREY = "#2f7fd6", "#2b8a3e", "#d6336c", "#9c5fd0", "#8b93a1"
ISOMETRIC = np.array(((-1, 1, 0), (-1, -1, 2))) / np.sqrt(((2,), (6,)))
"""From the ground's axes to right and up, seen from (1, 1, 1)."""
SIDE = np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
"""Seen against y: x to the right, z up."""


class Sheet:
    """A drawing: points in metres, right and up, put on paper by a scale and an origin in pixels."""

    def __init__(self, width: int, height: int, scale: float = 1.0, origin: tuple[float, float] = (0.0, 0.0)) -> None:
        self.size, self.scale, self.origin = (width, height), scale, origin
        self.parts: list[str] = []

    def at(self, point: Sequence[float]) -> tuple[float, float]:
        return self.origin[0] + self.scale * float(point[0]), self.origin[1] - self.scale * float(point[1])

    def line(self, points: Sequence[Sequence[float]], look: str, width: float = 2.0, dashed: bool = False) -> None:
        where = "L".join(f"{x:.1f} {y:.1f}" for x, y in map(self.at, points))
        dash = ' stroke-dasharray="4 4"' if dashed else ""
        self.parts.append(
            f'<path d="M{where}" fill="none" {_stroke(look)} stroke-width="{width:g}"{dash} '
            'stroke-linecap="round" stroke-linejoin="round"/>'
        )

    def arrow(self, start: Sequence[float], end: Sequence[float], look: str, width: float = 2.0) -> None:
        self.line((start, end), look, width)
        (x, y), (u, v) = self.at(start), self.at(end)
        long = hypot(u - x, v - y) or 1.0
        dx, dy = (u - x) / long, (v - y) / long
        head = [
            (u + 5 * dx, v + 5 * dy),
            (u - 5 * dx - 4 * dy, v - 5 * dy + 4 * dx),
            (u - 5 * dx + 4 * dy, v - 5 * dy - 4 * dx),
        ]
        where = "L".join(f"{a:.1f} {b:.1f}" for a, b in head)
        self.parts.append(f'<path d="M{where}Z" {_fill(look)}/>')

    def disc(self, point: Sequence[float], radius: float, look: str = "mark") -> None:
        x, y = self.at(point)
        shown = f"{_fill(look)}" if look[0] == "#" else f'class="{look}" stroke-width="1.5"'
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" {shown}/>')

    def centre(self, point: Sequence[float]) -> None:
        """Draw the sign of a mass centre."""
        self.disc(point, 6)
        x, y = self.at(point)
        quarters = f"M{x:.1f} {y:.1f}h6a6 6 0 0 0 -6 -6zM{x:.1f} {y:.1f}h-6a6 6 0 0 0 6 6z"
        self.parts.append(f'<path class="ink" d="{quarters}"/>')

    def text(
        self, point: Sequence[float], words: str, look: str = "ink", dx: float = 0.0, dy: float = 0.0, size: int = 14
    ) -> None:
        x, y = self.at(point)
        self.parts.append(
            f'<text x="{x + dx:.1f}" y="{y + dy + 0.35 * size:.1f}" font-size="{size}" text-anchor="middle" '
            f"{_fill(look)}>{escape(words)}</text>"
        )

    def svg(self) -> str:
        width, height = self.size
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        )
        paper = f'<rect class="paper" width="{width}" height="{height}"/>'
        return "\n".join([head, STYLE, paper, *self.parts, "</svg>\n"])


def _stroke(look: str) -> str:
    return f'stroke="{look}"' if look[0] == "#" else f'class="{look}"'


def _fill(look: str) -> str:
    return f'fill="{look}"' if look[0] == "#" else f'class="{look}"'


def frames(name: str, q: Sequence[float], view: np.ndarray, width: int, height: int, arrow: float = 42.0) -> str:
    """Draw where the frames of a robot stand, numbered by body, and its mass centres."""
    model = robodyn.load(ROOT / "robots" / f"{name}.urdf")
    bodies = robodyn.free_bodies(model, q=q).bodies
    origins = [view @ body.pose.p for body in bodies]
    centres = [view @ (body.pose.p + body.pose.R @ body.com) for body in bodies]
    every = np.array([*origins, *(c for body, c in zip(bodies, centres, strict=True) if body.mass)])
    low, high = every.min(axis=0), every.max(axis=0)
    scale = min((width - 150) / max(high[0] - low[0], 1e-9), (height - 140) / max(high[1] - low[1], 1e-9))
    middle = (low + high) / 2
    sheet = Sheet(width, height, scale, (width / 2 - scale * middle[0], height / 2 + scale * middle[1]))
    for body, origin, centre in zip(bodies, origins, centres, strict=True):
        for _, point in body.ends:
            end = view @ (body.pose.p + body.pose.R @ point)
            sheet.line((origin, end), "body", 16)
        if body.mass:
            sheet.line((origin, centre), "body", 16)
    groups: dict[tuple[int, int], list[int]] = {}
    for k, origin in enumerate(origins):
        groups.setdefault((round(origin[0] * 1e6), round(origin[1] * 1e6)), []).append(k)
    for group in groups.values():
        for k in group:  # axes of the base are shorter where another body's stand at the same place
            body, origin = bodies[k], origins[k]
            long = arrow * (0.7 if k != group[-1] else 1.0)
            for axis, letter in enumerate("xyz"):
                along = view @ body.pose.R[:, axis] * long / scale
                hidden = k != group[-1] and np.allclose(body.pose.R[:, axis], bodies[group[-1]].pose.R[:, axis])
                if hypot(*along) * scale > 5 and not hidden:
                    sheet.arrow(origin, origin + along, AXES[letter] if k == group[-1] else GREY, 2)
                    names = [n for n in group if np.allclose(bodies[n].pose.R[:, axis], body.pose.R[:, axis])]
                    name = ", ".join(f"{letter}{n}" for n in names)
                    look = AXES[letter] if k == group[-1] else "soft"
                    sheet.text(origin + along * (1 + 15 / long), name, look, 0, 0, 12)
    for body, centre in zip(bodies, centres, strict=True):
        if body.mass:
            sheet.centre(centre)
            sheet.text(centre, f"c{body.number}", "ink", 0, 17, 12)
    for group in groups.values():
        name = ",".join(str(k) for k in group)
        sheet.disc(origins[group[0]], 9 if len(group) == 1 else 12)
        sheet.text(origins[group[0]], name, "ink", size=12 if len(group) == 1 else 11)
    return sheet.svg()


def arm_momenta() -> str:
    """The two-link arm with the linear momenta of its two masses."""
    model = robodyn.load(ROOT / "robots/two_link_planar.urdf")
    q, qd, masses = [pi / 6, pi / 3], [2.0, -1.0], (4.0, 2.5)
    elbow = robodyn.forward_kinematics(model, q, "forearm").p[[0, 2]]
    tip = robodyn.forward_kinematics(model, q, "tip").p[[0, 2]]
    sheet = Sheet(460, 330, 300.0, (140.0, 285.0))
    sheet.line(((-0.1, 0.0), (1.1, 0.0)), "line", 1, dashed=True)
    sheet.line(((0, 0), elbow, tip), "body", 14)
    for link, point, mass, name in (("upper_arm", (0.5, 0, 0), 4.0, "1"), ("forearm", (0.4, 0, 0), 2.5, "2")):
        at = elbow if name == "1" else tip
        P = mass * (robodyn.jacobian(model, q, link, point) @ qd)[[3, 5]]
        sheet.arrow(at, at + 0.06 * P, RED, 2.5)
        sheet.text(at + 0.06 * P, f"P_{name} = m_{name} v_c{name}", RED, -58, 0 if name == "1" else -8)
    whole = robodyn.momenta(model, q, qd)
    c, P = whole.com[[0, 2]], whole.linear[[0, 2]]
    sheet.line(((0, 0), c), "line", 1, dashed=True)
    sheet.arrow(c, c + 0.06 * P, BLUE, 2.5)
    sheet.text(c + 0.06 * P, "P", BLUE, -14, 8)
    for point, name in ((elbow, "m_1"), (tip, "m_2")):
        sheet.disc(point, 9, GREY)
        sheet.text(point, name, "ink", 26, 10)
    sheet.centre(c)
    sheet.text(c, "c", "ink", 16, 6)
    sheet.disc((0, 0), 6)
    sheet.text((0, 0), "o", "ink", -14, 12)
    sheet.text((0.22, 0.0), "q_1", "soft", 0, -14)
    assert sum(masses) == whole.mass
    return sheet.svg()


def products_of_inertia() -> str:
    """Where mass has to lie for a product of inertia to be positive, negative or none."""
    sheet = Sheet(640, 230)
    shapes = (
        ("I_xy < 0", "more mass where x y > 0", lambda x, y: 1.0 if x * y > 0 else 0.25),
        ("I_xy = 0", "a mirror: as much on both sides", lambda x, y: 0.8),
        ("I_xy > 0", "more mass where x y < 0", lambda x, y: 1.0 if x * y < 0 else 0.25),
    )
    for k, (title, words, share) in enumerate(shapes):
        sheet.origin = (110.0 + 210.0 * k, 110.0)
        sheet.arrow((-80, 0), (80, 0), "#8b93a1", 1.5)
        sheet.arrow((0, -70), (0, 75), "#8b93a1", 1.5)
        sheet.text((90, 0), "x", "soft")
        sheet.text((0, 86), "y", "soft")
        for x, y in ((45, 32), (-45, 32), (45, -32), (-45, -32)):
            sheet.disc((x, y), 16 * sqrt(share(x, y)), BLUE)
        sheet.text((0, -84), title, "ink", 0, 0)
        sheet.text((0, -104), words, "soft", 0, 0, 12)
    return sheet.svg()


def parallel_axes() -> str:
    """A body with two parallel axes, one through its mass centre."""
    sheet = Sheet(520, 260, 1.0, (0.0, 260.0))
    corners = [(150, 60), (330, 60), (360, 150), (180, 190), (120, 120), (150, 60)]
    sheet.line(corners, "body", 20)
    c, o, dm = (245, 120), (430, 70), (170, 150)
    for point, name in ((c, "axis through c: I_c"), (o, "axis through o: I_o")):
        sheet.line((np.add(point, (-18, -48)), np.add(point, (26, 70))), BLUE if point == c else RED, 2)
        sheet.text(np.add(point, (26, 70)), name, BLUE if point == c else RED, 0, -14, 12)
    sheet.arrow(o, c, "#5c6370", 2)
    sheet.text(np.add(o, c) / 2, "d = c - o", "ink", 0, 18)
    sheet.arrow(c, dm, GREEN, 2)
    sheet.text(np.add(c, dm) / 2, "s", GREEN, 0, -14)
    sheet.disc(dm, 6, GREEN)
    sheet.text(dm, "dm", GREEN, -22, 0)
    sheet.centre(c)
    sheet.disc(o, 5)
    sheet.text(c, "c", "ink", 2, 18)
    sheet.text(o, "o", "ink", 14, 10)
    return sheet.svg()


def rotation_of_axes() -> str:
    """A bar in its own axes and in those of the part that carries it."""
    sheet = Sheet(420, 250, 100.0, (150.0, 190.0))
    angle = 0.5
    e, n = np.array((cos(angle), sin(angle))), np.array((-sin(angle), cos(angle)))
    sheet.arrow((-0.9, 0), (2.2, 0), "#5c6370", 1.5)
    sheet.arrow((0, -0.4), (0, 1.6), "#5c6370", 1.5)
    sheet.line((-0.8 * e, 0.8 * e), "body", 34)
    sheet.arrow((0, 0), 2.1 * e, RED)
    sheet.arrow((0, 0), 1.3 * n, GREEN)
    sheet.text(2.1 * e, "x of the bar", RED, 0, -16)
    sheet.text(1.3 * n, "y of the bar", GREEN, -30, -14)
    sheet.text((2.2, 0), "x", "soft", 14)
    sheet.text((0, 1.6), "y", "soft", 0, -14)
    arc = [(1.5 * cos(angle * t / 20), 1.5 * sin(angle * t / 20)) for t in range(21)]
    sheet.line(arc, "line", 1.5)
    sheet.text((1.65 * cos(angle / 2), 1.65 * sin(angle / 2)), "u", "ink")
    sheet.centre((0, 0))
    return sheet.svg()


def composite() -> str:
    """The cart's parts as mass centres from the side, the whole's mass centre and principal axes."""
    model = robodyn.load(ROOT / "robots/composite.urdf")
    whole = model.bodies[0].inertia
    sheet = Sheet(560, 340, 440.0, (240.0, 270.0))
    sheet.arrow((-0.37, 0), (0.42, 0), "#8b93a1", 1)
    sheet.arrow((0, -0.12), (0, 0.54), "#8b93a1", 1)
    sheet.text((0.42, 0), "x", "soft", 14)
    sheet.text((0, 0.54), "z", "soft", 0, -14)
    boxes = {"deck": (0.6, 0.02, 0.0), "mast": (0.1, 0.5, 0.0), "fin": (0.3, 0.2, 0.6)}
    for link in model.links:
        x, z = robodyn.forward_kinematics(model, [], link).p[[0, 2]]
        if link in boxes:
            a, b, turn = boxes[link]
            e, n = np.array((cos(turn), -sin(turn))), np.array((sin(turn), cos(turn)))
            ring = [s * a / 2 * e + t * b / 2 * n for s, t in ((1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1))]
            sheet.line([np.add(p, (x, z)) for p in ring], "edge", 1.5)
        elif "wheel" in link or link == "ball":
            r = 0.12 if "wheel" in link else 0.08
            sheet.line([(x + r * cos(t / 20 * pi), z + r * sin(t / 20 * pi)) for t in range(41)], "edge", 1.5)
        sheet.disc((x, z), 4, GREEN)
        if not link.startswith("right"):
            below = link in ("deck", "left_wheel", "left_outrigger")
            name = {"left_wheel": "wheels", "left_outrigger": "outriggers"}.get(link, link)
            sheet.text((x, z), name, "soft", 0 if link != "deck" else 34, 16 if below else -14, 12)
    c, I = whole.centre_of_mass[[0, 2]], whole.about_centre
    angle = 0.5 * atan2(-2.0 * I[0, 2], I[2, 2] - I[0, 0])
    one, three = np.array((cos(angle), sin(angle))), np.array((-sin(angle), cos(angle)))
    for e, length, name in ((one, 0.33, "1"), (three, 0.25, "3")):
        sheet.line((c - length * e, c), RED, 1.5, dashed=True)
        sheet.arrow(c, c + length * e, RED, 2)
        sheet.text(c + length * e, name, RED, 14, -8)
    sheet.centre(c)
    sheet.text(c, "c", "ink", 14, 14)
    return sheet.svg()


def mirror() -> str:
    """A plane of symmetry pairs mass at y with mass at -y."""
    sheet = Sheet(460, 250, 1.0, (230.0, 130.0))
    sheet.line(((0, -95), (0, 90)), BLUE, 2, dashed=True)
    sheet.text((0, 100), "the plane y = 0, seen along x", BLUE, 0, -14, 12)
    sheet.arrow((0, 0), (170, 0), "#8b93a1", 1.5)
    sheet.text((170, 0), "y", "soft", 16)
    for z, y, size in ((50, 70, 12), (-30, 120, 9), (-70, 40, 14), (20, 30, 8)):
        sheet.line(((-y, z), (y, z)), "line", 1, dashed=True)
        for side in (1, -1):
            sheet.disc((side * y, z), size, GREEN)
    sheet.text((0, -112), "each pair adds -z y dm and +z y dm to I_yz: nothing is left", "soft", 0, 0, 12)
    return sheet.svg()


def heavy_top() -> str:
    """The heavy top, seen along the horizontal axis y of the frame that leans with it."""
    sheet = Sheet(420, 330, 1.0, (170.0, 290.0))
    lean = 0.5
    e, n = np.array((sin(lean), cos(lean))), np.array((cos(lean), -sin(lean)))
    sheet.line(((-110, 0), (200, 0)), "line", 1.5)
    sheet.arrow((0, 0), (0, 240), GREY, 1.5)
    sheet.line((0 * e, 130 * e), "body", 10)
    sheet.line((130 * e - 62 * n, 130 * e + 62 * n), "edge", 12)
    sheet.arrow(130 * e, 235 * e, AXES["z"])
    sheet.text(235 * e, "z, spin", AXES["z"], 34, -4)
    sheet.arrow((0, 0), 70 * n, AXES["x"])
    sheet.text(70 * n, "x", AXES["x"], 14, 2)
    sheet.text((0, 240), "precession W", "soft", 0, -12)
    sheet.line([(90 * sin(lean * k / 12), 90 * cos(lean * k / 12)) for k in range(13)], "line", 1.5)
    sheet.text((100 * sin(lean / 2), 100 * cos(lean / 2)), "θ", "ink", 0, -4)
    sheet.arrow(130 * e, 130 * e + (0, -85), GREEN, 2.5)
    sheet.text(130 * e + (0, -85), "m g", GREEN, 22, -2)
    sheet.centre(130 * e)
    sheet.text(65 * e, "l", "ink", 18, 4)
    sheet.disc((0, 0), 5)
    sheet.text((0, 0), "o", "ink", -14, -10)
    sheet.text((-75, 60), "y points away", "soft", 0, 0, 12)
    return sheet.svg()


MOMENTS = np.array((1.0, 2.0, 3.0))


def _euler(w: np.ndarray) -> np.ndarray:
    return np.cross(MOMENTS * w, w) / MOMENTS


def _turned(w: np.ndarray, step: float, steps: int) -> np.ndarray:
    """Return w over time, by Runge and Kutta's method."""
    out = [w]
    for _ in range(steps):
        a = _euler(w)
        b = _euler(w + step / 2 * a)
        c = _euler(w + step / 2 * b)
        d = _euler(w + step * c)
        w = w + step / 6 * (a + 2 * b + 2 * c + d)
        out.append(w)
    return np.array(out)


def polhodes() -> str:
    """Paths of H on the sphere |H| = 1, in the axes of the plate with moments 1, 2, 3, for several energies.

    About axis k, H_i^2 (1/I_k - 1/I_i) + H_j^2 (1/I_k - 1/I_j) = 1/I_k - 2 T: an ellipse in the other two components.
    Through the middle axis go two circles, H_1^2 (1/I_1 - 1/I_2) = H_3^2 (1/I_2 - 1/I_3).
    """
    sheet = Sheet(420, 360, 140.0, (210.0, 180.0))
    towards = np.array((0.5, 0.75, 0.43))
    towards = towards / sqrt(towards @ towards)
    right = np.array((-towards[1], towards[0], 0.0)) / hypot(towards[0], towards[1])
    view = np.array((right, np.cross(towards, right)))
    turns = [np.array((cos(t), sin(t))) for t in np.linspace(0.0, 2 * pi, 73)]
    sheet.line(turns, "edge", 1.5)

    def path(points: Sequence[np.ndarray], colour: str) -> None:
        run: list[np.ndarray] = []
        for point in [*points, -towards]:
            if point @ towards > 0:
                run.append(view @ point)
            else:
                if len(run) > 1:
                    sheet.line(run, colour, 1.5)
                run = []

    inverse = 1 / MOMENTS
    for k, colour in ((0, BLUE), (2, GREEN)):
        i, j = (k + 1) % 3, (k + 2) % 3
        for share in (0.06, 0.25, 0.55, 0.85):
            excess = share * abs(inverse[k] - inverse[1])
            for side in (1.0, -1.0):
                points = []
                for c, s in turns:
                    H = np.zeros(3)
                    H[i] = c * sqrt(excess / abs(inverse[k] - inverse[i]))
                    H[j] = s * sqrt(excess / abs(inverse[k] - inverse[j]))
                    H[k] = side * sqrt(max(0.0, 1 - H @ H))
                    points.append(H)
                path(points, colour)
    one, three = sqrt(inverse[1] - inverse[2]), sqrt(inverse[0] - inverse[1])
    for side in (1.0, -1.0):
        across = np.array((one, 0.0, side * three)) / hypot(one, three)
        path([c * np.array((0.0, 1.0, 0.0)) + s * across for c, s in turns], RED)
    for axis, name in enumerate(("1 (least)", "2 (middle)", "3 (largest)")):
        end = view @ np.eye(3)[axis]
        sheet.arrow(end, 1.0 * end + 0.22 * end / max(hypot(*end), 1e-9), "#5c6370", 1.5)
        sheet.text(end + 0.22 * end / max(hypot(*end), 1e-9), name, "ink", 0, -14 if axis == 2 else 18, 13)
    return sheet.svg()


def tumbling() -> str:
    """Angular velocity of the plate that is turned about its middle axis, over time."""
    w = _turned(np.array((0.001, 1.0, 0.001)), 0.05, 1200)
    sheet = Sheet(640, 260, 1.0, (60.0, 130.0))
    sheet.arrow((0, 0), (560, 0), "#8b93a1", 1)
    sheet.arrow((0, -105), (0, 110), "#8b93a1", 1)
    for t in range(0, 61, 10):
        sheet.text((t * 9, 0), str(t), "soft", 0, 12 if t else 0, 11)
    for level in (-1, 1):
        sheet.text((0, 90 * level), f"{level}", "soft", -14, 0, 11)
    for axis, (colour, name) in enumerate(((BLUE, "w_x"), (RED, "w_y"), (GREEN, "w_z"))):
        sheet.line([(9 * 0.05 * k, 90 * w[k, axis]) for k in range(0, 1201, 6)], colour, 2)
        sheet.text((90 + 70 * axis, 112), name, colour)
    sheet.text((560, 0), "t [s]", "soft", -6, 26, 12)
    sheet.text((0, 112), "rad/s", "soft", -26, 0, 12)
    return sheet.svg()


def recursion() -> str:
    """The two passes over a chain of bodies."""
    sheet = Sheet(660, 250, 1.0, (0.0, 125.0))
    for k, name in enumerate(("ground", "body 1", "body 2", "body 3")):
        x = 70 + 170 * k
        ring = [(x - 45, -24), (x + 45, -24), (x + 45, 24), (x - 45, 24), (x - 45, -24)]
        sheet.line(ring, "line", 1.5)
        sheet.text((x, 0), name)
        if k < 3:
            sheet.line(((x + 45, 0), (x + 125, 0)), "edge", 3)
            sheet.disc((x + 85, 0), 8)
            sheet.text((x + 85, 0), str(k + 1), size=11)
            sheet.arrow((x + 20, 62), (x + 150, 62), BLUE, 2)
            sheet.text((x + 85, 62), f"w_{k + 1} v_{k + 1} wd_{k + 1} a_{k + 1}", BLUE, 0, -14, 13)
            sheet.arrow((x + 150, -62), (x + 20, -62), RED, 2)
            sheet.text((x + 85, -62), f"F_{k + 1} M_{k + 1}", RED, 0, 16, 13)
    sheet.text((330, 108), "outwards: each body takes the motion of the one before, turned and moved", BLUE, 0, 0, 13)
    sheet.text((330, -108), "inwards: each body hands the wrench at its joint to the one before", RED, 0, 0, 13)
    return sheet.svg()


def blocks() -> str:
    """Where Gamma and its inverse Phi have blocks, for a chain and for a body that carries two."""
    sheet = Sheet(640, 240, 1.0, (0.0, 0.0))
    chain, fork = (-1, 0, 1), (-1, 0, 0)
    for k, (parents, title) in enumerate(((chain, "chain 1 - 2 - 3"), (fork, "body 1 carries 2 and 3"))):
        for m, name in enumerate(("Gamma", "Phi")):
            left, top, cell = 30 + 310 * k + 145 * m, 40, 38
            for row in range(3):
                for column in range(3):
                    above, i = [], row
                    while parents[i] >= 0:
                        i = parents[i]
                        above.append(i)
                    value = "0"
                    if m == 0 and column == parents[row]:
                        value = f"A_{row + 1}"
                    elif m == 1 and column == row:
                        value = "1"
                    elif m == 1 and column in above:
                        value = "A_3 A_2" if above.index(column) == 1 else f"A_{row + 1}"
                    x, y = left + cell * column, -(top + cell * row)
                    colour = BLUE if value != "0" else ""
                    ring = [(x, y), (x + cell, y), (x + cell, y - cell), (x, y - cell), (x, y)]
                    sheet.line(ring, "edge", 1)
                    sheet.text(
                        (x + cell / 2, y - cell / 2), value, colour or "soft", 0, 0, 12 if len(value) < 5 else 10
                    )
            sheet.text((left + 1.5 * cell, -(top + 3 * cell)), name, "ink", 0, 18)
        sheet.text((160 + 310 * k, -(40 + 3 * 38)), title, "soft", 0, 48, 13)
    return sheet.svg()


def free_bodies() -> dict[str, str]:
    """The free bodies of the two-link arm, as `robodyn fbd --svg` draws them."""
    model = robodyn.load(ROOT / "robots/two_link_planar.urdf")
    found = robodyn.free_bodies(model, q=[pi / 6, pi / 3], qd=[2.0, -1.0], qdd=[0.0, 0.0])
    drawn = dict(drawings(found, "q = (30, 60) degrees, qd = (2, -1) rad/s"))
    return {f"free_body_{name[3:-4]}": text for name, text in drawn.items() if name[:2] in ("01", "02")}


PICTURES: dict[str, Callable[[], str]] = {
    "two_link_planar": lambda: frames("two_link_planar", [pi / 6, pi / 3], SIDE, 460, 330),
    "two_link_spatial": lambda: frames("two_link_spatial", [-0.5, 0.6], ISOMETRIC, 460, 380),
    "scara": lambda: frames("scara", [-0.5, 1.4, 0.12], ISOMETRIC, 520, 400),
    "cylindrical": lambda: frames("cylindrical", [0.4, 0.1, 0.2, 0.1], ISOMETRIC, 520, 420),
    "puma": lambda: frames("puma", [0.3, -0.5, 0.6], ISOMETRIC, 520, 420),
    "satellite": lambda: frames("satellite", [1.0, -0.5], ISOMETRIC, 560, 400),
    "arm_momenta": arm_momenta,
    "products_of_inertia": products_of_inertia,
    "parallel_axes": parallel_axes,
    "rotation_of_axes": rotation_of_axes,
    "composite": composite,
    "mirror": mirror,
    "heavy_top": heavy_top,
    "polhodes": polhodes,
    "tumbling": tumbling,
    "recursion": recursion,
    "blocks": blocks,
}


def pictures() -> dict[str, str]:
    """Return the text of every picture by the name of its file."""
    found = {name: draw() for name, draw in PICTURES.items()} | free_bodies()
    return {f"{name}.svg": text for name, text in found.items()}


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, text in pictures().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
        print(f"{name}: {len(text) / 1000:.0f} kB")
