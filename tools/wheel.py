"""A wheel that brings its kernels compiled, so that a first run starts as fast as any other.

The kernels of the shipped parts are compiled for a level of processors rather than for the one at hand, in a fresh
cache, and become the folder `objects` of the wheel (docs/decisions/0029). The wheel is one for this system and this
Python; where its numba or its processor do not fit, kernels are compiled at the first run as ever.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OBJECTS = ROOT / "build" / "objects"

LEVELS = {
    "x86_64": (
        "x86-64-v3",
        "+avx,+avx2,+bmi,+bmi2,+cmov,+cx16,+cx8,+f16c,+fma,+fxsr,+lzcnt,+mmx,+movbe,+popcnt,+sahf,+sse,+sse2,+sse3,"
        "+sse4.1,+sse4.2,+ssse3,+xsave",
    )
}
"""LLVM's name and features of the level of a machine; "generic" where none is named. x86-64-v3: since 2013 to 2015."""

COMPILE = "from peristalsis.running.warm_up import warm_up; warm_up(surface={surface}, explicit={explicit})"


def compile_kernels(folder: Path, surface: bool, explicit: bool) -> None:
    """Compile the kernels of the shipped parts for this machine's level into a folder, which is made anew."""
    processor, features = LEVELS.get(platform.machine(), ("generic", ""))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    settings = {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": features, "NUMBA_CACHE_DIR": str(folder)}
    kept = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    words = [sys.executable, "-c", COMPILE.format(surface=surface, explicit=explicit)]
    subprocess.run(words, check=True, cwd=ROOT, env={**kept, **settings})
    from llvmlite import binding

    about = {"triple": binding.get_process_triple(), "processor": processor, "features": features}
    (folder / "about.json").write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Compile, then build the wheel; the exit code."""
    parser = argparse.ArgumentParser(description="Build a wheel with compiled kernels.")
    parser.add_argument("--out", default="dist", help="folder of the wheel")
    parser.add_argument("--surface", action="store_true", help="kernels of the whole surface too (some minutes)")
    parser.add_argument("--explicit", action="store_true", help="kernels of the explicit scheme too")
    chosen = parser.parse_args()
    compile_kernels(OBJECTS, chosen.surface, chosen.explicit)
    size = sum(file.stat().st_size for file in OBJECTS.rglob("*.nb?"))
    print(f"kernels: {len(list(OBJECTS.rglob('*.nbc')))} in {size / 1e6:.1f} MB")
    words = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", chosen.out, str(ROOT)]
    return subprocess.run(words, check=False, env={**os.environ, "PERISTALSIS_OBJECTS": str(OBJECTS)}).returncode


if __name__ == "__main__":
    sys.exit(main())
