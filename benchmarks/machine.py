"""On what a bench was run: processor, memory, system, versions, state of the source."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
from functools import cache
from pathlib import Path

import peristalsis
from peristalsis.storing.environment import machine, processors, versions

PACKAGE = Path(peristalsis.__file__).resolve().parent
BENCHMARKS = Path(__file__).resolve().parent


@cache
def source() -> str:
    """Hash of every source file of the package and of the benchmarks; 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for home in (PACKAGE, BENCHMARKS):
        for file in sorted(home.rglob("*.py")):
            digest.update(file.relative_to(home.parent).as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def commit() -> str:
    """The commit of a checkout, with a mark if the package differs from it; `unknown` outside of one."""
    try:
        said = subprocess.run(
            ["git", "-C", str(PACKAGE), "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True, check=True
        ).stdout.strip()
        changed = subprocess.run(
            ["git", "-C", str(PACKAGE), "status", "--porcelain", "--", "."], capture_output=True, text=True, check=True
        ).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return f"{said}, changed" if changed else said


def processor() -> str:
    """The processor's name for itself, and the name that the compiler has for it."""
    name = platform.processor()
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                name = line.partition(":")[2].strip()
                break
    except OSError:
        pass  # not a Linux system
    kind = machine()["processor"]
    return f"{name} ({kind})" if name else kind


def memory_bytes() -> int:
    """Memory of the machine; 0 where it is not told."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (ValueError, OSError, AttributeError):
        return 0


def load() -> float:
    """Mean number of processes that wanted to run in the last minute; -1 where it is not told."""
    try:
        return os.getloadavg()[0]
    except OSError:
        return -1.0


def about() -> dict[str, str]:
    """The machine and the code in a few lines."""
    memory = memory_bytes()
    return {
        "processor": processor(),
        "cores": str(processors()),
        "memory": f"{memory / 2**30:.0f} GiB" if memory else "unknown",
        "system": machine()["system"],
        "versions": ", ".join(f"{name} {number}" for name, number in versions().items()),
        "commit": commit(),
    }


@cache
def stamp() -> str:
    """What a measurement belongs to: this source on this machine with these libraries."""
    parts = (source(), processor(), str(processors()), *(f"{name}={number}" for name, number in versions().items()))
    return hashlib.sha256("|".join(parts).encode()).hexdigest()[:16]
