# SPDX-License-Identifier: GPL-3.0-or-later
"""Written files: only files of the program are replaced; files are complete or not written."""

import json
import os
import re
import resource
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from environment import DEADLINE, captured, executable
from model_text import changed, namelist, tower
from test_command import NEVER_ENDING

import sitedda
from sitedda.errors import InputError, OutputError
from sitedda.files import check_target, write, written
from sitedda.report.style import Figure, save_picture
from sitedda.study import collect
from sitedda.study.plan import make_plan
from sitedda.study.settings import read_settings
from sitedda.study.slurm import Slurm, write_batch

PRECIOUS = b"precious\n"
SIDE_FILES = ("journal", "writing", "partial", "checkpoint", "checkpoint.previous",
              "checkpoint.coming")  # fmt: skip


@pytest.fixture
def workdir(tmp_path):
    """Return a folder with a model in a watched folder with a file that must not change."""
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "m.nml").write_text(namelist(changed(tower(steps=5), "output", file="o.nc")))
    (tmp_path / "victim").write_bytes(PRECIOUS)
    return folder


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Return the output of a run with several frames."""
    file = tmp_path_factory.mktemp("finished") / "m.nml"
    file.write_text(namelist(changed(tower(steps=20), "output", block_interval=5)))
    sitedda.run(file, file.with_name("o.nc"))
    return file.with_name("o.nc")


def refused(process, *phrases) -> None:
    """Check that a command printed one line, without traceback, and failed."""
    assert process.returncode in (1, 5), (process.stdout, process.stderr)
    assert process.stderr.count("\n") == 1, process.stderr
    for phrase in phrases:
        assert phrase in process.stderr


WALL = """&control time_step = 1e-3, steps = 5 /
&material name = 'rock', density = 2e3, young_modulus = 1e9, poisson_ratio = 0.2 /
&joint name = 'bed', friction_angle = 30.0 /
&region name = 'wall', outline = 0, 0, 4, 0, 4, {courses}, 0, {courses} /
&joint_set joint = 'bed', angle = 0.0, spacing = 1.0 /
"""

# --- An output replaces only an output -----------------------------------------------------------


@pytest.mark.parametrize("name", ["victim.nml", "sub/deep.txt"])
def test_an_output_does_not_replace_other_files(program, workdir, name):
    target = workdir / name
    target.parent.mkdir(exist_ok=True)
    target.write_bytes(PRECIOUS)
    text = (workdir / "m.nml").read_text().replace("o.nc", name)
    (workdir / "m.nml").write_text(text)
    refused(program("run", "m.nml", "-q", folder=workdir), name, "not replaced")
    assert target.read_bytes() == PRECIOUS
    assert not list(workdir.glob("*.journal"))


@pytest.mark.parametrize("name", ["../x.nc", "sub/../../x.nc", "{above}/x.nc"])
def test_an_input_names_outputs_in_its_folder_only(binary, main, workdir, name):
    (workdir / "sub").mkdir()
    name = name.format(above=workdir.parent)
    text = (workdir / "m.nml").read_text().replace("o.nc", name)
    (workdir / "m.nml").write_text(text)
    for program in (binary, main):
        refused(program("run", "m.nml", "-q", folder=workdir), "x.nc", "--output")
    assert not (workdir.parent / "x.nc").exists()
    for options in (["-o", "../y.nc"], ["--set", "output.file=../y.nc"]):
        for program in (binary, main):
            program.ok("run", "m.nml", "-q", *options, folder=workdir)
            (workdir.parent / "y.nc").unlink()
    sitedda.run(workdir / "m.nml", True, changes={"output.file": str(workdir.parent / "z.nc")})
    assert (workdir.parent / "z.nc").exists()


@pytest.mark.parametrize("name", ["sub/o.nc", "./o.nc", "{workdir}/o.nc", "link/o.nc", "a..b.nc"])
def test_names_below_the_folder_are_accepted(binary, workdir, name):
    (workdir / "sub").mkdir()
    (workdir / "elsewhere").mkdir()
    (workdir / "link").symlink_to("elsewhere")
    name = name.format(workdir=workdir)
    (workdir / "m.nml").write_text((workdir / "m.nml").read_text().replace("o.nc", name))
    binary.ok("run", "m.nml", "-q", folder=workdir)
    assert (workdir / name).exists()


def test_links_pipes_folders_and_devices_are_not_replaced(binary, main, workdir):
    (workdir / "link.nc").symlink_to("../victim")
    (workdir / "nowhere.nc").symlink_to("../nothing")
    os.mkfifo(workdir / "pipe.nc")
    (workdir / "folder.nc").mkdir()
    names = ["link.nc", "nowhere.nc", "pipe.nc", "folder.nc"]
    if os.geteuid() == 0:
        os.mknod(workdir / "null.nc", 0o600 | 0o020000, os.makedev(1, 3))
        names.append("null.nc")
    before = {name: standing(workdir / name) for name in names}
    for name in names:
        for command in (binary, main):
            refused(command("run", "m.nml", "-q", "-o", name, folder=workdir), name)
        refused(main("view", "m.nml", "--no-open", "-o", name, folder=workdir), name)
        assert standing(workdir / name) == before[name]
    assert (workdir.parent / "victim").read_bytes() == PRECIOUS
    assert not (workdir.parent / "nothing").exists()


def standing(file: Path) -> tuple:
    """Return type and content of a path."""
    status = os.lstat(file)
    return status.st_mode, status.st_ino, status.st_rdev, status.st_size


def test_a_device_is_not_replaced_by_root(main, workdir):
    before = os.lstat("/dev/null")
    process = main("view", "m.nml", "--no-open", "-o", "/dev/null", folder=workdir)
    refused(process, "/dev/null")
    refused(main("run", "m.nml", "-q", "-o", "/dev/null", folder=workdir), "/dev/null")
    assert os.lstat("/dev/null").st_rdev == before.st_rdev


@pytest.mark.parametrize("ending", SIDE_FILES)
def test_companion_files_are_not_written_through_links(binary, main, workdir, ending):
    side = workdir / f"o.nc.{ending}"
    for make in (lambda: side.symlink_to("../victim"), lambda: os.link("victim", side),
                 lambda: side.write_bytes(PRECIOUS)):  # fmt: skip
        os.chdir(workdir.parent)
        make()
        for command in (binary, main):
            refused(command("run", "m.nml", "-q", folder=workdir), f"o.nc.{ending}")
        assert side.read_bytes() == (workdir.parent / "victim").read_bytes() == PRECIOUS
        side.unlink()
    assert sorted(os.listdir(workdir)) == ["m.nml"]


def test_remains_of_a_killed_run_are_replaced(binary, workdir):
    """Empty files, blocks of zeros, and files of the program."""
    for ending in SIDE_FILES:
        (workdir / f"o.nc.{ending}").write_bytes(b"" if ending == "journal" else bytes(4096))
    binary.ok("run", "m.nml", "-q", folder=workdir)
    assert sorted(os.listdir(workdir)) == ["m.nml", "o.nc"]
    binary.ok("run", "m.nml", "-q", folder=workdir)


def test_an_output_does_not_replace_a_file_that_is_read_under_another_name(main, workdir):
    blocks = [{"vertices": [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]}]
    from sitedda.block_file import write_block_file

    file = write_block_file(workdir / "blocks.nc", blocks)
    os.link(file, workdir / "other.nc")
    model = sitedda.Model(time_step=1e-3, steps=2)
    model.material("rock", density=2e3, young_modulus=1e9, poisson_ratio=0.2)
    model.joint("bed", friction_angle=30.0)
    model.blocks("blocks.nc")
    model.folder = workdir
    model.write(workdir / "b.nml")
    for name in ("blocks.nc", "other.nc"):
        refused(main("run", "b.nml", "-q", "-o", name, folder=workdir), "block file")
    file.rename(workdir / "o.nc.partial")
    text = (workdir / "b.nml").read_text().replace("blocks.nc", "o.nc.partial")
    (workdir / "b.nml").write_text(text)
    refused(main("run", "b.nml", "-q", "-o", "o.nc", folder=workdir), "o.nc.partial", "block file")


# --- Pages, pictures, movies ---------------------------------------------------------------------


@pytest.mark.parametrize("command", ["view", "report", "draw", "movie", "site", "surface"])
def test_no_command_replaces_the_file_that_it_reads(main, workdir, finished, command):
    shutil.copy(finished, workdir / "o.nc")
    shutil.copy(finished, workdir / "o.png")  # named like a picture
    (workdir / "o.gif").write_bytes(PRECIOUS)
    before = {file.name: file.read_bytes() for file in workdir.iterdir()}
    options = ["--no-open"] if command == "view" else []
    sources = ["o.nc"] if command in ("movie", "surface", "site") else ["o.nc", "m.nml"]
    for source in sources:
        for target in {source, "o.gif" if command == "movie" else "o.png"}:
            process = main(command, source, "-o", target, *options, folder=workdir)
            assert process.returncode in (1, 5) and "Traceback" not in process.stderr
    assert {file.name: file.read_bytes() for file in workdir.iterdir()} == before


def test_files_of_a_kind_replace_each_other(main, workdir, finished):
    for name, command in (("v.html", "view"), ("d.png", "draw"), ("r.html", "report")):
        for _ in range(2):
            options = ["--no-open"] if command == "view" else []
            main.ok(command, finished, "-o", workdir / name, *options)
    main.ok("view", "m.nml", "--no-open", "-o", "r.html", folder=workdir)
    for ending in ("svg", "pdf", "jpg"):
        for _ in range(2):
            main.ok("draw", finished, "-o", workdir / f"d.{ending}")
    for _ in range(2):
        main.ok("export", finished, "--vtk", workdir / "vtk")


def test_inputs_of_the_user_are_not_replaced(main, workdir):
    (workdir / "wall.nml").write_text(WALL.format(courses=2))
    (workdir / "column.nml").write_text(WALL.format(courses=3))
    hand = workdir / "mine.nml"
    hand.write_text("! my own\n&run title = 'mine' /\n")
    before = hand.read_bytes()
    refused(main("build", "wall.nml", "-o", "mine.nml", folder=workdir), "mine.nml")
    with pytest.raises(OutputError, match="not replaced"):
        sitedda.Model.read(workdir / "wall.nml").write(hand)
    assert hand.read_bytes() == before
    for _ in range(2):  # files of the program may be replaced by other content
        main.ok("build", "wall.nml", "-o", "built.nml", folder=workdir)
        sitedda.Model.read(workdir / "wall.nml").write(workdir / "model.nml")
    sitedda.Model.read(workdir / "column.nml").write(workdir / "model.nml")
    main.ok("build", "column.nml", "-o", "built.nml", folder=workdir)


@pytest.mark.parametrize("command", ["view", "report", "draw", "movie"])
def test_a_full_disk_leaves_no_file(main, workdir, finished, command):
    name = {"draw": "x.png", "movie": "x.gif"}.get(command, "x.html")
    options = ["--no-open"] if command == "view" else []
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, limits[1]))
    try:
        process = main(command, finished, "-o", name, *options, folder=workdir)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert process.returncode == 5
    assert f"{name} cannot be written: File too large" in process.stderr
    assert sorted(os.listdir(workdir)) == ["m.nml"]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_signal_leaves_no_file(workdir, number):
    class Slow(Figure):
        def savefig(self, file, **_):
            Path(file).write_bytes(b"half")
            os.kill(os.getpid(), number)
            time.sleep(5)

    (workdir / "x.png").write_bytes(b"")
    interrupts = signal.signal(signal.SIGINT, signal.default_int_handler)
    hangups = signal.signal(signal.SIGHUP, signal.SIG_DFL)  # nohup ignores it
    with pytest.raises((sitedda.errors.InterruptedRun, KeyboardInterrupt)):
        save_picture(Slow(), workdir / "x.png")
    assert (workdir / "x.png").read_bytes() == b""
    assert sorted(os.listdir(workdir)) == ["m.nml", "x.png"]
    signal.signal(signal.SIGINT, interrupts)
    signal.signal(signal.SIGHUP, hangups)
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_written_files_have_the_usual_permissions_and_kind(workdir):
    page = write(workdir / "p.html", "<!DOCTYPE html><p>1", "a page")
    assert page.stat().st_mode & 0o777 == 0o666 & ~umask()
    write(page, "<!doctype html><p>2", "a page")
    with pytest.raises(OutputError, match="is not a picture"):
        write(page, b"", "a picture")
    with (
        pytest.raises(OutputError, match="has been|is a symbolic link"),
        written(page, "a page") as beside,
    ):
        beside.write_text("<!doctype html>")
        page.unlink()
        page.symlink_to("../victim")
    assert page.is_symlink() and (workdir.parent / "victim").read_bytes() == PRECIOUS
    with pytest.raises(OutputError, match="does not exist"):
        check_target(workdir / "no" / "p.html", "a page")


def test_permissions_follow_the_present_umask(workdir):
    """An earlier umask of the process has no effect."""
    before = os.umask(0o077)
    write(workdir / "a.html", "<!doctype html>", "a page")
    os.umask(0o002)
    write(workdir / "b.html", "<!doctype html>", "a page")
    os.umask(before)
    modes = [(workdir / name).stat().st_mode & 0o777 for name in ("a.html", "b.html")]
    assert modes == [0o600, 0o664]


def test_write_protected_files_are_not_replaced(workdir, program):
    page = write(workdir / "p.html", "<!doctype html>", "a page")
    page.chmod(0o444)
    with pytest.raises(OutputError, match="write-protected"):
        write(page, "<!doctype html><p>", "a page")
    program.ok("run", "m.nml", "-q", "-o", "o.nc", folder=workdir)
    (workdir / "o.nc").chmod(0o444)
    content = (workdir / "o.nc").read_bytes()
    process = program("run", "m.nml", "-q", "-o", "o.nc", folder=workdir)
    assert process.returncode == 5
    assert "o.nc is write-protected and is not replaced" in process.stderr
    assert (workdir / "o.nc").read_bytes() == content
    assert (workdir / "o.nc").stat().st_mode & 0o777 == 0o444


@pytest.fixture
def shut():
    """Return a read-only folder with a model, and a user without superuser rights."""
    with tempfile.TemporaryDirectory() as name:
        folder, root = Path(name), os.geteuid() == 0
        (folder / "m.nml").write_text(namelist(tower(steps=5)))
        folder.chmod(0o755 if root else 0o555)
        yield folder, {"user": 65534, "group": 65534, "extra_groups": []} if root else {}
        folder.chmod(0o755)


@pytest.mark.parametrize("name", ["sitedda", "sitedda-native"])
@pytest.mark.parametrize("message", [["run", "m.nml", "-q"], ["run", "m.nml", "-q", "-o", "n.nc"]])
def test_a_folder_without_permission_is_reported(shut, name, message):
    folder, user = shut
    if user and name == "sitedda":
        pytest.skip("a superuser's interpreter is seldom open to others")
    options = {"env": os.environ | {"HOME": "/"}, "timeout": DEADLINE, **user}
    process = captured([executable(name), *message], cwd=folder, **options)
    assert process.returncode == 5 and "Permission denied" in process.stderr, process.stderr
    assert len(process.stderr.splitlines()) == 1 and os.listdir(folder) == ["m.nml"]


@pytest.mark.parametrize("host", ["a\u2028b", "../x.png", "a..b"])
def test_an_invalid_host_name_is_refused(main, host):
    process = main("live", "--no-open", "--host", host)
    assert process.returncode == 5 and "host name is invalid" in process.stderr


def umask() -> int:
    """Return the umask of this process."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


