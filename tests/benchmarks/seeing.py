# SPDX-License-Identifier: GPL-3.0-or-later
"""What pictures, report and view cost: python tests/benchmarks/seeing.py [OUTPUT.nc of a run].

Time of the clock and of the processors, since the machine may be busy.  The view is opened in the
system's Chromium with software rendering.  With an output: its picture and its report as well.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import xarray as xr

from sitedda.facade.page import report_page
from sitedda.plot import run_picture
from sitedda.report import write_html
from sitedda.response import amplifications
from sitedda.view import write_view

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
FRAMES = 300
RENDERER = """(() => { const gl = blockViews[0].painter.gl;
  const known = gl.getExtension("WEBGL_debug_renderer_info");
  return gl.getParameter(known ? known.UNMASKED_RENDERER_WEBGL : gl.RENDERER); })()"""
CORNERS = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def rocking(blocks: int, frames: int = FRAMES, seed: int = 1) -> xr.Dataset:
    """Square blocks of 1 m in a wall that shakes, each with some movement of its own."""
    random = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(2 * blocks)))
    number = np.arange(blocks)
    centre = np.column_stack([number % side, number // side]) + 0.5
    time_ = np.arange(frames) / 30.0
    wave = 0.05 * np.sin(2 * np.pi * (time_[:, None] - 0.02 * centre[:, 1]))
    own = np.cumsum(random.normal(scale=2e-4, size=(frames, blocks, 3)), axis=0)
    q = np.zeros((frames, blocks, 6))
    q[..., :2] = centre
    q[..., 0] += wave * centre[:, 1] / centre[:, 1].max()
    q[..., :3] += own
    q[0, :, 2] = 0.0
    q[..., 3:] = 1e-6 * wave[..., None]
    cos, sin = np.cos(q[..., 2, None]), np.sin(q[..., 2, None])
    x, y = CORNERS.T
    turned = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    no_contact = dict.fromkeys(
        ("frame", "vertex", "edge", "state", "bonded", "gap", "normal_force", "shear_force")
    )
    return xr.Dataset(
        {
            "vertices": (
                ("frame", "vertex", "axis"),
                (q[:, :, None, :2] + turned).reshape(frames, -1, 2),
            ),
            "block_coordinates": (("frame", "block", "coordinate"), q),
            "block_rates": (("frame", "block", "coordinate"), np.gradient(q, 1 / 30.0, axis=0)),
            "block_stress": (
                ("frame", "block", "component"),
                -1e5 * (1 + wave[..., None]) * np.array([0.2, 1.0, 0.1]),
            ),
            "frame_time": ("frame", time_),
            "vertex_block": ("vertex", np.repeat(number, 4)),
        }
        | {f"contact_{name}": ("contact", np.zeros(0, dtype=int)) for name in no_contact}
    )


def cpu_of(root: int) -> float:
    """Seconds of the processors that a process and its children have used."""
    parent, spent = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parent[int(folder.name)] = int(words[1])
        spent[int(folder.name)] = (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")

    def below(process: int) -> bool:
        while process in parent and process != root:
            process = parent[process]
        return process == root

    return sum(value for process, value in spent.items() if below(process))


def in_browser(page_file: Path) -> str:
    """First frame, decoding, and frames a second of a page with a view."""
    from environment import ARGUMENTS, BROWSER
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        before = cpu_of(os.getpid())
        page.goto(page_file.as_uri())
        while not page.evaluate("blockViews.every((view) => view.state.decoded)"):
            time.sleep(0.02)
        opened = cpu_of(os.getpid()) - before
        state = page.evaluate("blockViews[0].state")
        before = cpu_of(os.getpid())
        count = 40
        spent = page.evaluate(
            f"""async () => {{ const v = blockViews[0], gl = v.painter.gl, p = new Uint8Array(4);
            const next = () => new Promise(requestAnimationFrame), t = performance.now();
            for (let i = 0; i < {count}; i++) {{ v.show(7 * i % v.model.frames);
              while (!blockViews.every((one) => one.state.frame === v.frame)) await next();
              gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, p); }}
            return (performance.now() - t) / {count}; }}"""
        )
        cpu = (cpu_of(os.getpid()) - before) / count
        renderer = page.evaluate(RENDERER)
        browser.close()
    lines = (
        f"first frame {state['firstFrameMs'] / 1e3:.2f} s",
        f"decoded {state['decodedMs'] / 1e3:.2f} s (processors {opened:.2f} s)",
        f"{1e3 / spent:.1f} frames a second by the clock, {1 / cpu:.1f} of one processor",
        renderer,
    )
    return ", ".join(lines)


def timed(name: str, act):
    """Do it and print its times."""
    clock, cpu = time.perf_counter(), time.process_time()
    result = act()
    clock, cpu = time.perf_counter() - clock, time.process_time() - cpu
    print(f"{name}: {clock:.2f} s by the clock, {cpu:.2f} s of the processor", flush=True)
    return result


def main(output: str | None) -> None:
    """Print a line for each measurement."""
    with tempfile.TemporaryDirectory() as folder:
        for blocks in (1_000, 20_000):
            file = Path(folder) / f"{blocks}.html"
            scene = rocking(blocks)
            name = f"view of {blocks:,} blocks x {FRAMES} frames, written"
            timed(name, lambda file=file, scene=scene: write_view(scene, file))
            print(f"  {file.stat().st_size / 1e6:.1f} MB; {in_browser(file)}", flush=True)
        file = Path(folder) / "two.html"
        one, other = rocking(2_000), rocking(2_000, seed=2)
        for difference in (False, True):
            write_view(one, file, other=other, difference=difference)
            print(f"two runs of 2,000 blocks x {FRAMES} frames, difference: {difference}")
            print(f"  {file.stat().st_size / 1e6:.1f} MB; {in_browser(file)}", flush=True)
        if output:
            data = timed("output read", lambda: xr.open_dataset(output).load())
            found = amplifications(data)
            picture = Path(folder) / "x.png"
            timed("picture", lambda: run_picture(data, found).savefig(picture, dpi=130))
            page = Path(folder) / "x.html"
            timed("report", lambda: write_html(report_page(data), page))
            print(f"  {page.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(*sys.argv[1:2] or [None])
