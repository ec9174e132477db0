"""Known vulnerabilities of the libraries in this environment, by pip-audit: what it found, and what it could not ask.

pip-audit passes where the data base of vulnerabilities knows a library as little as where it cannot be reached; a pass
of that kind says nothing, so here it is no pass.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

AUDIT = ("--local", "--skip-editable", "--progress-spinner", "off", "--format", "json")
CLEAN, VULNERABLE, UNKNOWN = 0, 1, 2


def judged(dependencies: Sequence[dict[str, Any]]) -> tuple[int, list[str]]:
    """Exit code, and sentences: a line for each vulnerability, and how many libraries were asked about.

    dependencies: of pip-audit's answer, each with `vulns` or with the reason for which it was skipped.
    """
    asked = [one for one in dependencies if "skip_reason" not in one]
    said = [
        f"{one['name']} {one['version']}: {found['id']}, mended in {', '.join(found['fix_versions']) or 'no version'}"
        for one in asked
        for found in one["vulns"]
    ]
    left = [one["name"] for one in dependencies if "skip_reason" in one and "editable" not in one["skip_reason"]]
    said.append(f"{len(asked)} libraries asked about, {len(said)} vulnerabilities, {len(left)} not known there")
    if len(said) > 1:
        return VULNERABLE, said
    if not asked:
        return UNKNOWN, [*said, "nothing was audited: the data base knows none of them, or cannot be reached from here"]
    return CLEAN, said + [f"not audited: {', '.join(left)}"] * bool(left)


def main() -> int:
    """Ask, and print; 0 if something was asked about and nothing found."""
    done = subprocess.run([sys.executable, "-m", "pip_audit", *AUDIT], capture_output=True, text=True, check=False)
    try:
        dependencies = json.loads(done.stdout)["dependencies"]
    except (ValueError, KeyError, TypeError):
        last = (done.stderr.strip().splitlines() or ["no word"])[-1]
        print(f"pip-audit gave no answer: {last}", file=sys.stderr)
        return UNKNOWN
    code, said = judged(dependencies)
    print(*said, sep="\n", file=sys.stderr if code else sys.stdout)
    return code


if __name__ == "__main__":
    sys.exit(main())
