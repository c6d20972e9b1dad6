"""Forces in the frames of a camera, one line of JSON per frame, as `finray live` prints them.

    python -m finray.live scene.toml --contact-at auto@normal --camera 0

The camera needs OpenCV (`pip install opencv-python`); `--image FILE ...` does not.
"""

import argparse
import importlib
import os
import sys
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from types import ModuleType
from typing import Optional, Union

import numpy as np
import numpy.typing as npt

from . import FinrayError, Observation, Scene, StreamSensor, read_image

_Image = npt.NDArray[np.uint8]
# An image, observed markers, or the reason why a frame cannot be read.
_Content = Union[_Image, Observation, str]
_Frame = Union[_Content, tuple[_Content, Optional[float], int]]

# OpenCV may block for half a minute in a stalled stream. The program ends after this time, s, and leaves the capture to the operating system.
_STALLED_S = 0.5


def lines(sensor: StreamSensor, frames: Iterable[_Frame]) -> Iterator[str]:
    """Yield the line of each frame.

    `frames` yields images, or tuples (image, time_s, dropped). A text instead of an image is the reason why a frame cannot be read.
    """
    for frame in frames:
        image, time_s, dropped = frame if isinstance(frame, tuple) else (frame, None, 0)
        if isinstance(image, str):
            yield sensor.refused_line(image, time_s=time_s, dropped=dropped)
        else:
            yield sensor.line(image, time_s=time_s, dropped=dropped)


def files(paths: Iterable[Union[str, "os.PathLike[str]"]]) -> Iterator[Union[_Image, str]]:
    """Yield the images of files, or the reason why a file cannot be read."""
    for path in paths:
        try:
            yield read_image(path)
        except FinrayError as error:
            yield str(error)


def camera(
    source: Union[int, str], every_frame: bool = False, size_px: Optional[tuple[int, int]] = None
) -> Iterator[tuple[_Image, float, int]]:
    """Yield (image, time_s, dropped) from an OpenCV capture until it ends.

    `source` is the number of a camera, or the name of a file or stream. Times are in seconds since the first frame. A thread reads the capture, and
    frames that arrive during an evaluation are dropped except for the newest, unless `every_frame` is true. `size_px` is the expected width and
    height of a frame.

    Raises FinrayError if the capture cannot be opened or read, yields no frame, or yields a frame of another size.
    """

    def failed(reason: object) -> FinrayError:
        # Messages of OpenCV have several lines.
        return FinrayError(f"--camera {source}: {' '.join(str(reason).split())}")

    cv2 = opencv()
    try:
        capture = cv2.VideoCapture(int(source) if str(source).isdecimal() else source)
        is_opened = capture.isOpened()
    except Exception as error:
        raise failed(f"cannot be opened: {error}") from error
    if not is_opened:
        raise failed("cannot be opened")
    changed = threading.Condition()
    waiting: list[tuple[_Image, float, int]] = []  # at most one frame: image, time of arrival in s, number of dropped frames
    ended = stopped = False
    failure: Optional[Exception] = None

    def read() -> None:
        while True:
            is_read, image = capture.read()
            arrived_s = time.monotonic()
            with changed:
                while every_frame and waiting and not stopped:
                    changed.wait()
                if stopped or not is_read:
                    return
                dropped = waiting.pop()[2] + 1 if waiting else 0
                waiting.append((image, arrived_s, dropped))
                changed.notify_all()

    def read_to_the_end() -> None:
        nonlocal ended, failure
        try:
            read()
        except Exception as error:
            failure = error
        finally:
            with changed:
                ended = True
                changed.notify_all()

    reader = threading.Thread(target=read_to_the_end, daemon=True)
    reader.start()
    first_s = None
    try:
        while True:
            with changed:
                while not waiting and not ended:
                    changed.wait()
                if not waiting:
                    break
                image, arrived_s, dropped = waiting.pop()
                changed.notify_all()
            height, width = image.shape[:2]
            if size_px is not None and size_px != (width, height):
                expected = "{} x {} px".format(*size_px)
                raise failed(f"expected frames of {expected}, the size of the scene's camera, found {width} x {height} px")
            try:
                converted = cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
            except Exception as error:
                raise failed(f"expected colour images: {error}") from error
            first_s = arrived_s if first_s is None else first_s
            yield converted, arrived_s - first_s, dropped
        if failure is not None:
            raise failed(f"cannot be read: {failure}") from failure
        if first_s is None:
            raise failed("no frame was read")
    finally:
        with changed:
            stopped = True
            changed.notify_all()
        reader.join(_STALLED_S)
        if not reader.is_alive():
            capture.release()


def opencv() -> ModuleType:
    """The module cv2."""
    try:
        return importlib.import_module("cv2")
    except ImportError as error:
        raise FinrayError(f"--camera needs OpenCV (pip install opencv-python): {error}") from error


def count(text: str) -> int:
    """A whole number, zero or more, from the command line."""
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"expected a whole number from 0 to 999999999, found {text!r}")
    return int(text)


def parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    about, _, example = str(__doc__).partition("\n\n")
    parser = argparse.ArgumentParser(
        "python -m finray.live",
        description=about,
        epilog=example,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scene", help="scene file (TOML)")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--camera", metavar="N", help="number of a camera, or name of a video, for OpenCV")
    source.add_argument("--image", metavar="FILE", nargs="+", help="images (PNG, JPEG), in order of time")
    parser.add_argument("--every-frame", action="store_true", help="evaluate every frame, not only the newest")
    at = "contact at a position along a plate, as for finray live"
    parser.add_argument("--contact-at", metavar="[back:]S_MM|auto[@...]", nargs="+", action="extend", help=at)
    parser.add_argument("--contact", metavar="NODE[@...]", nargs="+", action="extend", help="contact at a node, as for finray live")
    parser.add_argument("--noise-mm", metavar="S", type=float, help="standard deviation of one coordinate, mm")
    parser.add_argument("--estimator", default="nonlinear", help="estimator of the forces (default: nonlinear)")
    parser.add_argument("--rest-frames", metavar="N", type=count, default=0, help="take the first N frames (unloaded finger) as reference")
    return parser


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Print one line per frame. Returns the exit code."""
    asked = parser().parse_args(arguments)
    try:
        scene = Scene.read(asked.scene)
        sensor = StreamSensor(
            scene,
            asked.contact_at,
            contact=asked.contact,
            noise_mm=asked.noise_mm,
            estimator=asked.estimator,
            rest_frames=asked.rest_frames,
        )
        frames = files(asked.image) if asked.image else camera(asked.camera, asked.every_frame, scene.camera_size_px)
        for line in lines(sensor, frames):
            print(line, flush=True)
    except FinrayError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        pass
    except OSError as error:
        # The interpreter writes what is left of the output when it ends, and would print this error again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            print(f"error: standard output: cannot be written: {error.strerror}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