# --- Lost companion files ------------------------------------------------------------------------


def test_a_journal_that_was_removed_is_written_again(workdir, same_bits):
    (workdir / "m.nml").write_text(namelist(changed(tower(steps=40), "output", file="o.nc")))
    reference = sitedda.run(workdir / "m.nml", workdir / "whole.nc")
    with sitedda.Simulation(workdir / "m.nml", workdir / "o.nc") as run:
        run.advance(10)
        for file in workdir.glob("o.nc.*"):
            file.unlink()
        run.advance(5)
        run.checkpoint()
        assert (workdir / "o.nc.journal").exists() and (workdir / "o.nc.checkpoint").exists()
        (workdir / "o.nc.journal").unlink()
    with xr.open_dataset(workdir / "o.nc.partial", engine="netcdf4") as partial:
        assert partial.sizes["time"] == 16
    sitedda.resume(workdir / "m.nml", workdir / "o.nc")
    same_bits(workdir / "o.nc", reference.output)
    with sitedda.Simulation(workdir / "m.nml", workdir / "o.nc") as run:
        run.advance(40)
        (workdir / "o.nc.journal").unlink()
    same_bits(workdir / "o.nc", reference.output)


def test_a_journal_that_was_replaced_is_an_error(workdir):
    with sitedda.Simulation(workdir / "m.nml", workdir / "o.nc") as run:
        run.advance(2)
        (workdir / "o.nc.journal").unlink()
        (workdir / "o.nc.journal").write_bytes(PRECIOUS)
        with pytest.raises(OutputError, match="replaced during the run"):
            run.checkpoint()
    assert (workdir / "o.nc.journal").read_bytes() == PRECIOUS


