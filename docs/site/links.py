"""Every link within the built site leads somewhere: `python docs/site/links.py FOLDER`."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Links of a page, and the places in it that can be linked to."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.places: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what a tag links to, and its id."""
        for name, value in attrs:
            if value and name in ("href", "src"):
                self.links.add(value)
            elif value and (name == "id" or (tag == "a" and name == "name")):
                self.places.add(value)


def broken(site: Path) -> tuple[int, list[str]]:
    """How many links within the site there are, and those that lead nowhere, as "page: link"."""
    pages = {file.resolve(): Page(file) for file in sorted(site.rglob("*.html"))}
    count, found = 0, []
    for file, page in pages.items():
        for link in sorted(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            count += 1
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            place = unquote(parts.fragment)
            if not target.exists() or (place and target in pages and place not in pages[target].places):
                found.append(f"{file.relative_to(site.resolve())}: {link}")
    return count, found


if __name__ == "__main__":
    count, found = broken(Path(sys.argv[1]))
    print(f"{count} links within the site, {len(found)} broken", *found, sep="\n  ")
    sys.exit(bool(found))
