"""The command line: what is printed where, what is stored, and how a run that breaks off ends."""

from __future__ import annotations

import errno
import io
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis import scenarios
from peristalsis.cli import main, running
from peristalsis.cli.help import EXAMPLES, EXIT_CODES
from peristalsis.cli.report import number_text
from peristalsis.cli.stored import labels
from peristalsis.cli.streams import ForgivingStream, RunProgress, Screen, spelled
from peristalsis.errors import ConfigurationError, DivergenceError
from peristalsis.many import comparing
from peristalsis.plots import Plots
from peristalsis.results.result import Result
from peristalsis.running.runner import KeptRun
from peristalsis.running.warm_up import warm_up
from peristalsis.storing import disk, manifest, store
from peristalsis.storing.netcdf import netcdf_image
from peristalsis.storing.store import CONFIGURATION_FILE, RESULT_FILE, SUMMARY_FILE

TINY = {"grid.n_z": "300", "grid.n_z_wall": "100", "run.duration": "0.05 s"}
SET = tuple(word for key, value in TINY.items() for word in ("--set", f"{key}={value}"))
NUMBERS = {RESULT_FILE, SUMMARY_FILE, CONFIGURATION_FILE, manifest.FILE}
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(ps.__file__).parents[1])}
PICTURES = {f"{name}.png" for name in running.PICTURES}

Capture = pytest.CaptureFixture[str]


def no_space(*_: object, **__: object) -> None:
    """What writing to a full disk does."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def contents(folder: Path) -> set[str]:
    """Names in a folder, the hidden ones as well, but the last state, which may be there or not."""
    return {path.name for path in folder.iterdir()} - {store.LAST_STATE}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two short stored runs, `first` and `second`, without pictures."""
    folder = tmp_path_factory.mktemp("runs")
    for name, pressure in (("first", "0.1 kPa"), ("second", "0.2 kPa")):
        ps.run("baseline", {**TINY, "lumen.pressure": pressure}).save(folder / name)
    return folder


@pytest.fixture(scope="module")
def result(runs: Path) -> Result:
    """One short run."""
    return ps.load(runs / "first")


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch, result: Result) -> Result:
    """Let `run` come to its result without computing."""
    monkeypatch.setattr(running, "_simulate", lambda *_: (result, None))
    return result


# --- start-up and help ------------------------------------------------------------------------------


def test_help_loads_nothing_heavy_and_is_quick() -> None:
    program = (
        "import sys; from peristalsis.cli import main; code = main(['--help']);"
        "heavy = {'numpy', 'numba', 'matplotlib', 'xarray', 'pint', 'scipy', 'h5py', 'peristalsis.inputs.config'};"
        "import time; print(sorted(heavy & set(sys.modules)), code, time.process_time())"
    )
    seconds = []
    for _ in range(3):  # of the processor, and the quickest of three: the machine may be busy
        done = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True, env=ENVIRONMENT
        )
        *said, spent = done.stdout.splitlines()[-1].split()
        seconds.append(float(spent))
        assert said == ["[]", "0"]
    assert min(seconds) < 0.5


def test_module_and_command_are_the_same() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "peristalsis", "version"],
        capture_output=True,
        text=True,
        check=True,
        env=ENVIRONMENT,
    )
    assert done.stdout.startswith(f"peristalsis {ps.__version__}, python ")


def test_help_states_exit_codes_and_commands(capsys: Capture) -> None:
    assert main([]) == 0
    text = capsys.readouterr().out
    assert " ".join(text.split()).endswith(EXIT_CODES)
    for command in EXAMPLES:
        assert re.search(rf"^ *{command}\b", text, re.MULTILINE)


@pytest.mark.parametrize("command", EXAMPLES)
def test_examples_stand_in_the_help_as_they_are_typed(command: str, capsys: Capture) -> None:
    assert main([*filter(None, [command]), "--help"]) == 0
    text = capsys.readouterr().out
    for example in EXAMPLES[command]:
        assert f"  {example}\n" in text


