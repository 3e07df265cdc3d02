"""Make pictures of pages anew: those of gallery.md by its commands, and those of others."""

import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from sitedda.drawing.pictures import draw
from sitedda.output.scene import Scene
from sitedda.report.layout import Head
from sitedda.report.style import empty_figure, save_picture

WIDTH = 900  # pixels
HERE = Path(__file__).resolve().parent
# Of tutorials, from the runs of the gallery and the inputs.
MORE = """\
sitedda draw arch.nc --color material --contacts force -o arch_forces.png
sitedda draw inputs/slope.nml -o slope_model.png
sitedda draw slope.nc --contacts slip -o slope_slip.png
"""
BUILT = ("slope", "tunnel", "arch", "colonnade", "retaining_wall")  # of building.png


def main() -> None:
    """Run every command in a folder of its own and keep the pictures that the page shows."""
    text = (HERE / "gallery.md").read_text(encoding="utf-8")
    expected = re.findall(r"\]\(gallery/(\S+)\)", text) + re.findall(r"-o (\S+\.png)", MORE)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "inputs").symlink_to(HERE.parent / "inputs")
        for block in [*re.findall(r"```sh\n(.*?)```", text, re.DOTALL), MORE]:
            for line in block.splitlines():
                command = shlex.split(line)
                program = [sys.executable, "-m", "sitedda", *command[1:]]
                subprocess.run(program, cwd=folder, check=True)
        for name in expected:
            shrink(Path(folder) / name, HERE / "gallery" / name)
        building(Path(folder) / "building.png")
        shrink(Path(folder) / "building.png", HERE / "building.png")


def building(file: Path) -> None:
    """Inputs that were built of regions, joint sets and masonry, beside each other."""
    figure = empty_figure((11, 5.8))
    above, below = BUILT[:2], BUILT[2:]
    rows = [[name for name in above for _ in below], [name for name in below for _ in above]]
    for name, axes in figure.subplot_mosaic(rows).items():
        scene = Scene.of(HERE.parent / "inputs" / f"{name}.nml")
        draw(scene, axes=axes, legend=False)
        axes.set_axis_off()
        axes.texts[-1].set_text("")
        Head(axes, f"{name}.nml", [f"{scene.blocks} blocks"])
    save_picture(figure, file, [], dpi=110)


def shrink(source: Path, target: Path) -> None:
    """Keep a picture as wide as a page shows it."""
    with Image.open(source) as picture:
        small = picture.convert("RGB")
        if small.width > WIDTH:
            small = small.resize((WIDTH, round(small.height * WIDTH / small.width)))
        small.save(target, optimize=True)


if __name__ == "__main__":
    main()
