"""Contact forces of compliant fin-ray fingers from their deformation.

Units are N, mm and degrees, unless a name states another unit. The finger frame has its origin at the middle of the base line; x points to the tip,
y to the front plate. Angles are measured from the inward normal of the undeformed front plate, positive towards the tip.

    scene = finray.Scene.paper()
    shape = finray.solve(scene, [(80.0, 2.0, -20.0)])
    sensor = finray.Sensor(scene, "auto@-20", noise_mm=0.067)
    forces = sensor.sense(shape.observation())
    print(forces.force_n, forces.interval_n)

`python -m finray.live` senses forces in a camera's stream. `finray guide python` explains the package.
"""

from ._finray import (
    Alternative,
    FinrayError,
    Forces,
    Locator,
    Observation,
    Press,
    Refused,
    Scene,
    Sensor,
    Shape,
    StreamSensor,
    __version__,
    press,
    read_image,
    solve,
)

__all__ = [
    "Alternative",
    "FinrayError",
    "Forces",
    "Locator",
    "Observation",
    "Press",
    "Refused",
    "Scene",
    "Sensor",
    "Shape",
    "StreamSensor",
    "__version__",
    "press",
    "read_image",
    "solve",
]
