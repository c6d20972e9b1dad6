"""Markers in images, without copies of the images, and without the interpreter."""

import threading
import time

import finray
import numpy as np
import pytest
from conftest import SCENES, assert_same, done, refusal, table


@pytest.fixture(scope="module")
def pressed(images):
    return finray.read_image(images[1])


def assert_same_markers(seen, printed, rows):
    assert_same(seen.nodes, printed["node"][rows])
    for ours, names in [(seen.pixels, "uv"), (seen.positions, "xy")]:
        for axis, name in enumerate(names):
            assert_same(ours[:, axis], printed[f"{name}_{'px' if ours is seen.pixels or names == 'uv' else 'mm'}"][rows])
    for axis, name in enumerate("xy"):
        assert_same(seen.displacements[:, axis], printed[f"u{name}_mm"][rows])
    assert_same(seen.sigma_mm, printed["sigma_mm"][rows])


def test_markers_are_those_of_the_program(camera, images):
    printed = table(done("locate", SCENES / "camera.toml", "--image", *images)[0])
    locator = finray.Locator(camera)
    for path in images:
        rows = [name == path.name for name in printed["image"]]
        assert_same_markers(locator.locate(finray.read_image(path)), printed, rows)


def test_markers_relative_to_an_unloaded_image_are_those_of_the_program(camera, images, pressed):
    free, path = images
    printed = table(done("locate", SCENES / "camera.toml", "--image", path, "--rest", free)[0])
    locator = finray.Locator(camera, rest=finray.read_image(free))
    assert_same_markers(locator.locate(pressed), printed, slice(None))
    assert 0 < locator.rest_residual_px < 0.3 and locator.rest_warning is None
    with pytest.raises(finray.FinrayError, match="px rms from"):
        finray.Locator(camera, rest=pressed)


def test_forces_from_an_image_are_those_of_the_program(camera, images, pressed):
    printed = table(done("sense", SCENES / "camera.toml", "--image", images[1], "--contact-at", "auto@auto")[0])
    forces = finray.Sensor(camera, "auto@auto").sense(finray.Locator(camera).locate(pressed))
    for name in ("s_mm", "angle_deg", "force_n", "sigma_n"):
        assert_same(getattr(forces, name), printed[name])


def test_a_moving_base_is_the_program_s(tmp_path):
    scene, image = SCENES / "bracketed.toml", tmp_path / "bracketed.png"
    done("render", scene, "--load-at", "40:1,0", "--out", image)
    printed = table(done("locate", scene, "--image", image)[0])
    ours = finray.Scene.read(scene)
    seen = finray.Locator(ours).locate(finray.read_image(image))
    assert_same_markers(seen, printed, slice(None))
    assert list(seen.base_pose) == [printed[name][0] for name in ("base_x_mm", "base_y_mm", "base_deg")]
    assert_same(seen.marker_sigma_mm, printed["marker_sigma_mm"])


def test_images_are_read_in_place(camera, pressed):
    """A read-only array is accepted, and the peak of memory grows by less than one image."""
    still = pressed.view()
    still.flags.writeable = False
    assert len(finray.Locator(camera).locate(still)) == 25
    # A copy of the image would raise the peak of memory by more than the limit, half the size of the image. The image is much larger than the
    # camera's images, so `locate` refuses it.
    for large in (np.zeros((16000, 16000, 3), np.uint8), np.zeros((30000, 30000), np.uint8)):
        before_kb = peak_kb()
        with pytest.raises(finray.FinrayError, match="expected an image of 1600 x 1400 px"):
            finray.Locator(camera).locate(large)
        assert peak_kb() - before_kb < large.nbytes / 1024 / 2


