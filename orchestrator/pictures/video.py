"""Writes films: H.264 in mp4, the same bytes for the same pictures."""

from __future__ import annotations

import itertools
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import InputError

QUALITY = 20
"""constant rate factor of x264: hardly to be told from lossless"""


def encoder() -> str:
    """The program that encodes.

    Raises:
        InputError: if imageio-ffmpeg is missing.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise InputError("mp4 needs the extra `video`: pip install 'crowdcosim[video]'") from None
    return str(imageio_ffmpeg.get_ffmpeg_exe())


def write_mp4(path: Path, pictures: Iterator[NDArray[np.uint8]] | Iterable[NDArray[np.uint8]], rate: float) -> None:
    """Write (H, W, 3) pictures with even sides, so many per second.

    Raises:
        InputError: if imageio-ffmpeg is missing or the file cannot be written.
    """
    pictures = iter(pictures)
    first = next(pictures)
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{first.shape[1]}x{first.shape[0]}", "-r", f"{rate:g}"]
    # One thread: x264 gives other bytes for other numbers of threads. Nothing of the encoder's version in the file.
    coding = ["-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", str(QUALITY), "-threads", "1"]
    exact = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart"]
    command = [encoder(), "-y", "-loglevel", "error", *source, "-i", "-", *coding, *exact, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        try:
            for picture in itertools.chain([first], pictures):
                process.stdin.write(picture.tobytes())
        except BrokenPipeError:
            pass  # it says why below
        _, said = process.communicate()
    if process.returncode:
        raise InputError(f"cannot write {path}: {said.decode(errors='replace').strip()}")
