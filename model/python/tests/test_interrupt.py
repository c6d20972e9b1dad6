"""Ctrl-C during a long computation."""

import os
import signal
import threading
import time

import finray
import pytest
from conftest import SCENES

# Time, s, within which an exception must follow the signal; looks are 0.05 s apart, and a loaded machine is slow.
SOON = 2.0


def test_ctrl_c_ends_a_press():
    text = (SCENES / "contact" / "box.toml").read_text()
    assert "\nsteps = " in text
    lines = ["steps = 4000" if line.startswith("steps = ") else line for line in text.splitlines()]
    scene = finray.Scene.parse("\n".join(lines))
    asked = []

    def ask():
        asked.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threads = threading.active_count()
    timer = threading.Timer(0.3, ask)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        finray.press(scene, fineness=12)
    assert time.monotonic() - asked[0] < SOON
    timer.join()
    # The package computes as before, and errors of the computation are exceptions as before.
    assert finray.solve(finray.Scene.paper(), [(80, 1, 0)]).displacements.shape == (25, 2)
    with pytest.raises(finray.FinrayError):
        finray.solve(finray.Scene.paper(), [(80, 1, 0)], mesh_nodes=3)
    assert threading.active_count() == threads
