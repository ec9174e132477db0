"""Which Pythons and which versions of the libraries the package works with, tried as a user installs it.

For every Python that can be found, with the newest libraries and with the lowest that pyproject.toml declares: an
environment is made, a wheel is installed in it, a run of one second is computed and its fingerprint taken, what `make
demo` does is done, and some quick tests are run. Then each extra is added by itself and tested. Outcomes are kept in
out/matrix, one file an entry, so that a second call goes on where the first was stopped; a changed source makes them
stale. Whatever goes wrong in an entry is its outcome, and the next one follows. The table is
docs/evidence/compatibility.md.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ("3.11", "3.12", "3.13")
CHOICES = ("newest", "lowest")
SHOWN = ("numpy", "numba", "scipy", "pydantic", "typer", "click", "pint", "h5py", "h5netcdf", "xarray", "matplotlib")
TESTS = ("test_checkpoint.py", "test_result.py", "test_units.py", "test_surroundings.py")
TEST_TOOLS = ("pytest", "hypothesis")
QUICK = "not slow and not browser"
EXTRAS: Mapping[str, Sequence[str]] = {
    "app": ("-m", QUICK, "tests/app/test_asked.py", "tests/app/test_drugs.py", "tests/app/test_runs.py"),
    "browser": ("-m", "browser", "tests/app/test_drugs.py"),
    "studies": ("-m", QUICK, "tests/unit/test_indices.py", "tests/unit/test_study_sweep.py"),
    "cluster": ("-m", QUICK, "tests/unit/test_cluster.py"),
    "cells": ("-m", QUICK, "tests/unit/test_cells.py"),
    "benchmarks": ("-m", QUICK, "tests/unit/test_benchmark_myokit.py"),
    "surface": ("-m", QUICK, "tests/unit/test_surface.py"),
    "movie": ("-m", QUICK, "tests/unit/test_plots.py", "-k", "mp4 or film"),
    "dev": ("-m", QUICK, "-n", "2", "tests/unit/test_grid.py", "tests/unit/test_units.py"),
    "docs": (),
}
"""What is asked of pytest for each extra; the site is built for `docs`, its notebooks left as they are."""
SITE = ("-q", "-b", "html", "-D", "nb_execution_mode=off", "-c", "docs/site")
PATIENCE = 3600.0
"""Seconds that a step of an entry may take; a cold compile on a busy machine is the longest."""

RUN = """
import importlib.metadata as about, json, sys
import peristalsis as ps
result = ps.run("baseline", {"run.duration": "1 s"})
print(json.dumps({
    "place": ps.__file__,
    "python": sys.version.split()[0],
    "status": result.status,
    "position": float(result.arrays["pellet_position"][-1]),
    "fingerprint": result.fingerprint[:12],
    "versions": {one.name.lower(): one.version for one in about.distributions() if one.name},
}))
"""

_BOUND = re.compile(r"^\s*([A-Za-z0-9._-]+)\s*(?:\[[^\]]*\])?\s*([^;]*)(;.*)?$")


class Failed(Exception):
    """A step of an entry that did not succeed, in one line."""


def lowest(project: Mapping[str, object]) -> dict[str, str]:
    """Lowest declared version of every dependency and of every extra, by name.

    project: the table `project` of a pyproject.toml. Raises ValueError for one without a lower bound: it promises all.
    """
    extras = project.get("optional-dependencies", {})
    assert isinstance(extras, Mapping)
    lines: list[str] = [*project.get("dependencies", ())]  # type: ignore[misc]
    for group in extras.values():
        lines += group
    found: dict[str, str] = {}
    own = f"{project.get('name', '')}["
    for line in lines:
        if line.startswith(own):  # an extra made of another one, whose requirements are there themselves
            continue
        match = _BOUND.match(line)
        bounds = re.findall(r"(?:>=|==|~=)\s*([0-9][^,\s]*)", match.group(2)) if match else []
        if match is None or len(bounds) != 1 or match.group(3):
            raise ValueError(f"{line!r} is no requirement with one lower bound and no condition, such as 'numpy>=2.1'")
        found[match.group(1).lower()] = bounds[0]
    return found


def constraints(bounds: Mapping[str, str]) -> str:
    """The text of a constraints file that lets pip take the lowest versions alone."""
    return "".join(f"{name}=={version}\n" for name, version in sorted(bounds.items()))


def find(version: str) -> str | None:
    """An interpreter of a version such as 3.12: of pyenv, or on the path. None if there is none that runs."""
    own = sorted(Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")).glob(f"versions/{version}.*/bin/python"))
    for candidate in (*map(str, reversed(own)), shutil.which(f"python{version}")):
        if candidate is not None and _says(candidate) == version:
            return candidate
    return None


def _says(interpreter: str) -> str | None:
    program = "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"
    try:
        done = subprocess.run([interpreter, "-c", program], capture_output=True, text=True, check=False, timeout=60.0)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def digest() -> str:
    """Hash of what an outcome depends on in this checkout."""
    files = [ROOT / "pyproject.toml", Path(__file__), *sorted((ROOT / "src").rglob("*.py"))]
    files += sorted((ROOT / "src").rglob("*.toml")) + [ROOT / "tests" / "unit" / name for name in TESTS]
    together = hashlib.sha256()
    for file in files:
        together.update(file.relative_to(ROOT).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return together.hexdigest()[:16]


def call(words: Sequence[str | Path], folder: Path, what: str, log: Path) -> str:
    """What a command says on stdout; its whole output goes to a log. Raises Failed with its last line."""
    free = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**free, **threads, "MPLBACKEND": "Agg"}
    try:
        done = subprocess.run(
            [str(word) for word in words],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
            env=environment,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired:
        raise Failed(f"{what}: not through after {PATIENCE:.0f} s") from None
    with log.open("a", encoding="utf-8") as file:
        file.write(f"== {what}\n{done.stdout}\n{done.stderr}\n")
    if done.returncode != 0:
        lines = [line.strip() for line in (done.stderr + done.stdout).splitlines() if line.strip()]
        telling = [line for line in lines if line.startswith(("ERROR", "error", "FAILED")) or "Error:" in line]
        raise Failed(f"{what}: {(telling or lines or ['no word'])[-1][:160]}")
    return done.stdout


def attempt(interpreter: str, choice: str, folder: Path, bounds: Mapping[str, str]) -> dict[str, object]:
    """The outcome of one entry: what was installed, what the run gave, what the tests said, or what failed."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    log, python = folder / "log.txt", folder / "environment" / "bin" / "python"
    found: dict[str, object] = {"outcome": "works"}
    begin = time.monotonic()
    try:
        call([interpreter, "-m", "venv", folder / "environment"], folder, "environment", log)
        install = [python, "-m", "pip", "install", "--disable-pip-version-check"]
        if choice == "lowest":
            (folder / "constraints.txt").write_text(constraints(bounds), encoding="utf-8")
            install += ["-c", folder / "constraints.txt"]
        call([*install[:3], "wheel", "--no-deps", "-w", folder / "wheel", ROOT], folder, "wheel", log)
        (wheel,) = (folder / "wheel").glob("*.whl")
        call([*install, wheel, *TEST_TOOLS], folder, "install", log)
        found |= json.loads(call([python, "-c", RUN], folder, "run of 1 s", log).splitlines()[-1])
        if not str(found.pop("place")).startswith(str(folder)):
            raise Failed("run of 1 s: the package was not that of the environment")
        call([python, "-m", "peristalsis", "run", "baseline", "--out", folder / "demo"], folder, "demo", log)
        found["pictures"] = len(list((folder / "demo").rglob("*.png")))
        call([python, "-m", "peristalsis", "run", "--help"], folder, "help", log)
        files = [ROOT / "tests" / "unit" / name for name in TESTS]
        words = ["-q", "-W", "default", "-p", "no:cacheprovider", "--rootdir", ROOT]
        try:
            call([python, "-m", "pytest", *words, *files], ROOT, "tests", log)
        finally:
            found["tests"] = counted(log.read_text(encoding="utf-8"))
        found["extras"] = {
            extra: with_extra(extra, python, [*install, f"{wheel}[{extra}]"], folder) for extra in EXTRAS
        }
    except Failed as failure:
        found["outcome"] = str(failure)
    except Exception as error:  # whatever it is, the other entries are tried
        found["outcome"] = f"{type(error).__name__}: {error}"
    shutil.rmtree(folder / "environment", ignore_errors=True)
    return found | {"seconds": round(time.monotonic() - begin)}


