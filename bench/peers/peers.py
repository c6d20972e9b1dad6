"""Times other programs on the tasks of finray's chart of time against error, in one run on one machine.

    python peers.py --finray ../../target/release/finray

The rows of other programs in fixtures/results/speed_error.csv are replaced; the bench speed_error writes finray's rows. Each program is optional: what
is not installed is left out with a note. See README.md.
"""
import argparse
import contextlib
import csv
import importlib.util
import io
import math
import os
import platform
import statistics
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}  # one core, as finray is timed

import numpy as np

FIXTURES = Path(__file__).resolve().parents[2] / "fixtures"
SCENE = FIXTURES / "scenes" / "paper.toml"
RESULTS = FIXTURES / "results" / "speed_error.csv"
REFERENCE_NODES, TRUTH_NODES = 4000, 684  # mesh nodes of the converged shapes, and of the frames' true shapes (the paper's fine mesh)
# Nodes, directions and forces are the same as in finray's own timings (bench/benches/speed_error.rs):
NODES, ANGLES_DEG, FORCE_N = range(14, 25), (-40.0, 0.0, 40.0), 3.0  # loads for which shapes are solved, N
SENSED_N, FRAMES_A_PERIOD, PERIODS = (0.3, 3.0), 25, 2               # range of an oscillating force, N; frames per period; periods
NOISE_MM, SEED = 0.067, 11
REPEATS = 5              # repetitions of every timed answer; the median is reported
SHORT_S = 1e-4           # answers shorter than this, s, are timed in batches of 1000
LONG_S = 0.05            # answers longer than this, s, are timed once; the median over all loads suffices
NETWORK = (46, 150, 200, 150, 1)


def module(name, path):
    """Imports a script of the fixtures under the given module name."""
    spec = importlib.util.spec_from_file_location(name, path)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


def timed(answer):
    """Returns an answer, and the median time to compute it, s."""
    start = time.perf_counter()
    found = answer()
    first = time.perf_counter() - start
    if first > LONG_S:
        return found, first
    many = 1000 if first < SHORT_S else 1
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        for _ in range(many):
            answer()
        times.append((time.perf_counter() - start) / many)
    return found, statistics.median(times)


def swing():
    """Force in each frame of a period, N."""
    low, high = SENSED_N
    return [(low + high) / 2 + (high - low) / 2 * math.sin(2 * math.pi * frame / FRAMES_A_PERIOD) for frame in range(FRAMES_A_PERIOD)]


class Cases:
    """Loads and frames, with finray's answers on its finest meshes."""

    def __init__(self, finray):
        self.finray = finray
        sys.path.insert(0, str(FIXTURES / "mujoco"))
        self.finger = module("finger", FIXTURES / "mujoco" / "finger.py").Finger("paper")
        self.loads = [(node, angle, FORCE_N) for node in NODES for angle in ANGLES_DEG]
        self.reference = [self.solve(*load, "--mesh-nodes", str(REFERENCE_NODES)) for load in self.loads]
        chance = np.random.default_rng(SEED)
        self.frames = []  # node, force (N), noisy displacements of the free nodes (mm)
        for node in NODES:
            exact = [self.solve(node, 0.0, force, "--mesh-nodes", str(TRUTH_NODES)) for force in swing()]
            for frame, force in enumerate(swing() * PERIODS):
                seen = exact[frame % FRAMES_A_PERIOD]
                self.frames.append((node, force, seen[1:-1, :2] + chance.normal(0.0, NOISE_MM, (len(seen) - 2, 2))))

    def solve(self, node, angle_deg, force_n, *options):
        """Displacements (mm) and rotations (rad) of the key nodes, one row (ux, uy, theta) each, computed by finray."""
        fx, fy = map(float, self.finger.force(force_n, angle_deg))
        command = [self.finray, "solve", SCENE, "--load", f"{node}:{fx!r},{fy!r}", *options]
        told = subprocess.run(command, capture_output=True, text=True, check=True)
        return np.array([[float(row[k]) for k in ("ux_mm", "uy_mm", "theta_rad")] for row in csv.DictReader(io.StringIO(told.stdout))])

    def shape_error(self, shapes):
        """Largest difference of a displacement from the reference, relative to the largest displacement."""
        worst = [np.linalg.norm((u - r)[:, :2], axis=1).max() / np.linalg.norm(r[:, :2], axis=1).max()
                 for u, r in zip(shapes, self.reference)]
        return max(worst)


