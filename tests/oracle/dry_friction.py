"""Logs of an arm with dry friction, made with Pinocchio alone: `python dry_friction.py OUT` (needs `pin` and `numpy`).

Each joint follows a sum of sines; its effort is Pinocchio's inverse dynamics plus `torque * sign(v) + damping * v`, with white noise on
positions and efforts. What the joints were given stands in `truth.json`.
"""
import gzip
import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin

ARM = Path(__file__).parent.parent / "data/identify/arm/robot.urdf"
JOINTS = ["shoulder", "elbow"]
RATE, TIME = 500, 10.0
# Coulomb (N m) and viscous friction (N m s/rad) by joint, and the highest frequency of the motion (Hz).
CASES = [
    {"coulomb": [1.5, 0.6], "viscous": [0.0, 0.3], "highest": 0.6},
    {"coulomb": [0.3, 2.0], "viscous": [0.5, 0.0], "highest": 1.2},
    {"coulomb": [1.5, 0.6], "viscous": [0.0, 0.3], "highest": 2.5},
    {"coulomb": [0.3, 2.0], "viscous": [0.5, 0.0], "highest": 0.6},
    {"coulomb": [1.0, 1.0], "viscous": [0.2, 0.1], "highest": 1.8},
]

model = pin.buildModelFromUrdf(str(ARM))
data = model.createData()
out = Path(sys.argv[1])
for seed, case in enumerate(CASES):
    random = np.random.default_rng(seed)
    time = np.arange(round(TIME * RATE)) / RATE
    q, v, a = (np.zeros((len(time), 2)) for _ in range(3))
    for joint in range(2):
        for _ in range(5):
            frequency = 0.1 + (case["highest"] - 0.1) * random.random()
            size, phase, rate = 0.5 * random.random() / (1 + frequency), 2 * np.pi * random.random(), 2 * np.pi * frequency
            q[:, joint] += size * np.sin(rate * time + phase)
            v[:, joint] += size * rate * np.cos(rate * time + phase)
            a[:, joint] -= size * rate**2 * np.sin(rate * time + phase)
    effort = np.array([pin.rnea(model, data, *state) for state in zip(q, v, a)])
    effort += np.sign(v) * case["coulomb"] + v * case["viscous"]
    q += 1e-4 * random.standard_normal(q.shape)
    effort += 0.05 * random.standard_normal(q.shape)
    head = ["time"] + [f"{joint}/{what}" for joint in JOINTS for what in ("position", "effort")]
    rows = np.column_stack([time, q[:, 0], effort[:, 0], q[:, 1], effort[:, 1]])
    lines = [",".join(head)] + [f"{r[0]:.3f},{r[1]:.5f},{r[2]:.3f},{r[3]:.5f},{r[4]:.3f}" for r in rows]
    with open(out / f"{seed}.csv.gz", "wb") as file:
        file.write(gzip.compress(("\n".join(lines) + "\n").encode(), 9, mtime=0))
(out / "truth.json").write_text(json.dumps({"source": f"Pinocchio {pin.__version__}", "joints": JOINTS, "cases": CASES}, indent=1) + "\n")
