"""An SVG file as a part of a page, in which several of them do not get into each other's way."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

# Nothing of these is drawn; the style sheet of a file would be that of the whole page.
_LEFT_OUT = ("metadata", "style", "title")
_REFERENCE = re.compile(r"url\(#([^)]*)\)")
_DECIMALS = re.compile(r"(\.\d{3})\d+")


def inline_svg(svg: str, prefix: str, title: str) -> str:
    """Return the element of an SVG file that goes into an HTML page.

    Without prolog, name spaces, metadata and style sheet; its size is that of whatever it
    stands in. Paths are cut to a thousandth of a point, which nothing shows.

    Parameters
    ----------
    svg
        The text of the file.
    prefix
        What all ids in it, and all references to them, begin with; another one for each
        figure of a page. Figures of one look have ids in common.
    title
        What the figure shows, for those who cannot see it.
    """
    root = ElementTree.fromstring(svg)
    for element in root.iter():
        element.tag = _local(element.tag)
        attributes = dict(element.attrib)
        element.attrib.clear()
        for name, value in attributes.items():
            element.set(_local(name), _rewritten(_local(name), value, prefix))
        element.text = element.text and element.text.strip()
        element.tail = None
    for parent in list(root.iter()):
        for child in [child for child in parent if child.tag in _LEFT_OUT]:
            parent.remove(child)
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    root.set("role", "img")
    root.set("aria-label", title)
    return ElementTree.tostring(root, encoding="unicode")


def _local(name: str) -> str:
    """Return a name without its name space."""
    return name.rpartition("}")[2]


def _rewritten(name: str, value: str, prefix: str) -> str:
    """Return the value of an attribute, ids with their prefix and on one line."""
    value = " ".join(value.split())
    if name == "id":
        return _prefixed(value, prefix)
    if name == "href" and value.startswith("#"):
        return "#" + _prefixed(value[1:], prefix)
    if name == "href" and value.startswith("data:"):
        return value.replace(" ", "")
    if name == "d":
        return _DECIMALS.sub(r"\1", value)
    return _REFERENCE.sub(lambda found: f"url(#{_prefixed(found[1], prefix)})", value)


def _prefixed(identifier: str, prefix: str) -> str:
    """Return an id of the page; there is no space in one."""
    return prefix + identifier.strip().replace(" ", "-")
