# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the package: fast import, no accidental names, thread safety."""

import ast
import importlib.metadata
import importlib.util
import re
import sys
import threading
import time
import tomllib
from pathlib import Path

import pytest
from environment import captured
from model_text import namelist, tower

import sitedda

ROOT = Path(__file__).parents[2]
PUBLIC_MODULES = (
    *("cutting", "drawing", "masonry", "pictures", "plot", "response", "scene", "signals"),
    *("site", "study"),
)
HEAVY = ("ezdxf", "matplotlib", "netCDF4", "pandas", "scipy", "shapely", "tqdm", "xarray")


def python(code: str, folder=None) -> str:
    """Return the output of a fresh interpreter."""
    process = captured([sys.executable, "-c", code], cwd=folder)
    assert process.returncode == 0, process.stderr
    return process.stdout.strip()


def test_the_import_and_the_help_need_no_heavy_library():
    code = "import sys, sitedda, sitedda.command as c; {}print(set({}) & set(sys.modules) or '')"
    assert python(code.format("", HEAVY)) == ""
    show = "\ntry: c.main(['--help'])\nexcept SystemExit: print(end='\\n@')\n"
    assert python(code.format(show, HEAVY)).endswith("@")


def test_the_core_runs_with_only_numpy_and_netcdf(tmp_path):
    """Libraries for drawing, building, meshing, serving and clusters are imported on first use."""
    blocked = ("dask", "matplotlib", "PIL", "scipy", "shapely", "tornado", "tqdm", "ezdxf")
    (tmp_path / "model.nml").write_text(namelist(tower(2)))
    code = f"""
import sys
sys.modules |= dict.fromkeys({blocked!r})
import sitedda
from sitedda.commands.command import main
run = sitedda.run("model.nml", output="run.nc")
assert run.complete and run.history.sizes["time"] > 1, run
assert str(run.verdict).startswith("Blocks moved")
with sitedda.Simulation("model.nml") as model:
    model.advance(3)
    assert model.counts["steps"] == 3
assert main(["check", "model.nml"]) in (0, 2)
assert main(["run", "model.nml", "--no-plot", "-q", "-o", "other.nc"]) == 0
ours = {{name.split(".")[1] for name in sys.modules if name.startswith("sitedda.")}}
core = set("_core base input engine output facade commands paths".split())
print("@", *sorted(ours - core))
try:
    run.draw()
except ImportError as missing:
    print(missing.name)
"""
    assert python(code, tmp_path).splitlines()[-2:] == ["@ build drawing", "matplotlib.axes"]


def test_nothing_accidental_is_in_the_package():
    found = [name for name in dir(sitedda) if not name.startswith("__")]
    assert found == sorted([*sitedda.__all__, *PUBLIC_MODULES])
    assert all(getattr(sitedda, name) is not None for name in found)
    star = {}
    exec("from sitedda import *", star)
    assert set(star) - {"__builtins__"} == set(sitedda.__all__)
    with pytest.raises(AttributeError, match="no attribute 'simulate'"):
        sitedda.simulate  # noqa: B018


@pytest.mark.parametrize("name", ["site", "report", "study", "build.cutting"])
def test_names_of_packages_are_listed_before_their_import(name):
    code = f"import sitedda.{name} as p; print(*set(p.__all__) - set(dir(p)))"
    assert python(code).strip() == ""
    code = f"import sitedda.{name} as p; print(all(getattr(p, n) is not None for n in dir(p)))"
    assert python(code).strip() == "True"


def test_commands_of_the_evidence_name_their_package():
    code = "import sys, importlib.metadata as m; m.entry_points = lambda **_: ()\n{}"
    code = code.format("from sitedda.command import main; print(main(['paper', 'layers']))")
    process = captured([sys.executable, "-c", code])
    assert (process.returncode, process.stdout) == (0, "1\n")
    assert process.stderr == (
        "sitedda: sitedda paper needs the distribution sitedda-evidence: in a clone, "
        "pip install ./python/evidence\n"
    )


def test_a_wheel_is_built_for_any_processor():
    args = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["meson-python"]["args"]
    assert "-Dnative_arch=false" in args["setup"]


def test_the_package_is_marked_as_typed():
    assert (Path(sitedda.__file__).parent / "py.typed").exists()


def test_the_package_runs_as_a_module():
    process = captured([sys.executable, "-m", "sitedda", "--version"])
    assert (process.returncode, process.stdout) == (0, f"sitedda {sitedda.__version__}\n")


DRAWING = [f"sitedda.{name}" for name in ("plot", "drawing", "movie", "pictures")]


@pytest.mark.parametrize("module", [*DRAWING, "sitedda_evidence.catalogue"])
def test_drawing_leaves_the_backend_of_matplotlib_alone(module):
    code = f"import matplotlib; matplotlib.use('svg'); import {module}"
    assert python(f"{code}; print(matplotlib.get_backend())") == "svg"
    assert python(f"import sys, {module}; print('matplotlib.pyplot' in sys.modules)") == "False"


def test_every_library_that_is_imported_is_declared():
    for top, folder in ((".", "sitedda"), ("python/evidence", "evidence")):
        project = tomllib.loads((ROOT / top / "pyproject.toml").read_text())["project"]
        optional = project.get("optional-dependencies", {})
        needs = [*project["dependencies"], *sum(optional.values(), [])]
        declared = {re.split("[>=]", need)[0].lower().replace("-", "_") for need in needs}
        assert "numpy" in declared
        _check_imports(ROOT / "python" / folder, declared | {"pil", "mpl_toolkits", "pyoma2"})