def with_extra(extra: str, python: Path, install: Sequence[str | Path], folder: Path) -> str:
    """What came of adding an extra to an environment: the count of its tests, or what failed.

    Wheels alone are taken: what would have to be compiled is no version that a user gets.
    """
    log = folder / f"{extra}.txt"
    try:
        call([*install, "--only-binary", ":all:"], folder, "install", log)
        if extra == "docs":
            call([python, "-m", "sphinx", *SITE, "docs", folder / "site"], ROOT, "site", log)
            return f"{len(list((folder / 'site').rglob('*.html')))} pages"
        words = ["-q", "-W", "default", "-p", "no:cacheprovider", *EXTRAS[extra]]
        call([python, "-m", "pytest", *words], ROOT, "tests", log)
        return counted(log.read_text(encoding="utf-8"))
    except Failed as failure:
        return str(failure)


def counted(said: str) -> str:
    """Passed, failed and skipped tests in the last line that counts them; a dash if there is none."""
    found = re.findall(r"^=*\s*((?:\d+ \w+,? )+)in [0-9.]+s", said, flags=re.MULTILINE)
    return str(found[-1]).strip() if found else "–"


def page(outcomes: Iterable[tuple[str, str, Mapping[str, object]]]) -> str:
    """The table in Markdown: a row an entry, with what it came to and with which versions."""
    rows = list(outcomes)
    lines = [
        "# Compatibility",
        "",
        "Made by `make matrix` (`tools/matrix.py`): for each Python that was found, the package is",
        "installed from its wheel into a fresh environment, with the newest libraries and with the lowest",
        "that `pyproject.toml` declares. Then one second of the baseline is computed, what `make demo`",
        "does is done (its pictures are counted), and tests of units, checkpoints, results and",
        "surroundings are run. The *fingerprint* is that of every number of the run of one second and of",
        "the version.",
        "",
        "| Python | libraries | outcome | pellet after 1 s [cm] | fingerprint | demo | tests |",
        "|---|---|---|---|---|---|---|",
    ]
    for version, choice, found in rows:
        cells = [str(found.get("python", version)), choice, str(found.get("outcome", "")).replace("|", "\\|")]
        position = found.get("position")
        cells += [f"{position:.12g}" if isinstance(position, float) else "–"]
        drawn = f"{found['pictures']} pictures" if "pictures" in found else "–"
        cells += [str(found.get("fingerprint", "–")), drawn, str(found.get("tests", "–"))]
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", f"| Python | libraries | {' | '.join(SHOWN)} |", f"|---|---|{'---|' * len(SHOWN)}"]
    for version, choice, found in rows:
        versions = found.get("versions", {})
        assert isinstance(versions, Mapping)
        shown = [str(versions.get(name, "–")) for name in SHOWN]
        lines.append(f"| {found.get('python', version)} | {choice} | {' | '.join(shown)} |")
    lines += _of_extras(rows)
    positions = [found["position"] for *_, found in rows if isinstance(found.get("position"), float)]
    if len(positions) > 1:
        spread = max(positions) - min(positions)  # type: ignore[type-var, operator]
        hashes = len({found["fingerprint"] for *_, found in rows if "fingerprint" in found})
        lines += [
            "",
            f"The positions differ by at most {spread:.1e} cm; of fingerprints there are {hashes}.",
        ]
    return "\n".join([*lines, ""])


