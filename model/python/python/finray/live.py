"""Forces in the frames of a camera, one line of JSON per frame, as `finray live` prints them.

    python -m finray.live scene.toml --contact-at auto@normal --camera 0

The camera needs OpenCV (`pip install opencv-python`); `--image FILE ...` does not.
"""

import argparse
import sys
import threading
import time

from . import FinrayError, Scene, StreamSensor, read_image


def lines(sensor, frames):
    """Yield the line of each frame.

    `frames` yields images, or tuples (image, time_s, dropped). A text instead of an image is the reason why a frame cannot be read.
    """
    for frame in frames:
        image, time_s, dropped = frame if isinstance(frame, tuple) else (frame, None, 0)
        if isinstance(image, str):
            yield sensor.refused_line(image, time_s=time_s, dropped=dropped)
        else:
            yield sensor.line(image, time_s=time_s, dropped=dropped)


def files(paths):
    """Yield the images of files, or the reason why a file cannot be read."""
    for path in paths:
        try:
            yield read_image(path)
        except FinrayError as error:
            yield str(error)


def camera(source, every_frame=False):
    """Yield (image, time_s, dropped) from an OpenCV capture until it ends.

    `source` is the number of a camera, or the name of a file or stream. Times are in seconds since the first frame. A thread reads the capture, and
    frames that arrive during an evaluation are dropped except for the newest, unless `every_frame` is true.
    """
    cv2 = opencv()
    capture = cv2.VideoCapture(int(source) if str(source).isdigit() else source)
    if not capture.isOpened():
        raise FinrayError(f"--camera {source}: cannot be opened")
    changed = threading.Condition()
    waiting = []  # at most one frame: image, time of arrival in s, number of dropped frames
    ended = stopped = False

    def read():
        nonlocal ended
        while True:
            is_read, image = capture.read()
            arrived_s = time.monotonic()
            with changed:
                while every_frame and waiting and not stopped:
                    changed.wait()
                if stopped or not is_read:
                    ended = True
                    changed.notify_all()
                    return
                dropped = waiting.pop()[2] + 1 if waiting else 0
                waiting.append((image, arrived_s, dropped))
                changed.notify_all()

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    first_s = None
    try:
        while True:
            with changed:
                while not waiting and not ended:
                    changed.wait()
                if not waiting:
                    return
                image, arrived_s, dropped = waiting.pop()
                changed.notify_all()
            first_s = arrived_s if first_s is None else first_s
            yield cv2.cvtColor(image, cv2.COLOR_BGR2RGB), arrived_s - first_s, dropped
    finally:
        with changed:
            stopped = True
            changed.notify_all()
        reader.join()
        capture.release()


def opencv():
    """The module cv2."""
    try:
        import cv2
    except ImportError as error:
        raise FinrayError(f"--camera needs OpenCV (pip install opencv-python): {error}") from error
    return cv2


def count(text):
    """A whole number, zero or more, from the command line."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number, zero or more, found {text!r}")
    return int(text)


def parser():
    """The parser of the command line."""
    about, _, example = __doc__.partition("\n\n")
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
    at = "contact at a position along the front plate, as for finray live"
    parser.add_argument("--contact-at", metavar="S_MM|auto[@...]", nargs="+", action="extend", help=at)
    parser.add_argument("--contact", metavar="NODE[@...]", nargs="+", action="extend", help="contact at a node, as for finray live")
    parser.add_argument("--noise-mm", metavar="S", type=float, help="standard deviation of one coordinate, mm")
    parser.add_argument("--estimator", default="nonlinear", help="estimator of the forces (default: nonlinear)")
    parser.add_argument("--rest-frames", metavar="N", type=count, default=0, help="take the first N frames (unloaded finger) as reference")
    return parser


def main(arguments=None):
    """Print one line per frame. Returns the exit code."""
    asked = parser().parse_args(arguments)
    try:
        sensor = StreamSensor(
            Scene.read(asked.scene),
            asked.contact_at,
            contact=asked.contact,
            noise_mm=asked.noise_mm,
            estimator=asked.estimator,
            rest_frames=asked.rest_frames,
        )
        frames = files(asked.image) if asked.image else camera(asked.camera, asked.every_frame)
        for line in lines(sensor, frames):
            print(line, flush=True)
    except FinrayError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (BrokenPipeError, KeyboardInterrupt):
        sys.stderr.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
