"""Every equation of the paper has code, a test and a problem, or says why not; and what notices if it does not."""

import ast
from dataclasses import replace
from pathlib import Path

import pytest

from verification import trace
from verification.trace import citations, cited, missing, page, traced

ROOT = Path(__file__).parents[2]


def test_no_equation_is_left_out() -> None:
    assert missing() == []
    assert [one.number for one in traced()] == list(range(1, 14))


def test_equation_without_code_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = {number: places for number, places in citations().items() if number != 4}
    monkeypatch.setattr(trace, "citations", lambda: kept)
    assert missing() == ["equation (4), strain energy: no code cites it; cite it where it is computed"]


def test_equation_without_test_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trace, "problems", dict)
    assert len(missing()) == len([one for one in traced() if one.code])


def test_equation_that_got_code_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stale reason must not stand beside the code that it says is missing."""
    waiting = tuple(replace(one, awaited="not written yet") if one.number == 8 else one for one in traced())
    monkeypatch.setattr(trace, "traced", lambda: waiting)
    assert len(missing()) == 1
    sentence = missing()[0]
    assert "drop `awaited`" in sentence


def test_named_tests_exist() -> None:
    for one in traced():
        for name in one.tests:
            file, _, function = name.partition("::")
            tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
            assert function in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}, name


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("by Eq. (4).", {4}),
        ("Eqs. (1), (17), (27)", {1, 17, 27}),
        ("Eq. (1) with (2)-(5), (14)-(16) and (35).", {1, 2, 3, 4, 5, 14, 15, 16, 35}),
        ("Eqs. (20)-(22) and (31)", {20, 21, 22, 31}),
        ("(4) alone, or Equation 4, cites nothing", set()),
    ],
)
def test_citations_are_read(text: str, numbers: set[int]) -> None:
    assert cited(text) == numbers


def test_every_cited_equation_is_in_the_documents() -> None:
    """Code cites numbers of docs/equations.md and no others."""
    text = (ROOT / "docs/equations.md").read_text(encoding="utf-8")
    assert all(f"({number})" in text for number in citations())


def test_page_has_a_line_for_each() -> None:
    lines = [line for line in page().splitlines() if line.startswith("| (")]
    assert len(lines) == 13
    assert "wall/laws/tong_fung.py" in lines[3]
