"""Forces in streams: the lines of `finray live`."""

import http.server
import json
import signal
import subprocess
import sys
import threading
import time
import typing
from pathlib import Path

import finray
import finray.live
import pytest
from conftest import SCENES, done, refusal

CAMERA = SCENES / "camera.toml"


def without_latency(text):
    """The lines, each with all keys but the latency."""
    lines = [json.loads(line) for line in text.splitlines()]
    assert lines and all(line.pop("latency_ms") > 0 for line in lines)
    return lines


def live(*arguments, **environment):
    command = [sys.executable, "-m", "finray.live", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **environment)


@pytest.mark.parametrize(
    "options",
    [["--contact-at", "auto@-20"], ["--contact-at", "auto@auto", "--rest-frames", "2", "--noise-mm", "0.02"], ["--contact-at", "80@-20"]],
)
def test_lines_are_those_of_the_program(images, options, tmp_path):
    free, pressed = images
    (tmp_path / "damaged.png").write_bytes(free.read_bytes()[:2000])
    files = ["--image", free, free, pressed, tmp_path / "none.png", pressed, tmp_path / "damaged.png", free, pressed]
    theirs = done("live", CAMERA, *options, "--every-frame", *files)[0]
    ours = live(CAMERA, *options, *files)
    assert ours.returncode == 0, ours.stderr
    assert without_latency(ours.stdout) == without_latency(theirs)
    states = {line["state"] for line in without_latency(theirs)}
    assert {"contact", "none", "refused"} <= states


def test_lines_of_positions_are_those_of_the_program(paper, bent, tmp_path):
    frames = [0.0, 1.0, 0.5]
    path = tmp_path / "positions.csv"
    sensor = finray.StreamSensor(paper, "auto@-20", noise_mm=0.02)
    rows, ours = ["t_s,node,x_mm,y_mm"], []
    for number, share in enumerate(frames):
        at = bent.positions + share * bent.displacements
        rows.extend(f"{number / 10},{node},{x!r},{y!r}" for node, (x, y) in zip(bent.nodes, at.tolist()))
        ours.append(sensor.line(finray.Observation(bent.nodes, positions=at), time_s=number / 10))
    path.write_text("\n".join([*rows, ""]))
    options = ["--contact-at", "auto@-20", "--noise-mm", "0.02", "--every-frame", "--input", path]
    theirs = done("live", SCENES / "paper.toml", *options)[0]
    assert without_latency("\n".join(ours)) == without_latency(theirs)


def test_errors_are_those_of_the_program(images):
    for options in [["--contact-at", "auto@object"], ["--contact", "18@friction"]]:
        answer = live(CAMERA, *options, "--image", images[0])
        assert answer.returncode == 2
        assert answer.stderr == f"error: {refusal('live', CAMERA, *options, '--image', images[0])}\n"


FAKE = '''
import finray

COLOR_BGR2RGB = 4

class VideoCapture:
    def __init__(self, source):
        self.source, self.left = source, {frames!r}

    def isOpened(self):
        return self.source == {source!r}

    def read(self):
        if not self.left:
            return False, None
        frame = self.left.pop(0)
        if isinstance(frame, float):
            __import__("time").sleep(frame)
            return self.read()
        if not isinstance(frame, str):
            raise RuntimeError("camera\\n unplugged")
        return True, finray.read_image(frame)[:, :, ::-1].copy()

    def release(self):
        print("released", file=__import__("sys").stderr)

def cvtColor(image, code):
    assert code == COLOR_BGR2RGB
    return image[:, :, ::-1].copy()
'''


def test_frames_of_a_capture_give_the_lines_of_their_images(images, tmp_path, monkeypatch):
    """A module with the interface of OpenCV replaces a camera."""
    frames = [str(path) for path in (images[0], images[1], images[0])]
    (tmp_path / "cv2.py").write_text(FAKE.format(frames=frames, source=3))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    ours = live(CAMERA, "--contact-at", "auto@-20", "--camera", 3, "--every-frame")
    assert (ours.returncode, ours.stderr) == (0, "released\n")
    theirs = done("live", CAMERA, "--contact-at", "auto@-20", "--every-frame", "--image", *frames)[0]
    lines = without_latency(ours.stdout)
    times = [line["time_s"] for line in lines]
    assert times[0] == 0 and times == sorted(times)
    assert [{**line, "time_s": None} for line in lines] == without_latency(theirs)
    newest = without_latency(live(CAMERA, "--contact-at", "auto@-20", "--camera", 3).stdout)
    assert newest[-1]["frame"] == 2 and len(newest) + sum(line["dropped"] for line in newest) == 3
    closed = live(CAMERA, "--contact-at", "auto", "--camera", 0)
    assert (closed.returncode, closed.stderr) == (2, "error: --camera 0: cannot be opened\n")


