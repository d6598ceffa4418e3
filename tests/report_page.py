"""A report as a reader of HTML finds it, with nothing of the package."""

from __future__ import annotations

import dataclasses
from html.parser import HTMLParser

_VOID = {"meta", "wbr", "br"}


@dataclasses.dataclass
class Element:
    """An element of a page."""

    tag: str
    attributes: dict[str, str | None]
    children: list[Element | str] = dataclasses.field(default_factory=list)

    @property
    def text(self) -> str:
        """All text in it, spaces made one and none of them special."""
        parts = (part if isinstance(part, str) else part.raw_text for part in self.children)
        return " ".join("".join(parts).split())

    @property
    def raw_text(self) -> str:
        """All text in it as it is."""
        return "".join(p if isinstance(p, str) else p.raw_text for p in self.children)

    def all(self, tag: str = "") -> list[Element]:
        """Return all elements in it, or those of a kind, in their order."""
        found = []
        for child in self.children:
            if isinstance(child, Element):
                found += [child] if tag in ("", child.tag) else []
                found += child.all(tag)
        return found

    def section(self, heading: str) -> Element:
        """Return the only section with a heading."""
        (found,) = (each for each in self.all("section") if each.all("h2")[0].text == heading)
        return found

    def rows(self) -> dict[str, str]:
        """Return the first cell of every row of the tables in it with the text of the others."""
        cells = [
            [cell.text for cell in row.children if isinstance(cell, Element)]
            for row in self.all("tr")
        ]
        return {first: " | ".join(others) for first, *others in cells}


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open = [Element("page", {})]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        element = Element(tag, dict(attrs))
        self.open[-1].children.append(element)
        if tag not in _VOID:
            self.open.append(element)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open[-1].children.append(Element(tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop().tag == tag

    def handle_data(self, data: str) -> None:
        self.open[-1].children.append(data)


def read_page(text: str) -> Element:
    """Return the elements of a page; every one that is opened is closed in its order."""
    reader = _Reader()
    reader.feed(text)
    reader.close()
    (page,) = reader.open
    return page