def _check_imports(folder: Path, declared: set[str]) -> None:
    """Check that all imported libraries are declared or belong to Python."""
    for file in _modules(folder):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            foreign = {name.split(".")[0] for name in names} - sys.stdlib_module_names
            assert {name.lower() for name in foreign} <= declared, file.name


def test_every_module_is_installed():
    source = {f.relative_to(ROOT / "python" / "sitedda") for f in _modules(ROOT / "python/sitedda")}
    installed = Path(sitedda.__file__).parent
    generated = {Path("input/schema.py"), Path("output/variables.py")}  # at build, from schema.txt
    assert source | generated == {f.relative_to(installed) for f in _modules(installed)}
    evidence = ROOT / "python" / "evidence" / "sitedda_evidence"
    installed = Path(importlib.util.find_spec("sitedda_evidence").origin).parent
    source = {f.relative_to(evidence) for f in _modules(evidence)}
    assert source == {f.relative_to(installed) for f in _modules(installed)}
    assert importlib.util.find_spec("sitedda._core") is not None


def _modules(folder: Path):
    inputs = folder / "inputs"
    return [f for f in folder.rglob("*.py") if inputs not in f.parents]


def test_all_versions_agree():
    """meson.build defines the version of engine and package."""
    build = (ROOT / "meson.build").read_text()
    version = re.search(r"^\s*version: '([\d.]+)'", build, re.MULTILINE)[1]
    assert sitedda.__version__ == version == importlib.metadata.version("sitedda-evidence")
    evidence = tomllib.loads((ROOT / "python" / "evidence" / "pyproject.toml").read_text())
    assert f"sitedda=={version}" in evidence["project"]["dependencies"]
    citation = (ROOT / "CITATION.cff").read_text()
    assert re.findall(r"^version: (.*)$", citation, re.MULTILINE) == [version]
    licence = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["license"]
    assert re.findall(r"^license: (.*)$", citation, re.MULTILINE) == [licence]
    assert f"license: '{licence}'" in build
    changes = re.findall(r"^## \[(.*?)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert changes[:2] == ["Unreleased", version]


# --- Simulation -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["loads", "dynamic_factor", "time", "velocities"])
def test_read_only_attributes_cannot_be_set(write_input, name):
    with sitedda.Simulation(write_input(tower())) as simulation:
        with pytest.raises(AttributeError, match=name):
            setattr(simulation, name, [1.0])


QUESTIONS = {
    "check": sitedda.check,
    "modes": sitedda.modes,
    "transfer": lambda model: sitedda.transfer(model, [1.0, 2.0]),
    "penalty_for": lambda model: sitedda.penalty_for(model, accuracy=0.05),
    "penalty_for_frequency": lambda model: sitedda.penalty_for_frequency(model, 20.0),
    "penalty_for_shift": lambda model: sitedda.penalty_for_shift(model, 5.0),
}


@pytest.mark.parametrize("ask", QUESTIONS.values(), ids=QUESTIONS)
def test_a_check_waits_for_a_thread_that_steps(write_input, ask):
    """The engine releases the interpreter lock during steps, so reads of its state must wait."""
    with sitedda.Simulation(write_input(tower(steps=1_000_000))) as simulation:
        stepping = threading.Event()
        ended = []

        def step():
            with simulation._lock:
                stepping.set()
                simulation.advance(4000)
                ended.append("step")

        thread = threading.Thread(target=step)
        thread.start()
        stepping.wait()
        ask(simulation)
        ended.append("ask")
        thread.join()
        assert ended == ["step", "ask"]
        assert simulation.steps == 4000


class SlowLock:
    """A lock whose owner gives other threads time to acquire other locks."""

    def __init__(self):
        self.lock = threading.Lock()

    def __enter__(self):
        self.lock.acquire()
        time.sleep(0.05)

    def __exit__(self, *_):
        self.lock.release()


def test_a_thread_that_changes_and_one_that_steps_both_end(write_input, tmp_path, monkeypatch):
    """Both need the locks of simulation and files, and must acquire them in the same order."""
    monkeypatch.setattr("sitedda.engine.simulation.FILES", SlowLock())
    simulation = sitedda.Simulation(write_input(tower(steps=1000)), tmp_path / "out.nc")

    def change():
        for i in range(5):
            simulation.change(gravity=(0.0, -1.0 - i))

    def step():
        for _ in range(5):
            simulation.advance(2)

    threads = [threading.Thread(target=act, daemon=True) for act in (change, step)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert not any(thread.is_alive() for thread in threads)
    assert simulation.steps == 10 and simulation.gravity[1] == -5.0


@pytest.mark.parametrize("megabytes", [150, 327, 600])
def test_lack_of_memory_is_one_sentence(monkeypatch, megabytes):
    monkeypatch.syspath_prepend(ROOT / "tests" / "robustness")
    from little_memory import COMMANDS, failures

    names = ("check", "draw") if megabytes == 327 else ("run",)
    commands = {name: COMMANDS[name] for name in names}
    assert failures([megabytes], commands) == []
