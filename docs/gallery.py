"""Make the pictures of gallery.md anew, by the commands that stand in it."""

import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

WIDTH = 900  # pixels
HERE = Path(__file__).resolve().parent


def main() -> None:
    """Run every command in a folder of its own and keep the pictures that the page shows."""
    text = (HERE / "gallery.md").read_text(encoding="utf-8")
    wanted = re.findall(r"\]\(gallery/(\S+)\)", text)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "inputs").symlink_to(HERE.parent / "inputs")
        for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL):
            for line in block.splitlines():
                words = shlex.split(line)
                program = [sys.executable, "-m", "sitedda", *words[1:]]
                subprocess.run(program, cwd=folder, check=True)
        for name in wanted:
            shrink(Path(folder) / name, HERE / "gallery" / name)


def shrink(source: Path, target: Path) -> None:
    """Keep a picture as wide as a page shows it."""
    with Image.open(source) as picture:
        small = picture.convert("RGB")
        if small.width > WIDTH:
            small = small.resize((WIDTH, round(small.height * WIDTH / small.width)))
        small.save(target, optimize=True)


if __name__ == "__main__":
    main()
