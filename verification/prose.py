"""Pages in Markdown with prose in lines of 100 columns, for the programs that write pages."""

from __future__ import annotations

import re

WIDTH = 100
_CODE = re.compile(r"(`+[^`]*`+)")
_ITEM = re.compile(r"\s*(?:[-*]|\d+\.|:) +")
_AS_IT_IS = re.compile(r"\s*(?:#|\||!\[|<!|---$|\(\S+\)=)")
_NEVER_FIRST = re.compile(r"(?:[-+*#>|=:]+|\d+[.)])$|\|")
"""Words that would begin a list, a heading, a quotation or a table at the head of a line."""


def wrapped(page: str) -> str:
    """The page with paragraphs and items that are too wide in lines of WIDTH; code, tables, pictures as they are.

    A piece of code is never broken, so a line that holds a long one may stay wider.
    """
    done: list[str] = []
    block: list[str] = []
    fenced = False
    for line in page.split("\n"):
        fence = line.lstrip().startswith("```")
        indented = line.startswith("    ") and not block
        if fence or fenced or indented or not line.strip() or _AS_IT_IS.match(line):
            done += _filled(block)
            done.append(line)
            block = []
            fenced = fenced != fence
            continue
        if _ITEM.match(line):
            done += _filled(block)
            block = []
        block.append(line)
    return "\n".join(done + _filled(block))


def _filled(block: list[str]) -> list[str]:
    """The lines of a paragraph or of an item, filled anew where one is too wide."""
    if all(len(line) <= WIDTH for line in block):
        return block
    item = _ITEM.match(block[0])
    lead = item[0] if item else block[0][: len(block[0]) - len(block[0].lstrip())]
    lines, line = [], lead
    for word in _words(" ".join([block[0][len(lead) :], *block[1:]])):
        begun = line.strip() if line != lead else ""
        if begun and len(line) + 1 + len(word) > WIDTH:
            lines.append(line)
            line = " " * len(lead) + word
        else:
            line += f" {word}" if begun else word
    return [*lines, line]


def _words(text: str) -> list[str]:
    """What may stand on a line of its own: words, whole pieces of code, and no mark that means something there."""
    found: list[str] = []
    parts = _CODE.split(" ".join(text.split()))
    marked = "".join(part.replace(" ", "\0") if number % 2 else part for number, part in enumerate(parts))
    for word in marked.split():
        whole = word.replace("\0", " ")
        if found and _NEVER_FIRST.match(whole):
            found[-1] += f" {whole}"
        else:
            found.append(whole)
    return found
