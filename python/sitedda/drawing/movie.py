# SPDX-License-Identifier: GPL-3.0-or-later
"""Movies of blocks: MP4 by ffmpeg, GIF by Pillow."""

import importlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image
from tqdm import tqdm

from ..base.arguments import ANY_NUMBER, PICTURES_A_SECOND, SECONDS
from ..base.errors import InputError, MissingLibrary
from ..base.files import check_target, written
from ..output.scene import Scene
from ..report.style import dress
from .pictures import BlockPicture

_WIDTH = 1280  # width of a movie, pixels
_HUES = 256  # number of colours of each picture of a GIF


def write_movie(
    source,
    file,
    fps: float = 25.0,
    seconds: float = 10.0,
    progress: bool = False,
    scheme: str = "light",
    absolute: bool = False,
    **look,
) -> Path:
    """Write the frames of an output as a movie.

    `source`: an output of at least two frames.
    `file`: ``.mp4`` (ffmpeg of the system, or of the package imageio-ffmpeg: extra ``movie``), or
    ``.gif``.
    `fps`: pictures a second.
    `seconds`: duration of the movie; it shows the frames nearest to evenly spaced times.
    `progress`: show a progress bar.
    `absolute`: see `pictures.draw`.
    `look`: color, contacts, arrows, deformation, since, see `pictures.draw`.
    """
    fps, seconds = PICTURES_A_SECOND.check("fps", fps), SECONDS.check("seconds", seconds)
    ANY_NUMBER.check("deformation", look.get("deformation", 1.0))
    scene = Scene.of(source, absolute)
    file = Path(file)
    if scene.frames < 2:
        raise InputError("a movie needs two or more frames; give a block_interval in &output")
    kind = file.suffix.lower()
    if kind not in (".gif", ".mp4"):
        raise InputError(f"{file}: a movie is .mp4 or .gif")
    reads = [source] if isinstance(source, str | os.PathLike) else []
    check_target(file, "a movie", reads)
    program = ffmpeg() if kind == ".mp4" else ""
    frames = chosen_frames(scene, round(fps * seconds))
    pictures = tqdm(
        _draw_frames(scene, frames, scheme, look),
        total=len(frames),
        disable=not progress,
        unit="picture",
    )
    with written(file, "a movie", reads) as temporary:
        if kind == ".gif":
            _write_gif(temporary, pictures, fps)
        else:
            _write_mp4(temporary, pictures, fps, program)
    return file


def chosen_frames(scene: Scene, count: int) -> list[int]:
    """Return the frames nearest to evenly spaced times, up to a maximum number."""
    times = np.linspace(scene.time[0], scene.time[-1], max(2, min(count, 4 * scene.frames)))
    middle = 0.5 * (scene.time[1:] + scene.time[:-1])
    return np.searchsorted(middle, times).tolist()


def _draw_frames(scene: Scene, frames, scheme: str, options: dict) -> Iterator[np.ndarray]:
    """Yield pictures, shape (height, width, 3), 8 bits; a repeated frame is drawn once."""
    options = options | {"color": options.get("color") or "displacement", "frames": frames}
    drawing = BlockPicture(scene, **options)
    drawing.show(frames[0])  # the layout reserves space for the keys
    figure = drawing.axes.figure
    canvas = FigureCanvasAgg(figure)
    width, height = figure.get_size_inches()
    # The codec needs even numbers of pixels.
    dpi = _WIDTH / width
    figure.set_size_inches(_WIDTH / dpi, 2 * round(0.5 * height * dpi) / dpi)
    figure.set_dpi(dpi)
    drawn_frame, picture = None, None
    for frame in frames:
        if frame != drawn_frame:
            drawing.show(frame)
            dress(figure, scheme)
            canvas.draw()
            figure.set_layout_engine("none")  # all frames have the layout of the first frame
            picture, drawn_frame = np.array(canvas.buffer_rgba())[..., :3].copy(), frame
        yield picture


def _write_gif(file: Path, pictures, fps: float) -> None:
    """Write a GIF with a palette per picture; merge equal successive pictures."""
    images, durations, previous = [], [], None
    for picture in pictures:
        if picture is previous:
            durations[-1] += 1000 / fps
            continue
        previous = picture
        images.append(Image.fromarray(picture).quantize(_HUES))
        durations.append(1000 / fps)
    options = {"append_images": images[1:], "duration": [round(d) for d in durations]}
    images[0].save(file, save_all=True, loop=0, optimize=True, **options)


def _write_mp4(file: Path, pictures, fps: float, program: str) -> None:
    """Write an MP4: pass the pictures to a process of ffmpeg."""
    process = None
    try:
        for picture in pictures:
            if process is None:
                process = _start_ffmpeg(program, file, picture.shape[1], picture.shape[0], fps)
            try:
                process.stdin.write(picture.tobytes())
            except BrokenPipeError:
                break
        with suppress(BrokenPipeError):
            process.stdin.close()
        message = process.stderr.read().decode("utf-8", "replace").strip()
        if status := process.wait():
            ends = f"ends by signal {-status}" if status < 0 else f"ends with status {status}"
            last_line = "".join(message.splitlines()[-1:])
            raise OSError(f"ffmpeg {ends}" + (f": {last_line}" if last_line else ""))
    finally:
        if process and process.poll() is None:  # ffmpeg is running after an error or a signal
            process.kill()
            process.wait()


def _start_ffmpeg(
    program: str, file: Path, width: int, height: int, fps: float
) -> subprocess.Popen:
    """Start ffmpeg, which reads raw pictures from its standard input; return the process."""
    command = [
        *(program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"),
        *("-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-", "-an", "-c:v", "libx264"),
        *("-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart", f"file:{file}"),
    ]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)


def ffmpeg() -> str:
    """Return the path of ffmpeg, of the system or of the package imageio-ffmpeg."""
    program = shutil.which("ffmpeg")
    if program:
        return program
    try:
        return importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe()
    except (ImportError, RuntimeError) as error:
        raise MissingLibrary(
            "an MP4 needs ffmpeg: install ffmpeg, or pip install 'sitedda[movie]'; or write a .gif"
        ) from error


def animate(source, fps: float = 25.0, seconds: float = 10.0, absolute: bool = False, **look):
    """Return the frames of an output as a `matplotlib.animation.FuncAnimation`.

    `fps`, `seconds`, `absolute`: see `write_movie`; `**look`: color, contacts, arrows, deformation,
    since, see `pictures.draw`.
    """
    fps, seconds = PICTURES_A_SECOND.check("fps", fps), SECONDS.check("seconds", seconds)
    scene = Scene.of(source, absolute)
    frames = chosen_frames(scene, round(fps * seconds))
    drawing = BlockPicture(scene, **look, frames=frames)
    FigureCanvasAgg(drawing.axes.figure)
    drawing.show(frames[0])
    return FuncAnimation(drawing.axes.figure, drawing.show, frames, interval=1000 / fps)