def test_examples_run(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """Every example, in the order of the help texts, on a small grid and with stubs for the slow drawing."""
    from peristalsis.cli import inputs

    read = inputs.read_settings
    monkeypatch.setattr(inputs, "read_settings", lambda settings: {**TINY, **read(settings)})
    drawn: list[str] = []

    def save(plots: Plots, folder: Path, names: Any = None, formats: Any = ("png",)) -> list[Path]:
        drawn.extend(plots.available() if names is None else names)
        assert set(drawn) <= set(plots.names())
        folder.mkdir(exist_ok=True)
        return []

    def film(plots: Plots, path: Path, *more: int) -> Path:
        path.write_bytes(b"GIF89a")
        return path

    def scene(plots: Plots, path: Path, **options: Any) -> Path:
        path.write_bytes(b"PNG")
        return path

    def export(result: Result, folder: Path, *more: object) -> list[Path]:
        folder.mkdir()
        return [folder]

    monkeypatch.setattr(Plots, "save", save)
    monkeypatch.setattr(Plots, "film", film)
    monkeypatch.setattr("peristalsis.cli.paper_command.carry_out_order", lambda order, screen: 0)
    monkeypatch.setattr("peristalsis.cli.bench_command.carry_out_order", lambda order, screen: 0)
    monkeypatch.setattr("peristalsis.cli.bench_command.calibrate_order", lambda order, screen: 0)
    monkeypatch.setattr("peristalsis.cli.passes_command.carry_out", lambda *given: 0)
    monkeypatch.setattr("peristalsis.cli.batching.batch", lambda file, out, workers, screen, drugs, library: 0)
    for name in ("sweep", "stall_map", "sensitivity", "cohort", "kept"):
        monkeypatch.setattr(f"peristalsis.cli.studying.{name}", lambda *given: 0)
    for command in ("dose", "fit"):
        monkeypatch.setattr(f"peristalsis.cli.{command}_command.carry_out", lambda order, screen: 0)
    monkeypatch.setattr(Plots, "scene", scene)
    monkeypatch.setattr("peristalsis.cli.app_command._serve", lambda *words: 0)
    monkeypatch.setattr("peristalsis.cli.paper_command.search_order", lambda order, screen: 0)
    writers = SimpleNamespace(export_csv=export, export_vtk=export)
    monkeypatch.setitem(sys.modules, "peristalsis.plots.export", writers)
    (here / "my.toml").write_text('scenario = "resting"\n[lumen]\npressure = "1 mmHg"\n', encoding="utf-8")
    assert main(["run", "reflex_only"]) == 0
    done = set()
    for command in ("run", *EXAMPLES):
        for example in EXAMPLES[command]:
            words = shlex.split(example)
            assert words[0] == "peristalsis"
            if example not in done:
                assert main(words[1:]) == 0, capsys.readouterr().err
            done.add(example)
    assert (here / "out/mine" / SUMMARY_FILE).exists()
    assert (here / "out/compared/tracks.png").exists()
    assert "overview" in drawn


# --- a run that finishes ----------------------------------------------------------------------------


def test_a_run_stores_numbers_and_pictures(here: Path, capsys: Capture) -> None:
    assert main(["run", "baseline", *SET]) == 0
    said = capsys.readouterr()
    assert contents(here) == {"out"}
    assert contents(here / "out") == {"baseline"}
    assert contents(here / "out/baseline") == NUMBERS | PICTURES
    assert ps.load("out/baseline").configuration.texts()["grid.n_z"] == 300
    text = " ".join(said.out.split())
    for words in ("230 mN*s/cm 23 N*s/m 230 Ns/m", "20 mN 0.02 N 20 N", "1.2 cm 12 mm", "overview.png"):
        assert words in text
    assert re.search(r"mean velocity of the pellet \S+ cm/s \S+ mm/s", text)
    assert re.search(r"largest axial force on the pellet \S+ mN \S+ N", text)
    assert "saved in out/baseline" in text


def test_a_run_on_the_whole_surface_draws_its_maps(here: Path) -> None:
    ring = ["--set", "grid.n_theta=4"]
    assert main(["run", "baseline", *SET, *ring]) == 0
    assert contents(here / "out/baseline") == NUMBERS | PICTURES | {f"{name}.png" for name in running.AROUND}


def test_json_is_one_object_and_that_of_the_summary_file(here: Path, capsys: Capture) -> None:
    assert main(["run", "baseline", *SET, "--no-plots", "--json", "--out", "deep/down"]) == 0
    said = capsys.readouterr()
    content = json.loads(said.out)
    assert content == json.loads((here / "deep/down" / SUMMARY_FILE).read_text())
    assert (content["scenario"], content["reading"], content["error"]) == ("baseline", "tight", None)
    assert contents(here / "deep/down") == NUMBERS
    lines = [line for line in said.err.splitlines() if "%" in line]
    assert len([line for line in lines if not line.startswith("warning")]) <= 11
    assert lines[-1] == "100 %  t = 0.05 of 0.05 s, pellet at 1.20 cm"


def test_a_file_its_reading_and_changes_reach_the_run(here: Path, at_once: Result, monkeypatch: Any) -> None:
    seen = []

    def simulate(kept: KeptRun, screen: Screen) -> tuple[Result, None]:
        seen.append(kept.configuration)
        return at_once, None

    monkeypatch.setattr(running, "_simulate", simulate)
    Path("my.toml").write_text('scenario = "resting"\n[pellet]\nradius = "8 mm"\nstart_gap = "1 mm"\n')
    words = [
        "run",
        "--config",
        "my.toml",
        "--reading",
        "stretched",
        "--set",
        "wall.length = 12 cm",
        "--no-plots",
    ]
    assert main(words) == 0
    assert seen == [
        scenarios.configuration(
            "resting", reading="stretched", changes={"pellet.start_gap": "1 mm", "wall.length": "12 cm"}
        )
    ]
    assert contents(here / "out") == {"resting"}


def test_remarks_are_warnings(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    from peristalsis.model import initial

    begin = initial.initial_state
    monkeypatch.setattr(initial, "initial_state", lambda model: (*begin(model)[:2], ["the cell is restless"]))
    assert main(["run", "baseline", *SET, "--no-plots", "--json"]) == 0
    said = capsys.readouterr()
    assert "warning: the cell is restless\n" in said.err
    json.loads(said.out)


def test_overwrite_replaces_an_old_result(here: Path, at_once: Result) -> None:
    assert main(["run", "baseline", "--no-plots"]) == 0
    (here / "out/baseline/old.png").write_bytes(b"")
    assert main(["run", "baseline", "--no-plots"]) == 4
    assert "old.png" in contents(here / "out/baseline")
    assert main(["run", "baseline", "--no-plots", "--overwrite"]) == 0
    assert contents(here / "out/baseline") == NUMBERS


def test_drawing_that_fails_costs_the_pictures_only(
    here: Path, at_once: Result, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    def save(plots: Plots, folder: Path, names: object) -> None:
        (folder / "half.png").write_bytes(b"")
        raise ValueError("no ink")

    monkeypatch.setattr(Plots, "save", save)
    assert main(["run", "baseline"]) == 0
    said = capsys.readouterr()
    assert contents(here / "out/baseline") == NUMBERS
    assert said.err == ("warning: the pictures could not be drawn (no ink); the numbers are saved in out/baseline\n")


# --- a run that breaks off --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes",
    [
        ["--set", "pacemaker.intensity=1000 uA/cm^2"],
        ["--set", "solver.max_newton=1", "--set", "solver.max_halvings=0"],
    ],
    ids=["potential", "wall"],
)
def test_a_diverged_run_keeps_its_history(changes: list[str], here: Path, capsys: Capture) -> None:
    assert main(["run", "baseline", *SET, *changes, "--json", "--no-plots"]) == 3
    said = capsys.readouterr()
    content = json.loads(said.out)
    assert content == json.loads((here / "out/baseline" / SUMMARY_FILE).read_text())
    assert content["status"] == "diverged"
    assert " t = " in content["error"]
    assert said.err.splitlines()[-1] == f"error: {content['error']} (saved in out/baseline)"
    stored = ps.load("out/baseline")
    assert (stored.status, stored.error) == ("diverged", content["error"])
    assert np.isfinite(stored.arrays["radius"]).all()


def test_a_run_that_cannot_begin_leaves_nothing(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def begin(*_: object) -> None:
        raise DivergenceError("the tube bursts at t = 0 s; lower lumen.pressure")

    monkeypatch.setattr("peristalsis.model.initial.initial_state", begin)
    assert main(["run", "baseline", *SET, "--json"]) == 3
    said = capsys.readouterr()
    assert json.loads(said.out) == {
        "scenario": "baseline",
        "status": "diverged",
        "error": "the tube bursts at t = 0 s; lower lumen.pressure",
    }
    assert contents(here) == set()


@contextmanager
def started(*words: str, duration: str = "20 s") -> Iterator[subprocess.Popen[str]]:
    """A run in a process of its own, once it has made a tenth of its way."""
    command = [
        sys.executable,
        "-m",
        "peristalsis",
        "run",
        "baseline",
        *SET,
        "--set",
        "output.interval=1 s",
        *words,
    ]
    command[command.index("run.duration=0.05 s")] = f"run.duration={duration}"
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)
    try:
        assert process.stderr is not None
        assert any(line.startswith(" 10 %") for line in process.stderr)  # reads on until then
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_stops_a_run_and_keeps_its_history(number: signal.Signals, here: Path) -> None:
    with started("--json", "--set", "run.stop_when_expelled=false") as process:
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
        assert process.returncode == 130
    content = json.loads(out)
    assert content == json.loads((here / "out/baseline" / SUMMARY_FILE).read_text())
    assert content["status"] == "interrupted"
    assert 2.0 <= content["simulated_s"] < 20.0
    assert err.splitlines()[-1] == f"{content['error']} (saved in out/baseline)"
    assert "Traceback" not in err
    left = contents(here / "out/baseline")
    assert left & set(store.CHECKPOINTS)
    assert left - set(store.CHECKPOINTS) == NUMBERS  # nobody who stops a run waits for its pictures
    assert ps.load("out/baseline").status == "interrupted"


def test_a_killed_run_leaves_nothing_that_loads(here: Path) -> None:
    with started("--set", "run.stop_when_expelled=false") as process:
        process.kill()
        process.communicate(timeout=60)
    for folder in (path for path in here.rglob("*") if path.is_dir()):
        with pytest.raises(ConfigurationError):
            ps.load(folder)
    with pytest.raises(ConfigurationError, match="missing"):
        ps.load("out/baseline")


def test_a_killed_run_is_resumed_to_the_same_bits(here: Path, capsys: Capture) -> None:
    """R1, R2 through the command: kill -9, then --resume; and again, when nothing is left to do."""
    words = ["run", "baseline", *SET, "--set", "run.stop_when_expelled=false", "--set", "run.checkpoint=0.1 s"]
    words[words.index("run.duration=0.05 s")] = "run.duration=2 s"
    with started("--set", "run.stop_when_expelled=false", "--set", "run.checkpoint=0.1 s", duration="2 s") as process:
        process.kill()
        process.communicate(timeout=60)
    assert main([*words, "--set", "output.interval=1 s", "--no-plots", "--resume"]) == 0
    assert "resumed at t = " in capsys.readouterr().err
    assert contents(here / "out") == {"baseline"}
    assert main([*words, "--set", "output.interval=1 s", "--no-plots", "--out", "whole"]) == 0
    assert ps.load("out/baseline").fingerprint == ps.load("whole").fingerprint
    capsys.readouterr()
    assert main([*words, "--set", "output.interval=1 s", "--no-plots", "--resume", "--json"]) == 0
    said = capsys.readouterr()
    assert "nothing is left to run" in said.err
    assert json.loads(said.out)["steps"] == 400


def test_a_diverged_run_is_not_run_a_second_time(here: Path, capsys: Capture) -> None:
    words = ["run", "baseline", *SET, "--set", "pacemaker.intensity=1000 uA/cm^2", "--no-plots"]
    assert main(words) == 3
    assert main([*words, "--resume", "--json"]) == 3
    said = capsys.readouterr()
    assert json.loads(said.out)["status"] == "diverged"
    assert said.err.endswith("(saved in out/baseline)\n")


def test_a_result_that_cannot_be_written_leaves_its_checkpoint(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """R9: the disk fills up at the very end; nothing but the end has to be done again."""
    words = ["run", "baseline", *SET, "--set", "run.checkpoint=0.02 s", "--no-plots"]
    with monkeypatch.context() as patched:
        patched.setattr(Result, "_about", no_space)
        assert main(words) == 4
    assert "--resume goes on from it" in capsys.readouterr().err
    assert main([*words, "--resume"]) == 0
    assert "resumed at t = 0.04 s" in capsys.readouterr().err
    assert contents(here / "out") == {"baseline"}


@pytest.mark.slow
def test_ctrl_c_ends_soon_and_leaves_a_checkpoint(here: Path) -> None:
    """R10: fifty interruptions at different moments: at most two seconds, and a checkpoint that is taken up."""
    for number in range(50):
        with started("--set", "run.stop_when_expelled=false", "--overwrite") as process:
            time.sleep(0.02 * number)
            begin = time.monotonic()
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)
            assert process.returncode == 130
            assert time.monotonic() - begin < 2.0
        assert ps.Simulation.resume("out/baseline").time >= 2.0


def interrupted(*_: object, **__: object) -> None:
    """What Ctrl-C does to a function."""
    raise KeyboardInterrupt


def test_interrupted_before_the_first_step(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr("peristalsis.running.simulation.warm_up", interrupted)
    assert main(["run", "baseline", *SET, "--json"]) == 130
    said = capsys.readouterr()
    assert json.loads(said.out) == {
        "scenario": "baseline",
        "status": "interrupted",
        "error": "interrupted; nothing was written",
    }
    assert "Traceback" not in said.err
    assert contents(here) == set()


def test_interrupted_while_drawing_keeps_the_numbers(
    here: Path, at_once: Result, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr(Plots, "save", interrupted)
    assert main(["run", "baseline", "--json"]) == 130
    said = capsys.readouterr()
    assert json.loads(said.out) == json.loads((here / "out/baseline" / SUMMARY_FILE).read_text())
    assert said.err == "warning: interrupted while drawing; the numbers are saved in out/baseline\n"
    assert contents(here / "out/baseline") == NUMBERS


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_writing_is_not_cut_in_two(
    number: signal.Signals, here: Path, at_once: Result, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    def signalled(*words: Any) -> bytes:
        os.kill(os.getpid(), number)
        return netcdf_image(*words)

    before = signal.getsignal(number)
    monkeypatch.setattr("peristalsis.results.result.netcdf_image", signalled)
    assert main(["run", "baseline"]) == 130
    assert contents(here / "out") == {"baseline"}
    assert contents(here / "out/baseline") == NUMBERS
    assert "interrupted while drawing" in capsys.readouterr().err
    assert signal.getsignal(number) is before


def test_a_second_signal_gives_up_writing_and_cleans_up(
    here: Path, at_once: Result, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    def twice(*words: Any) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("peristalsis.results.result.netcdf_image", twice)
    assert main(["run", "baseline"]) == 130
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert contents(here) == set()


def test_sigterm_ends_any_command_quietly(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def ended() -> tuple[str, ...]:
        os.kill(os.getpid(), signal.SIGTERM)
        return ()

    monkeypatch.setattr(scenarios, "names", ended)
    assert main(["list", "--json"]) == 130
    said = capsys.readouterr()
    assert json.loads(said.out)["status"] == "interrupted"
    assert said.err == "interrupted\n"


# --- what cannot be written -------------------------------------------------------------------------


def test_a_full_disk_leaves_the_target_as_it_was(
    here: Path, at_once: Result, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    assert main(["run", "baseline", "--no-plots"]) == 0
    old = {path.name: path.read_bytes() for path in (here / "out/baseline").iterdir()}
    capsys.readouterr()
    monkeypatch.setattr(disk.DISK, "put", no_space)
    assert main(["run", "baseline", "--no-plots", "--overwrite", "--json"]) == 4
    said = capsys.readouterr()
    content = json.loads(said.out)
    assert content["status"] == "write_failed"
    assert "out/baseline" in content["error"]
    assert "No space left on device" in content["error"]
    assert content["simulated_s"] == at_once.summary["simulated_s"]
    assert said.err == f"error: {content['error']}\n"
    assert contents(here / "out") == {"baseline"}
    assert {path.name: path.read_bytes() for path in (here / "out/baseline").iterdir()} == old


def test_errors_of_the_file_library_are_write_errors(
    here: Path, at_once: Result, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    def close(*_: object, **__: object) -> None:
        raise RuntimeError("can't close file")

    monkeypatch.setattr(Result, "save", close)
    assert main(["run", "baseline", "--json"]) == 4
    assert json.loads(capsys.readouterr().out)["status"] == "write_failed"


def test_a_full_disk_is_noticed_before_the_run(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr("tempfile.TemporaryFile", no_space)
    assert main(["run", "baseline", *SET]) == 4
    assert "No space left on device" in capsys.readouterr().err
    assert contents(here) == set()


@pytest.mark.parametrize("words", [["list"], ["--help"], ["schema"], ["list", "--json"]], ids=" ".join)
def test_a_reader_that_went_away_is_no_error(words: list[str]) -> None:
    command = [sys.executable, "-m", "peristalsis", *words]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)
    assert process.stdout is not None
    process.stdout.close()
    process.stdout = None
    _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_output_that_is_lost_is_a_write_error() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "peristalsis", "version"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT,
        )
    assert done.returncode == 4
    assert done.stderr == "error: standard output could not be written: No space left on device\n"


def test_a_stream_falls_silent_once() -> None:
    class Gone(io.StringIO):
        def write(self, text: str) -> int:
            raise BrokenPipeError

    stream = ForgivingStream(Gone())
    assert stream.write("words") == 5
    assert stream.write("more") == 4
    stream.flush()
    assert isinstance(stream.error, BrokenPipeError)


def test_an_unforeseen_error_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def broken() -> tuple[str, ...]:
        raise TypeError("two\nlines")

    monkeypatch.setattr(scenarios, "names", broken)
    monkeypatch.delenv("PERISTALSIS_TRACEBACK", raising=False)
    assert main(["list", "--json"]) == 1
    said = capsys.readouterr()
    assert json.loads(said.out)["status"] == "failed"
    assert said.err.count("\n") == 1
    assert "unforeseen TypeError: two lines" in said.err
    monkeypatch.setenv("PERISTALSIS_TRACEBACK", "1")
    with pytest.raises(TypeError):
        main(["list"])


# --- what there is ----------------------------------------------------------------------------------


def answer(words: list[str], capsys: Capture) -> Any:
    """The JSON object of a command, and the same command for a person succeeds as well."""
    assert main(words) == 0
    assert capsys.readouterr().out.strip()
    assert main([*words, "--json"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    return json.loads(said.out)


def test_list(capsys: Capture) -> None:
    content = answer(["list"], capsys)
    assert [each["name"] for each in content["scenarios"]] == list(scenarios.names())
    assert [each["name"] for each in content["readings"]] == ["tight", "stretched", "printed", "edge"]
    assert all(each["expected"] and each["title"] for each in content["scenarios"])


def test_show(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    words = ["show", "segmentation", "--set", "pellet.radius=8 mm"]
    content = answer(words, capsys)["parameters"]
    assert content["pellet.radius"]["text"] == "0.8 cm"
    assert content["pellet.radius"]["tag"] == "set by user"
    assert content["rings.enabled"]["tag"] == "set by scenario"
    assert content["pellet.dry_friction"]["printed"] == "20 N"
    assert list(answer([*words, "lumen"], capsys)["parameters"]) == [
        "lumen.pressure",
        "lumen.adiabatic_exponent",
    ]
    assert list(answer([*words, "lumen.pressure"], capsys)["parameters"]) == ["lumen.pressure"]
    main(["show", "baseline", "pellet.dry_friction"])
    row = capsys.readouterr().out.splitlines()[-3:]
    assert re.search(r"pellet.dry_friction +20.0 mN +printed +20 N", "\n".join(row))


def test_shown_toml_is_a_valid_file(here: Path, capsys: Capture) -> None:
    assert main(["show", "pendular", "--reading", "printed", "--toml"]) == 0
    Path("my.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    content = answer(["validate", "my.toml"], capsys)
    assert content.pop("stored_bytes") == pytest.approx(8 * 1002 * (12 * 651 + 4 * 700), rel=0.02)
    assert content == {
        "scenario": "pendular",
        "reading": "printed",
        "status": "valid",
        "changed": [],
        "digest": scenarios.configuration("pendular", reading="printed").digest(),
    }


def test_validate_names_what_is_changed(here: Path, capsys: Capture) -> None:
    Path("my.toml").write_text("[pellet]\nradius = '0.8 cm'\n", encoding="utf-8")
    assert answer(["validate", "my.toml"], capsys)["changed"] == ["pellet.radius"]


def test_schema(capsys: Capture) -> None:
    assert answer(["schema"], capsys)["title"] == "peristalsis configuration"


def test_cite_counts_every_number_once(runs: Path, capsys: Capture) -> None:
    content = answer(["cite", "segmentation"], capsys)
    keys = [key for listed in content["sources"].values() for key in listed]
    assert len(keys) == len(set(keys)) == len(list(scenarios.configuration().items()))
    assert any("Plant" in source for source in content["sources"])
    assert "rings.enabled" in content["sources"]["set by scenario"]
    stored = answer(["cite", str(runs / "second")], capsys)
    assert "lumen.pressure" in stored["sources"]["set by user"]


def test_version(capsys: Capture) -> None:
    content = answer(["version"], capsys)
    assert content["peristalsis"] == ps.__version__
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith(f"peristalsis {ps.__version__}, ")


# --- stored runs ------------------------------------------------------------------------------------


def test_plot(runs: Path, here: Path, capsys: Capture) -> None:
    words = ["plot", str(runs / "first"), "track", "track", "--format", "svg", "--out", "figures"]
    assert answer(words, capsys)["files"] == ["figures/track.svg"]
    assert contents(here / "figures") == {"track.svg"}
    assert main(["plot", str(runs / "first"), "trakc"]) == 2
    assert "did you mean track?" in capsys.readouterr().err


def test_film_and_export(runs: Path, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr(Plots, "film", lambda plots, path, frames, rate: path.write_bytes(b"GIF89a"))
    words = ["film", str(runs / "first"), "--out", "a.gif"]
    assert main(words) == 0
    assert main(words) == 4
    assert "'a.gif' exists" in capsys.readouterr().err
    assert main([*words, "--overwrite"]) == 0

    def export_csv(result: Result, folder: Path, *more: object) -> list[Path]:
        folder.mkdir(exist_ok=True)
        (folder / "track.csv").write_text(str(result.summary["steps"]))
        return [folder / "track.csv"]

    monkeypatch.setitem(
        sys.modules, "peristalsis.plots.export", SimpleNamespace(export_csv=export_csv, export_vtk=None)
    )
    capsys.readouterr()
    assert main(["export", str(runs / "first"), "--out", "tables", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["files"] == ["tables/track.csv"]
    assert contents(here / "tables") == {"track.csv"}
    assert main(["export", str(runs / "first"), "--out", "tables"]) == 4
    several = ["--field", "radius", "--field", "axial_position"]
    assert main(["export", str(runs / "first"), "--out", "maps", *several]) == 0, "an option of several values"


def test_compare(runs: Path, here: Path, capsys: Capture) -> None:
    folders = [str(runs / "first"), str(runs / "second")]
    content = answer(["compare", *folders], capsys)
    assert contents(here) == set()
    assert [run["name"] for run in content["runs"]] == ["first", "second"]
    assert content["changed"] == {"lumen.pressure": ["0.1 kPa", "0.2 kPa"]}
    pressures = content["numbers"]["max_lumen_pressure_kPa"]
    assert pressures[0] < 0.15 < pressures[1]
    assert main(["compare", *folders, "--out", "both", "--json"]) == 0
    drawn = json.loads(capsys.readouterr().out)
    assert drawn["pictures"] == ["both/tracks.png", "both/diameter_difference.png"]
    assert contents(here / "both") == {"comparison.json", "tracks.png", "diameter_difference.png"}
    stored = json.loads((here / "both/comparison.json").read_text())
    assert {**stored, "pictures": drawn["pictures"]} == drawn
    assert main(["compare", *folders, "--out", "both"]) == 4


def test_labels_tell_runs_apart() -> None:
    assert labels(["out/a", "out/b/"]) == ["a", "b"]
    assert labels(["one/a", "two/a", "b"]) == ["one/a", "two/a", "b"]
    with pytest.raises(ConfigurationError, match="twice"):
        labels(["out/a", "out/a"])


Make = Callable[[np.ndarray, np.ndarray, float], Result]


@pytest.fixture
def made(result: Result) -> Make:
    """Make a result whose radius is bilinear in time and place, on any grid."""

    def make(time: np.ndarray, z: np.ndarray, slope: float) -> Result:
        radius = 1.0 + slope * time[:, None, None] * z[None, :, None]
        return replace(result, arrays={**result.arrays, "time": time, "z": z, "radius": radius})

    return make


def test_difference_of_diameter_maps_is_exact_for_bilinear_maps(made: Make) -> None:
    first = made(np.linspace(0.0, 3.0, 7), np.linspace(0.0, 10.0, 11), 0.1)
    second = made(np.linspace(0.0, 2.0, 10), np.linspace(0.0, 8.0, 33), 0.3)
    time, z, difference = comparing.diameter_difference(first, second)
    np.testing.assert_array_equal(time, np.linspace(0.0, 2.0, 5))  # what both have, on the grid of the first
    np.testing.assert_array_equal(z, np.arange(9.0))
    np.testing.assert_allclose(difference, 2.0 * 0.2 * time[:, None] * z[None, :], rtol=1e-13, atol=1e-13)
    assert not comparing.diameter_difference(first, first)[2].any()


def test_runs_without_common_time_have_no_difference(made: Make, tmp_path: Path) -> None:
    z = np.linspace(0.0, 10.0, 11)
    first, second = made(np.array([0.0, 1.0]), z, 0.1), made(np.array([0.0]), z, 0.1)
    with pytest.raises(ConfigurationError, match=r"output\.interval"):
        comparing.diameter_difference(first, second)
    written, left_out = comparing.draw({"a": first, "_$b": second}, tmp_path)
    assert [path.name for path in written] == ["tracks.png"]
    assert len(left_out) == 1


# --- small parts ------------------------------------------------------------------------------------


def test_number_text() -> None:
    assert number_text(None, "cm") == "-"
    assert number_text(4.1666667, "cm/s") == "4.167 cm/s"
    assert number_text(4.1666667, "mm/s", 10.0) == "41.67 mm/s"
    assert number_text(25, "1") == "25"


def test_paths_stay_on_one_line() -> None:
    assert spelled(Path("out/run")) == "out/run"
    assert "\n" not in spelled("two\nlines")


def test_every_number_of_a_summary_can_be_shown(result: Result) -> None:
    known = {number.key.partition(".")[0] for number in comparing.NUMBERS}
    words = {"scenario", "reading", "status", "error", "version"}
    about_waves = {"speed_reason", "speed_residual", "speed_residual_s", "speed_cells"}
    counts = {"waves", "waves_retrograde", "waves_standing", "waves_spontaneous"}
    assert set(result.summary) - known == words | counts | {f"wave_{name}" for name in about_waves}


def test_progress_on_a_terminal_is_a_bar() -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    with redirect_stderr(terminal), RunProgress(Screen(json=False), 1.0, True) as progress:
        progress.see(0.0, 1.2)  # before the start, nothing is shown
        progress.start()
        for step in range(11):
            progress.see(0.1 * step, 1.2)
    assert "pellet at 1.20 cm" in terminal.getvalue()
    assert "running" in terminal.getvalue()


def test_progress_without_pellet_names_none(capsys: Capture) -> None:
    with RunProgress(Screen(json=False), 1.0, False) as progress:
        progress.start()
        progress.see(1.0, 0.0)
    assert capsys.readouterr().err.splitlines()[-1] == "100 %  t = 1 of 1 s"


@pytest.mark.parametrize("words", [["--set", "pellet.radius=8 mm"], ["--reading", "tight"]])
def test_a_stored_run_is_cited_as_it_was(runs: Path, capsys: Capture, words: list[str]) -> None:
    folder = str(runs / "second")
    assert answer(["cite", folder], capsys)["scenario"] == "baseline"
    assert main(["cite", folder, *words]) == 2
    assert "a stored run cannot be changed; leave out the options" in capsys.readouterr().err


def test_regions_are_shown_and_counted_as_changes(here: Path, capsys: Capture) -> None:
    region = "[[regions]]\nname = 'weak'\nshape = 'band'\nz_from = '2 cm'\nz_to = '3 cm'\nactive = 0.5\n"
    Path("my.toml").write_text(region, encoding="utf-8")
    assert answer(["validate", "my.toml"], capsys)["changed"] == ["regions"]
    assert main(["show", "baseline", "--config", "my.toml"]) == 0
    shown = capsys.readouterr().out
    assert "region and what it multiplies" in shown
    assert "weak" in shown.split("region and what it multiplies")[1]
    assert main(["show", "baseline", "pellet", "--config", "my.toml"]) == 0
    assert "region and what it multiplies" not in capsys.readouterr().out


def test_runs_without_pellets_have_no_tracks(result: Result) -> None:
    bare = replace(result, configuration=result.configuration.with_changes({"pellet.enabled": False}))
    labels = [line.get_label() for line in comparing.tracks_figure({"a": result, "b": bare}).axes[0].lines]
    assert labels == ["a"]
    with pytest.raises(ConfigurationError, match="none of the runs has a pellet"):
        comparing.tracks_figure({"b": bare})


def test_ctrl_c_outside_of_every_guard_is_an_interruption(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(words: list[str]) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr("peristalsis.cli.dispatch.dispatch", interrupted)
    assert main(["list"]) == 130


def test_memory_that_runs_out_is_said(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def full(*_: object) -> int:
        raise MemoryError

    monkeypatch.setattr(scenarios, "names", full)
    assert main(["list"]) == 1
    assert "not enough memory; use fewer cells" in capsys.readouterr().err


def test_maps_of_regions_are_told_apart_by_their_values() -> None:
    """In a few words and a digest, which changes with any value."""
    table = {"name": "graded", "shape": "map", "quantities": ["active"], "z": ["2 cm", "4 cm"], "angle": ["0 deg"]}
    words = [
        comparing._in_words(ps.Configuration(regions=[table | {"values": [[1.0], [value]]}]))["regions"]
        for value in (0.5, 0.6, 0.5)
    ]
    assert words[0] == words[2] != words[1]
    assert re.search(r"graded.*\(sha256 [0-9a-f]{12}\)$", words[0])


# --- what a command loads ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "words", [["list"], ["list", "cells"], ["show", "baseline"], ["schema"], ["cite", "baseline"], ["map", "--help"]]
)
def test_commands_that_compute_nothing_never_load_the_compiler(words: list[str]) -> None:
    """Nor units of pint, tables of xarray, matplotlib."""
    program = (
        f"import sys; from peristalsis.cli import main; code = main({words!r});"
        "heavy = {'numba', 'llvmlite', 'matplotlib', 'xarray', 'pint', 'scipy', 'h5py'};"
        "print(sorted(heavy & set(sys.modules)), code, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=ENVIRONMENT)
    assert done.stderr.splitlines()[-1] == "[] 0"


def test_help_reads_the_options_of_no_command(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """And is what it is with all of them; a command that is named is read alone."""
    from typer.main import get_command

    from peristalsis.cli import commands, dispatch

    with pytest.raises(SystemExit):
        get_command(commands.app).main(["--help"], prog_name="peristalsis")
    whole = capsys.readouterr().out
    outline = get_command(dispatch._needed(commands.app, ["--help"]))
    assert all(not [one for one in command.params if one.name != "help"] for command in outline.commands.values())
    assert main(["--help"]) == 0
    assert capsys.readouterr().out == whole
    assert list(get_command(dispatch._needed(commands.app, ["run", "--help"])).commands) == ["run"]
    assert dispatch._needed(commands.app, ["no-such-command"]) is commands.app
    assert dispatch._needed(commands.app, ["cell", "--help"]) is commands.app


def test_a_run_imports_little(tmp_path: Path) -> None:
    """Modules that a stored run without pictures has no use for."""
    program = (
        "import sys; from peristalsis.cli import main;"
        "code = main(['run', 'baseline', '--no-plots', '--set', 'run.duration=10 ms', '--set', 'grid.n_z=200',"
        f"'--set', 'grid.n_z_wall=100', '--out', {str(tmp_path / 'run')!r}]);"
        "heavy = {'scipy.linalg', 'numba.np.linalg', 'matplotlib', 'xarray', 'h5netcdf', 'pandas'};"
        "print(sorted(heavy & set(sys.modules)), code, file=sys.stderr)"
    )
    warm_up()  # or the run compiles, for which numba loads all it has
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=ENVIRONMENT)
    assert done.stderr.splitlines()[-1] == "[] 0"


def test_warm_up_says_what_is_ready(capsys: Capture) -> None:
    warm_up()
    assert main(["warm-up", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["kernels"] >= answer["compiled"]
    assert main(["warm-up"]) == 0
    assert re.match(r"\d+ kernels are ready after \d+\.\d s; ", capsys.readouterr().out)
    assert main(["warm-up", "nonsense"]) == 2


@pytest.mark.parametrize(
    "option", [["--figure", "3"], ["--no-searches"], ["--variant", "doubled"], ["--coarse"], ["--reading", "all"]]
)
def test_what_a_search_has_no_use_for_is_refused(option: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["paper", "--search", *option, "--out", "o"]) == 2
    said = f"error: {' '.join(option) if option[0] == '--reading' else option[0]}: a search has its own runs"
    assert capsys.readouterr().err.startswith(said)


def test_no_address_is_not_every_address(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("uvicorn")
    assert main(["app", "--host", " ", "--no-browser", "--port", "0"]) == 2
    assert capsys.readouterr().err == "error: --host is empty; give an address of this machine, or leave it out\n"
