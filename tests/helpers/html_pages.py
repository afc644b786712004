"""What every HTML report must be, found without a browser: well-formed, self-contained, accessible, small."""

from __future__ import annotations

import base64
import hashlib
import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"meta", "link", "br", "wbr", "img", "hr", "input"}
LARGEST = 3_000_000
"""Bytes of a page."""
ADDRESS = re.compile(r"""(?:https?:|ftp:|file:|//)[^\s"'<>]*""", re.IGNORECASE)
NAMESPACES = {"http://www.w3.org/1999/xlink", "http://www.w3.org/2000/svg"}


@dataclass
class Element:
    tag: str
    attributes: dict[str, str | None]
    parents: tuple[str, ...]
    text: str = ""


@dataclass
class Page(HTMLParser):
    """The elements of a page in their order; raises where they do not close as they opened."""

    source: str
    elements: list[Element] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self._open: list[Element] = []
        self.feed(self.source)
        self.close()
        assert not self._open, [each.tag for each in self._open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        names = [name for name, _ in attrs]
        assert len(set(names)) == len(names), (tag, names)
        element = Element(tag, dict(attrs), tuple(each.tag for each in self._open))
        self.elements.append(element)
        if tag not in VOID:
            self._open.append(element)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append(Element(tag, dict(attrs), tuple(each.tag for each in self._open)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open, tag
        assert self._open.pop().tag == tag, tag

    def handle_data(self, data: str) -> None:
        for each in self._open:
            each.text += data

    def all(self, tag: str) -> list[Element]:
        return [each for each in self.elements if each.tag == tag]


def checked(source: str) -> Page:
    """The page, which keeps to every rule that can be tested here."""
    assert len(source.encode()) < LARGEST
    page = Page(source)
    _alone(page)
    _safe(page)
    _accessible(page)
    return page


def contrast(one: str, other: str) -> float:
    """The ratio of luminances of two colours, #rrggbb, by WCAG 2."""
    found = []
    for colour in (one, other):
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        found.append(sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True)))
    return (max(found) + 0.05) / (min(found) + 0.05)


def _alone(page: Page) -> None:
    """Nothing is fetched: no address but those that name XML's vocabularies, in no attribute and no style."""
    for element in page.elements:
        for name, value in element.attributes.items():
            if name.startswith("xmlns"):
                assert value in NAMESPACES
            elif name in ("href", "src", "xlink:href", "action", "data", "srcset", "style"):
                assert not ADDRESS.search((value or "").partition(";base64,")[0]), (element.tag, value)
                assert name == "style" or (value or "").startswith(("#", "data:")), (element.tag, name, value)
    for style in page.all("style"):
        assert "@import" not in style.text
        assert "url(" not in style.text


def _safe(page: Page) -> None:
    """Every script has its digest in the policy, and the data are none; no handlers in attributes."""
    (policy,) = (each for each in page.all("meta") if each.attributes.get("http-equiv"))
    scripts = [each for each in page.all("script") if each.attributes.get("type") != "application/json"]
    digests = [base64.b64encode(hashlib.sha256(each.text.encode()).digest()).decode() for each in scripts]
    assert "script-src " + " ".join(f"'sha256-{digest}'" for digest in digests) in str(policy.attributes["content"])
    assert "default-src 'none'" in str(policy.attributes["content"])
    assert not [name for element in page.elements for name in element.attributes if name.startswith("on")]
    assert not {"iframe", "object", "embed", "base", "form"} & {element.tag for element in page.elements}


def _accessible(page: Page) -> None:
    assert page.elements[0].attributes == {"lang": "en"}
    for tag in ("main", "header", "footer", "h1", "title"):
        assert len(page.all(tag)) == 1, tag
    names = [str(element.attributes["id"]) for element in page.elements if "id" in element.attributes]
    assert len(names) == len(set(names)), sorted(name for name in names if names.count(name) > 1)
    for element in page.elements:
        for name in ("aria-labelledby", "href", "xlink:href"):
            value = element.attributes.get(name) or ""
            if value and (name == "aria-labelledby" or value.startswith("#")):
                assert value.removeprefix("#") in names, value
        if element.attributes.get("role") in ("img", "region"):
            assert element.attributes.get("aria-label") or element.attributes.get("aria-labelledby"), element
    regions = [each.attributes.get("aria-label") for each in page.elements if each.attributes.get("role") == "region"]
    assert len(regions) == len(set(regions)), regions
    assert all(each.attributes.get("scope") in ("row", "col") for each in page.all("th"))
    assert len(page.all("caption")) == len(page.all("table"))
    assert len(page.all("figure")) == len(page.all("figcaption"))
    assert all("var(--" in value for value in _colours(page))


def _colours(page: Page) -> list[str]:
    """The colours of what is drawn, all of which must be the page's, but those of the raster."""
    found = []
    for element in page.elements:
        for name in ("fill", "stroke"):
            value = element.attributes.get(name)
            found += [value] if value and value != "none" else []
        style = element.attributes.get("style") or ""
        found += [
            value.strip()
            for name, _, value in (each.partition(":") for each in style.split(";"))
            if name.strip() in ("fill", "stroke") and value.strip() != "none"
        ]
    return found