def solved(cases, model, setting, solve):
    """Row of a solver `solve`, which is called with a node and the components of a force."""
    seconds, shapes = [], []
    for node, angle, size in cases.loads:
        shape, took = timed(lambda: solve(node, cases.finger.force(size, angle)))
        shapes.append(shape)
        seconds.append(took)
    return ["solve", model, setting, statistics.median(seconds), cases.shape_error(shapes)]


def opensees(cases):
    import openseespy.opensees as ops
    ops.logFile(os.devnull, "-noEcho")
    made = module("opensees_generate", FIXTURES / "opensees" / "generate.py")
    finger = made.Finger("paper")
    for mesh_nodes in (25, 684):
        made.build(finger, "corotational", mesh_nodes, made.STIFF, False)
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("UmfPack")
        ops.test("NormDispIncr", 1e-8, 50)
        ops.algorithm("Newton")
        ops.timeSeries("Linear", 1)

        def solve(node, force):
            for steps in (1, 2, 4, 8, 16):  # the fewest load steps with which Newton's method converges
                ops.reset()
                ops.remove("loadPattern", 1)
                ops.pattern("Plain", 1, 1)
                ops.load(node, *map(float, force), 0.0)
                ops.integrator("LoadControl", 1 / steps)
                ops.analysis("Static", "-noWarnings")
                if all(ops.analyze(1) == 0 for _ in range(steps)):
                    return np.array([ops.nodeDisp(tag) for tag in range(1, finger.last + 1)])
            raise RuntimeError(f"no equilibrium on {mesh_nodes} nodes")

        ops.pattern("Plain", 1, 1)
        yield solved(cases, "corotational frame", f"{mesh_nodes} nodes", solve)


def mujoco(cases):
    import mujoco as _  # reports a missing installation before the fixtures' modules are loaded
    statics = module("statics", FIXTURES / "mujoco" / "statics.py")
    for segments in (8, 16):
        finger, model = statics.model("paper", segments)

        def solve(node, force):
            angle = math.degrees(math.atan2(force @ finger.along, force @ finger.inward))
            shapes, _ = statics.path(finger, model, node, angle, [float(np.linalg.norm(force))])
            return shapes[0]

        yield solved(cases, "elastic rods, Newton in Python", f"{segments} segments a member", solve)


