"""The audit of vulnerabilities: a pass means that something was asked about."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import pytest
from unit.programs import tool

CLEAN = {"name": "numpy", "version": "2.4", "vulns": []}
BAD = {"name": "old", "version": "1.0", "vulns": [{"id": "PYSEC-1", "fix_versions": ["1.1"]}]}
UNKNOWN = {"name": "scipy", "skip_reason": "Dependency not found on PyPI and could not be audited: scipy (1.17)"}
OWN = {"name": "peristalsis", "skip_reason": "distribution marked as editable"}


@pytest.fixture(scope="module")
def audit() -> ModuleType:
    return tool("audit")


@pytest.mark.parametrize(
    ("found", "code", "said"),
    [
        ([CLEAN, OWN], 0, "1 libraries asked about, 0 vulnerabilities, 0 not known there"),
        ([CLEAN, UNKNOWN], 0, "not audited: scipy"),
        ([CLEAN, BAD], 1, "old 1.0: PYSEC-1, mended in 1.1"),
        ([UNKNOWN, OWN], 2, "nothing was audited"),
        ([], 2, "nothing was audited"),
    ],
)
def test_what_is_found_and_what_was_not_asked(
    audit: ModuleType, found: list[dict[str, Any]], code: int, said: str
) -> None:
    given, words = audit.judged(found)
    assert given == code
    assert said in "\n".join(words)


def test_no_answer_is_no_pass(audit: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """pip-audit is not there, or has another form of answer."""

    class Done:
        stdout, stderr = "", "No module named pip_audit"

    monkeypatch.setattr(audit.subprocess, "run", lambda *words, **options: Done())
    assert audit.main() == 2