@pytest.fixture
def capture(images, tmp_path, monkeypatch):
    """Runs the program with camera 3, a substitute for OpenCV. A frame is a path, a pause in s, or None: reading fails."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    def command(*frames):
        (tmp_path / "cv2.py").write_text(FAKE.format(frames=[*frames], source=3))
        return CAMERA, "--contact-at", "auto@-20", "--camera", 3, "--every-frame"

    return command


def test_a_camera_that_fails_ends_the_stream_with_an_error(images, capture):
    ours = live(*capture(str(images[0]), str(images[1]), None), timeout=60)
    assert (ours.returncode, ours.stderr) == (2, "released\nerror: --camera 3: cannot be read: camera unplugged\n")
    assert [line["state"] for line in without_latency(ours.stdout)] == ["none", "contact"]


def test_a_camera_without_a_frame_is_an_error(capture):
    ours = live(*capture(), timeout=60)
    assert (ours.returncode, ours.stdout, ours.stderr) == (2, "", "released\nerror: --camera 3: no frame was read\n")


def test_a_camera_with_frames_of_another_size_is_an_error_as_in_the_program(images, capture, tmp_path):
    small = tmp_path / "small.png"
    scene = tmp_path / "small.toml"
    scene.write_text(CAMERA.read_text().replace("[1600, 1400]", "[800, 700]").replace("1360.0", "680.0").replace("[799.5, 699.5]", "[399.5, 349.5]"))
    done("render", scene, "--out", small)
    ours = live(*capture(str(images[0]), str(small), str(images[0])), timeout=60)
    assert len(ours.stdout.splitlines()) == 1
    (tmp_path / "small.rgb").write_bytes(finray.read_image(small).tobytes())
    raw = ["--format", "rgb24", "--size", "800x700", "--input", tmp_path / "small.rgb"]
    message = refusal("live", CAMERA, "--contact-at", "auto@-20", *raw).partition(": ")[2]
    assert message == "expected frames of 1600 x 1400 px, the size of the scene's camera, found 800 x 700 px"
    assert (ours.returncode, ours.stderr) == (2, f"released\nerror: --camera 3: {message}\n")


def test_an_interrupt_ends_a_stalled_stream(images, capture):
    command = [sys.executable, "-m", "finray.live", *map(str, capture(str(images[0]), 60.0, str(images[0])))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        assert json.loads(program.stdout.readline())["state"] == "none"
        program.send_signal(signal.SIGINT)
        start = time.monotonic()
        assert program.communicate(timeout=60) == ("", "") and program.returncode == 0
    assert time.monotonic() - start < 20


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_output_that_cannot_be_written_is_an_error(images):
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "finray.live", str(CAMERA), "--contact-at", "80@-20", "--image", str(images[0])]
        ours = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (ours.returncode, ours.stderr) == (1, "error: standard output: cannot be written: No space left on device\n")


@pytest.mark.parametrize("number", ["9" * 23, "-1", "1.5"])
def test_a_wrong_number_of_rest_frames_is_an_error(number, images):
    ours = live(CAMERA, "--contact-at", "80", "--image", images[0], f"--rest-frames={number}")
    assert ours.returncode == 2 and "Traceback" not in ours.stderr
    assert ours.stderr.splitlines()[-1].endswith(f"expected a whole number from 0 to 999999999, found '{number}'")


def test_a_large_number_of_dropped_frames_is_an_error(paper, bent):
    sensor = finray.StreamSensor(paper, "80@-20", noise_mm=0.05)
    assert json.loads(sensor.line(bent.observation(), dropped=2**53))["dropped"] == 2**53
    for wrong in (2**53 + 1, 2**64 - 1):
        for line, content in ((sensor.line, bent.observation()), (sensor.refused_line, "damaged")):
            with pytest.raises(finray.FinrayError, match=f"dropped: expected at most {2**53}, found {wrong}"):
                line(content, dropped=wrong)


def test_opencv_reads_a_video_without_loss(images, tmp_path):
    """OpenCV stores and reads the images in a lossless codec, so each line is that of the image file."""
    cv2 = pytest.importorskip("cv2")
    frames = [images[0], images[1], images[0], images[1], images[1]]
    path = tmp_path / "video.avi"
    pixels = [finray.read_image(frame) for frame in frames]
    height, width, _ = pixels[0].shape
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"RGBA"), 25, (width, height))
    assert writer.isOpened()
    for frame in pixels:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    writer.release()
    ours = live(CAMERA, "--contact-at", "auto@-20", "--camera", path, "--every-frame")
    assert ours.returncode == 0, ours.stderr
    theirs = done("live", CAMERA, "--contact-at", "auto@-20", "--every-frame", "--image", *frames)[0]
    assert [{**line, "time_s": None} for line in without_latency(ours.stdout)] == without_latency(theirs)


class NetworkCamera(http.server.BaseHTTPRequestHandler):
    """A camera that sends JPEG images, one after the other (multipart/x-mixed-replace), as network cameras do."""

    frames: typing.ClassVar = []

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        self.end_headers()
        for frame in self.frames:
            self.wfile.write(b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(frame))
            self.wfile.write(frame + b"\r\n")
            time.sleep(1 / 25)

    def log_message(self, *_):
        """Print nothing."""


def test_opencv_reads_a_network_camera(images):
    """Rendered images arrive over HTTP at 25 a second, compressed with loss, as from a network camera."""
    cv2 = pytest.importorskip("cv2")
    free, pressed = (cv2.imencode(".jpg", cv2.imread(str(path)), [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes() for path in images)
    NetworkCamera.frames = [free] * 20 + [pressed] * 30 + [free] * 20
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), NetworkCamera) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_address[1]}/stream.mjpg"
        ours = live(CAMERA, "--contact-at", "auto@-20", "--camera", address, "--rest-frames", 3)
        server.shutdown()
    assert ours.returncode == 0, ours.stderr
    lines = without_latency(ours.stdout)
    assert len(lines) + sum(line["dropped"] for line in lines) >= 65
    states = [line["state"] for line in lines]
    assert set(states) == {"contact", "none"}
    assert states[0] == states[-1] == "none"
    for line in lines:
        for contact in line["contacts"]:
            assert abs(contact["force_n"] - 2) < 0.02 and abs(contact["s_mm"] - 80) < 0.5
    assert max(line.get("drift_mm", 0) for line in lines) < 0.01


def test_a_camera_without_opencv_is_an_error(tmp_path, monkeypatch):
    (tmp_path / "cv2.py").write_text("raise ImportError('no module named cv2')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    answer = live(CAMERA, "--contact-at", "auto", "--camera", 0)
    assert answer.returncode == 2 and answer.stderr.startswith("error: --camera needs OpenCV (pip install opencv-python)")