def stiffness(finger):
    """Stiffness matrix of the free key nodes (N/mm, N, N mm): plane Euler-Bernoulli beams, one per member."""
    k = np.zeros((3 * len(finger.places),) * 2)
    for member in finger.members:
        i, j = member.ends
        d = finger.places[j] - finger.places[i]
        length = math.hypot(*d)
        c, s = d / length
        turn = np.kron(np.eye(2), [[c, s, 0], [-s, c, 0], [0, 0, 1]])
        ea, ei = member.ea / length, member.ei / length**3
        local = np.zeros((6, 6))
        local[np.ix_([0, 3], [0, 3])] = ea * np.array([[1, -1], [-1, 1]])
        b = 6 * length
        local[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = ei * np.array(
            [[12, b, -12, b], [b, 4 * length**2, -b, 2 * length**2], [-12, -b, 12, -b], [b, 2 * length**2, -b, 4 * length**2]])
        at = [*range(3 * i, 3 * i + 3), *range(3 * j, 3 * j + 3)]
        k[np.ix_(at, at)] += turn.T @ local @ turn
    return k[3:-3, 3:-3]


def numpy(cases):
    finger = cases.finger
    k = stiffness(finger)

    def solve(node, force):
        f = np.zeros(len(k))
        f[3 * (node - 2) : 3 * (node - 2) + 2] = force
        return np.pad(np.linalg.solve(k, f).reshape(-1, 3), ((1, 1), (0, 0)))

    yield solved(cases, "linear beams, dense", f"{len(k)} x {len(k)} stiffness", solve)
    seconds, errors = [], []
    for node in NODES:
        unit = solve(node, finger.force(1.0, 0.0))[1:-1, :2].ravel()
        project = unit / (unit @ unit)  # pseudoinverse of a single column, prepared once
        for force, seen in ((force, seen) for at, force, seen in cases.frames if at == node):
            u = seen.ravel()
            sensed, took = timed(lambda: project @ u)
            errors.append(abs(sensed / force - 1))
            seconds.append(took)
    yield ["sense-one", "linear least squares", f"{finger.count} nodes", statistics.median(seconds), np.mean(errors)]


def weights():
    """Random weights of a network with the paper's widths; training would not change the time."""
    chance = np.random.default_rng(SEED)
    return [(chance.normal(0, i**-0.5, (o, i)).astype(np.float32), np.zeros(o, np.float32)) for i, o in zip(NETWORK, NETWORK[1:])]


def network_row(answer):
    return ["sense-one", "network, untrained", "-".join(map(str, NETWORK)), timed(answer)[1], ""]


def pytorch(_):
    import torch
    torch.set_num_threads(1)
    layers = []
    for w, b in weights():
        layer = torch.nn.Linear(w.shape[1], w.shape[0])
        layer.weight.data, layer.bias.data = torch.from_numpy(w), torch.from_numpy(b)
        layers += [layer, torch.nn.Tanh()]
    network, u = torch.nn.Sequential(*layers[:-1]).eval(), torch.ones(1, NETWORK[0])
    with torch.inference_mode():
        yield network_row(lambda: network(u))


def onnx_runtime(_):
    import onnxruntime
    from onnx import TensorProto, helper, numpy_helper
    nodes, constants, last = [], [], "u"
    for n, (w, b) in enumerate(weights()):
        constants += [numpy_helper.from_array(w, f"w{n}"), numpy_helper.from_array(b, f"b{n}")]
        nodes.append(helper.make_node("Gemm", [last, f"w{n}", f"b{n}"], [f"h{n}"], transB=1))
        last = f"h{n}"
        if n + 2 < len(NETWORK):
            nodes.append(helper.make_node("Tanh", [last], [f"t{n}"]))
            last = f"t{n}"
    ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, width]) for name, width in (("u", NETWORK[0]), (last, NETWORK[-1]))]
    graph = helper.make_graph(nodes, "network", ends[:1], ends[1:], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
    u = np.ones((1, NETWORK[0]), np.float32)
    yield network_row(lambda: session.run(None, {"u": u}))


PEERS = [("OpenSees", "openseespy", opensees), ("MuJoCo", "mujoco", mujoco), ("NumPy", "numpy", numpy),
         ("PyTorch", "torch", pytorch), ("ONNX Runtime", "onnxruntime", onnx_runtime)]


def machine():
    names = [line.split(":")[1].strip() for line in cpu_lines() if line.startswith("model name")]
    return f"{names[0] if names else platform.processor() or platform.machine()}, one core, Python {platform.python_version()}"


def cpu_lines():
    with contextlib.suppress(OSError):
        return Path("/proc/cpuinfo").read_text().splitlines()
    return []


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--finray", required=True, help="the finray binary, whose fine meshes are the reference")
    parser.add_argument("--out", default=RESULTS, help="table of times and errors, whose rows of other programs are replaced")
    arguments = parser.parse_args()
    cases, rows, note = Cases(arguments.finray), [], machine()
    for program, package, run in PEERS:
        try:
            for row in run(cases):
                task, model, setting, seconds, error = row
                by = f"{program} {metadata.version(package)}"
                rows.append({"task": task, "model": model, "setting": setting, "start": "none", "seconds": seconds, "error": error, "failed": 0,
                             "asked": 0, "timed_by": by, "machine": note})
                print(f"{program}: {row[1]}, {row[2]}: {row[3]:.3g} s, error {row[4] if row[4] == '' else format(row[4], '.3g')}", flush=True)
        except ImportError as error:
            print(f"left out: {program} ({error}; pip install -r requirements.txt)", file=sys.stderr)
        except Exception as error:  # a failing program does not lose the rows of the others
            print(f"left out: {program} ({type(error).__name__}: {error})", file=sys.stderr)
    with open(arguments.out, newline="") as file:
        table = csv.DictReader(file)
        columns, ours = table.fieldnames, [row for row in table if row["timed_by"] == "criterion"]
    with open(arguments.out, "w", newline="") as file:
        table = csv.DictWriter(file, columns, lineterminator="\n")
        table.writeheader()
        table.writerows([*ours, *rows])


if __name__ == "__main__":
    main()