def _of_extras(rows: Sequence[tuple[str, str, Mapping[str, object]]]) -> list[str]:
    """A table of what came of each extra, with a column an entry that got so far."""
    tried = {
        f"{found.get('python', version)} {choice}": found["extras"]
        for version, choice, found in rows
        if "extras" in found
    }
    if not tried:
        return []
    lines = ["", "Each extra, added from wheels alone, and its tests:", "", f"| extra | {' | '.join(tried)} |"]
    lines.append(f"|---|{'---|' * len(tried)}")
    for extra in EXTRAS:
        said = [str(one.get(extra, "–")).replace("|", "\\|") for one in tried.values() if isinstance(one, Mapping)]
        lines.append(f"| {extra} | {' | '.join(said)} |")
    return lines


def main(words: Sequence[str] | None = None) -> int:
    """Try the entries that have no outcome yet, write the table; 0 if all that could be tried works."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--python", action="append", choices=PYTHONS, help="this Python only; may be repeated")
    parser.add_argument("--libraries", action="append", choices=CHOICES, help="these only; may be repeated")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "matrix", help="where outcomes are kept")
    parser.add_argument("--page", type=Path, default=ROOT / "docs" / "evidence" / "compatibility.md")
    given = parser.parse_args(words)
    with (ROOT / "pyproject.toml").open("rb") as file:
        bounds = lowest(tomllib.load(file)["project"])
    state, rows = digest(), []
    for version in PYTHONS:
        for choice in CHOICES:
            kept = given.out / f"{version}-{choice}.json"
            found = _kept(kept, state)
            asked = version in (given.python or PYTHONS) and choice in (given.libraries or CHOICES)
            if found is None and asked:
                interpreter = find(version)
                if interpreter is None:
                    print(f"Python {version}: not found here", file=sys.stderr)
                    found = {"outcome": "not tried: no such Python was found"}
                else:
                    print(f"Python {version}, {choice} libraries ...", file=sys.stderr, flush=True)
                    found = attempt(interpreter, choice, given.out.absolute() / f"{version}-{choice}", bounds)
                    kept.write_text(json.dumps({"state": state, "found": found}), encoding="utf-8")
                    print(f"    {found['outcome']} ({found['seconds']} s)", file=sys.stderr, flush=True)
            rows.append((version, choice, found or {"outcome": "not tried"}))
            given.page.write_text(page(rows), encoding="utf-8")
    return int(any(not str(found["outcome"]).startswith(("works", "not tried")) for *_, found in rows))


def _kept(file: Path, state: str) -> dict[str, object] | None:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        return dict(content["found"]) if content["state"] == state else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


if __name__ == "__main__":
    sys.exit(main())
