"""What names the version says the same one, with the same date: the package, the citation, the changelog."""

import re
from pathlib import Path

import peristalsis as ps

ROOT = Path(__file__).parents[2]


def test_citation_and_changelog_are_of_this_version() -> None:
    """A reader who cites the file, or looks up what is new, is told of the version that runs."""
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    version, date = (re.search(rf"^{key}: (\S+)$", cited, re.MULTILINE) for key in ("version", "date-released"))
    assert version is not None
    assert date is not None
    assert version[1] == ps.__version__
    released = re.findall(r"^## \[(\d\S*)\] - (\S+)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert released[0] == (version[1], date[1])