def peak_kb():
    """Peak of the memory of this process, KiB."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def test_a_grey_image_is_converted(tmp_path):
    """Grey markers have the same positions in a grey image and in a colour image of the same levels."""
    scene, paths = SCENES / "bracketed.toml", [tmp_path / "free.png", tmp_path / "pressed.png"]
    done("render", scene, "--out", paths[0])
    done("render", scene, "--load-at", "40:1,0", "--out", paths[1])
    greys = [finray.read_image(path)[:, :, 0].copy() for path in paths]
    colours = [np.repeat(grey[:, :, None], 3, axis=2) for grey in greys]
    ours = finray.Scene.read(scene)
    for with_rest in (False, True):
        seen = [finray.Locator(ours, *([free] if with_rest else [])).locate(pressed) for free, pressed in (greys, colours)]
        assert len(seen[0]) > 5
        np.testing.assert_array_equal(seen[0].displacements, seen[1].displacements)


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda image: image[:, ::-1], "C-contiguous"),
        (lambda image: image[:, :, ::-1], "C-contiguous"),
        (lambda image: np.asfortranarray(image), "C-contiguous"),
        (lambda image: image[::2, ::2, 0], "C-contiguous"),
        (lambda image: np.asfortranarray(image[:, :, 0]), "C-contiguous"),
        (lambda image: image.astype(float), r"expected an image: a uint8 array .* found float64 of shape \(1400, 1600, 3\)"),
        (lambda image: np.concatenate([image, image[:, :, :1]], axis=2), "expected an image: a uint8 array"),
        (lambda image: image[0, 0], "expected an image"),
        (lambda image: image[:700], "expected an image of 1600 x 1400 px"),
        (lambda image: np.zeros((0, 0, 3), np.uint8), "expected an image of 1600 x 1400 px"),
        (lambda image: "image.png", "expected an image: a uint8 array .* found 'image.png'"),
        (lambda image: np.ma.array(image, mask=image > 9), "expected an image without a mask"),
    ],
)
def test_other_arrays_are_errors(camera, pressed, change, message):
    with pytest.raises(finray.FinrayError, match=message):
        finray.Locator(camera).locate(change(pressed))


def test_an_image_without_a_finger_is_refused_as_by_the_program(camera, tmp_path):
    scene = SCENES / "camera.toml"
    path = tmp_path / "none.png"
    done("render", scene, "--out", path)
    black = np.zeros((1400, 1600, 3), np.uint8)
    with pytest.raises(finray.Refused, match="no finger is recognised"):
        finray.Locator(camera).locate(black)


def test_a_scene_without_a_camera_and_a_missing_file_are_errors(paper, tmp_path):
    with pytest.raises(finray.FinrayError, match=r"the scene has no \[camera\]"):
        finray.Locator(paper)
    with pytest.raises(finray.FinrayError, match="none.png: cannot be read"):
        finray.read_image(tmp_path / "none.png")
    with pytest.raises(finray.FinrayError) as error:
        finray.Scene.read(tmp_path / "none.toml")
    assert str(error.value) == refusal("solve", tmp_path / "none.toml", "--load-at", "80:1")
    (tmp_path / "wrong.toml").write_text("[finger]\nlength = 3\n")
    with pytest.raises(finray.FinrayError) as error:
        finray.Scene.read(tmp_path / "wrong.toml")
    assert str(error.value) == refusal("solve", tmp_path / "wrong.toml", "--load-at", "80:1")


def ticks_during(compute):
    """Duration of a computation, s, and ticks of a thread of Python meanwhile; without the interpreter it would stand still."""
    ticks, is_over = [0], threading.Event()

    def count():
        while not is_over.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    time.sleep(0.02)
    before, start = ticks[0], time.monotonic()
    compute()
    took_s = time.monotonic() - start
    counted = ticks[0] - before
    is_over.set()
    thread.join()
    return took_s, counted


def test_other_threads_run_during_a_computation():
    scene = finray.Scene.read(SCENES / "contact" / "disc.toml")
    took_s, counted = ticks_during(lambda: [finray.press(scene) for _ in range(5)])
    # Each pass of the counting thread takes 1 ms of sleep, and longer on a busy machine.
    assert took_s > 0.05 and counted > took_s / 0.02, (took_s, counted)


def test_other_threads_run_while_a_stream_is_busy():
    """A frame that cannot be read waits for the frame before it, a large image, without the interpreter."""
    text = (SCENES / "camera.toml").read_text()
    for small, large in [("[1600, 1400]", "[8000, 7000]"), ("1360.0", "6800.0"), ("[799.5, 699.5]", "[3999.5, 3499.5]")]:
        text = text.replace(small, large)
    sensor = finray.StreamSensor(finray.Scene.parse(text), "auto@auto")
    busy = threading.Thread(target=sensor.line, args=(np.zeros((7000, 8000, 3), np.uint8),))

    def refuse_beside():
        busy.start()
        time.sleep(0.02)
        sensor.refused_line("damaged")

    took_s, counted = ticks_during(refuse_beside)
    busy.join()
    assert took_s > 0.05 and counted > took_s / 0.02, (took_s, counted)