def test_lost_results_are_not_reported_as_saved(binary, workdir):
    (workdir / "m.nml").write_text(namelist(tower(steps=NEVER_ENDING)))
    folder = workdir / "results"
    folder.mkdir()
    running = subprocess.Popen(
        [binary.path, "run", "m.nml", "-q", "-o", folder / "o.nc"],
        cwd=workdir, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    until = time.monotonic() + DEADLINE
    while not (folder / "o.nc.partial").exists() and time.monotonic() < until:
        time.sleep(0.02)
    shutil.move(folder, workdir / "moved")
    running.send_signal(signal.SIGTERM)
    _, output = running.communicate(timeout=DEADLINE)
    assert running.returncode == 5, output
    assert "o.nc.journal has been removed" in output and "results so far" not in output
    assert output.count("\n") == 1


# --- Studies -------------------------------------------------------------------------------------

STUDY = """model = "m.nml"
results = ["displacement[surface].x.largest"]
[parameters]
"motion.scale" = [1.0, 2.0]
"""


@pytest.mark.parametrize(
    "line",
    [
        'folder = "st\\ntouch PWNED #"',
        'folder = "st\\r\\ntouch PWNED"',
        'table = "t\\n.nc"',
        'slurm = {options = ["--partition=a\\ntouch PWNED"]}',
        'slurm = {program = "x\\ntouch PWNED"}',
        'slurm = {time = "1:00\\ntouch PWNED"}',
        'slurm = {each = "1\\ntouch PWNED"}',
        "slurm = {each = -1}",
        "slurm = {each = inf}",
        "slurm = {memory = nan}",
        'time_limit = ".."',
        "time_limit = nan",
        "time_limit = -1",
        "time_limit = true",
        'memory = "much"',
        "memory = 0",
        "memory = []",
        'folder = "../st"',
        'folder = "/tmp/st"',
        'table = "../t.nc"',
        "folder = 3",
    ],
)
def test_texts_of_a_study_are_not_executed(main, workdir, line):
    (workdir / "s.toml").write_text(f"{line}\n{STUDY}")
    refused(main("study", "plan", "s.toml", folder=workdir), "s.toml")
    assert not list(workdir.rglob("submit.sh"))
    assert sorted(os.listdir(workdir.parent)) == ["here", "victim"]


def test_python_arguments_are_not_executed(workdir):
    plan = make_plan(workdir / "m.nml", {"motion.scale": [1.0]}, folder=workdir / "a\ntouch b")
    with pytest.raises(InputError, match="control character"):
        plan.write()
    plan = make_plan(workdir / "m.nml", {"motion.scale": [1.0]}, folder=workdir / "a $(b) 'c' %j")
    good = plan.write()
    evil = Slurm(executable("sitedda-native"), options=["--comment=x\ntouch PWNED"])
    with pytest.raises(InputError, match="option of sbatch|control character"):
        write_batch(good, evil)
    plain = Slurm(executable("sitedda-native"), options=["--comment=a 'b' $(c) #d"])
    text = write_batch(good, plain).read_text()
    for line in text.splitlines():  # a comment ends with its line
        assert "touch" not in line
    assert "#SBATCH --comment=a\\ \\'b\\'\\ \\$\\(c\\)\\ \\#d\n" in text
    assert "%%j/slurm-%A_%a.log\n" in text


@pytest.mark.parametrize(
    "figure",
    [
        'title = 2\nkind = "map"',
        'kind = "mop"',
        "kind = 3",
        'kind = "fragility"\nquantity = "displacement[surface].x.largest"\nintensity = "scale"',
        'kind = "fragility"\nquantity = "displacement[surface].x.largest"\nintensity = "pga"\n'
        "threshold = 1.0",
        'kind = "fragility"\nquantity = "displacement[surface].x.largest"\nintensity = "scale"\n'
        'threshold = "high"',
        'kind = "fragility"\nquantity = "displacement[surface].x.largest"\nintensity = "scale"\n'
        "threshold = nan",
        'kind = "fragility"\nquantity = "tilt"\nintensity = "scale"\nthreshold = 1.0',
        'kind = "ida"\nquantity = "displacement[surface].x.largest"\nintensity = "scale"\n'
        "select = {phase = 3}",
        'kind = "ida"\nquantity = "displacement[surface].x.largest"\nintensity = "scale"\n'
        "select = {scale = 3.0}",
        'kind = "bands"\nquantity = "displacement[surface].x.largest"\ncolour = "red"',
    ],
)
def test_figures_are_checked_before_the_first_case(main, workdir, figure):
    (workdir / "s.toml").write_text(f"{STUDY}\n[[figures]]\n{figure}\n")
    refused(main("study", "s.toml", "-q", "--report", folder=workdir), "s.toml: figure 1")
    assert not (workdir / "s_study").exists()


def test_a_wrong_change_is_refused_with_the_study(main, workdir):
    (workdir / "s.toml").write_text(STUDY.replace("motion.scale", "motion.scael"))
    refused(main("study", "s.toml", "-q", folder=workdir), "s.toml: case 0: motion.scael")


def test_valid_figures_are_accepted(workdir, root):
    (workdir / "s.toml").write_text(
        f"{STUDY}\n[[figures]]\nkind = 'fragility'\nquantity = 'displacement[surface].x.largest'\n"
        "intensity = 'scale'\nthreshold = 1\nselect = {scale = [1, 2.0]}\n"
    )
    assert len(read_settings(workdir / "s.toml").figures) == 1
    for file in (root / "inputs" / "studies").glob("*.toml"):
        assert len(read_settings(file).figures) == len(re.findall(r"\bkind = ", file.read_text()))


@pytest.mark.parametrize("part", ["model", "dims", "coordinates", "cases", "quantities"])
def test_a_damaged_study_is_refused_with_the_part(main, workdir, part):
    (workdir / "s.toml").write_text(STUDY)
    process = main.ok("study", "plan", "s.toml", "--folder", "st", folder=workdir)
    assert "then: sitedda study collect s.toml --folder st\n" in process.stdout
    manifest = json.loads((workdir / "st" / "study.json").read_text())
    for damaged in (None, 3, [1], {"x": "y"}):
        (workdir / "st" / "study.json").write_text(json.dumps(manifest | {part: damaged}))
        refused(main("study", "collect", "st", "-q", "-o", "t.nc", folder=workdir), part[:-1])
    (workdir / "st" / "study.json").write_text("[" * 100_000)
    refused(main("study", "collect", "st", "-q", "-o", "t.nc", folder=workdir), "study.json")


def test_a_damaged_result_is_missing(main, workdir):
    (workdir / "s.toml").write_text(STUDY)
    command = ["study", "collect", "s.toml", "-q", "-o", "t.nc"]
    main.ok("study", "plan", "s.toml", folder=workdir)
    folder = next((workdir / "s_study" / "cases").glob("*/*"))
    for damaged in ({"numbers": {"x": None}}, {"numbers": [1]}, {"seconds": "x"}, {"status": 1},
                  {"shapes": {"x": {"dims": ["time"], "shape": [-1]}}}):  # fmt: skip
        (folder / "result.json").write_text(json.dumps({"status": "complete"} | damaged))
        process = main(*command, folder=workdir)
        assert process.returncode == 0 and "complete" not in process.stdout, process.stderr


def test_a_table_does_not_replace_other_folders(main, workdir):
    (workdir / "s.toml").write_text(STUDY)
    main.ok("study", "s.toml", "-q", "-w", "1", folder=workdir)
    results = workdir / "results"
    results.mkdir()
    (results / "mine.txt").write_bytes(PRECIOUS)
    shutil.copytree(results, workdir / "results.zarr")
    (workdir / "submit.sh").write_bytes(PRECIOUS)
    for name in ("results", "results.zarr", "m.nml"):
        refused(main("study", "collect", "s.toml", "-q", "-o", name, folder=workdir), name)
    refused(main("study", "plan", "s.toml", "--folder", ".", folder=workdir), "submit.sh")
    assert (results / "mine.txt").read_bytes() == PRECIOUS
    assert (workdir / "results.zarr" / "mine.txt").exists()
    assert (workdir / "submit.sh").read_bytes() == PRECIOUS
    main.ok("study", "collect", "s.toml", "-q", "-o", "../t.nc", folder=workdir)
    assert np.isfinite(collect(workdir / "s_study")["displacement[surface].x.largest"]).all()
