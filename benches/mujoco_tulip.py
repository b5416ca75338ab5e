"""MuJoCo on the tasks of `benches/simulate.rs`: TUlip, 1 kHz, its own loop (mj_step with `nstep`), processor time, best of several.

    pip install mujoco==4.0.0 && python benches/mujoco_tulip.py STEPS REPEATS

Prints a line per task: name, microseconds of processor time per step. Settings are MuJoCo's defaults; joint springs and dampers are those of the
model, so that no Python runs between steps.
"""
import re
import sys
import time
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
POSTURE = {"hip_pitch": -0.2, "knee_pitch": 0.4, "ankle_pitch": -0.2}
FRICTION = 0.6


def model():
    """TUlip on a free base above a plane; only the corners of its soles touch."""
    text = (ROOT / "robots/tulip/robot.urdf").read_text()
    option = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'
    spec = mujoco.MjSpec.from_string(re.sub(r"(<robot[^>]*>)", r"\1" + option, text, count=1))
    spec.body("torso").add_freejoint()
    for body in spec.bodies:
        for geom in list(body.geoms):
            geom.contype = geom.conaffinity = 0
    ground = spec.worldbody.add_geom()
    ground.type, ground.size, ground.condim = mujoco.mjtGeom.mjGEOM_PLANE, [5, 5, 1], 3
    ground.contype, ground.conaffinity, ground.friction = 1, 2, [FRICTION, 0, 0]
    for side in ("right", "left"):
        for x in (0.15, -0.09):
            for y in (0.06, -0.06):
                corner = spec.body(f"{side}_foot").add_geom()
                corner.type, corner.size = mujoco.mjtGeom.mjGEOM_SPHERE, [0.005, 0, 0]
                corner.pos, corner.mass, corner.condim = [x, y, -0.05], 0, 3
                corner.contype, corner.conaffinity, corner.friction = 2, 1, [FRICTION, 0, 0]
    m = spec.compile()
    m.jnt_limited[:] = 0
    m.opt.timestep = 1e-3
    return m


def prepare(clearance, tilt, stiffness, damping, dry):
    m = model()
    m.dof_damping[6:], m.dof_frictionloss[6:], m.jnt_stiffness[1:] = damping, dry, stiffness
    d = mujoco.MjData(m)
    for j in range(1, m.njnt):
        name = mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_JOINT, j)
        d.qpos[m.jnt_qposadr[j]] = next((a for part, a in POSTURE.items() if part in name), 0.0)
    m.qpos_spring[7:] = d.qpos[7:]
    d.qpos[3:7] = [np.cos(tilt / 2), 0, np.sin(tilt / 2), 0]
    mujoco.mj_forward(m, d)
    low = min(d.geom_xpos[i][2] - m.geom_size[i][0] for i in range(m.ngeom) if m.geom_contype[i] == 2)
    d.qpos[2] += clearance - low
    return m, d, d.qpos.copy()


def main():
    steps, repeats = int(sys.argv[1]), int(sys.argv[2])
    cases = [
        ("standing", (0.0, 0.0, 500, 5, 0.0)),
        ("standing, dry joints", (0.0, 0.0, 500, 5, 0.5)),
        ("dropped", (0.1, 0.05, 500, 5, 0.0)),
        ("collapsing", (0.0, 0.1, 0, 0.1, 0.0)),
    ]
    for name, case in cases:
        m, d, start = prepare(*case)
        best = np.inf
        for _ in range(repeats):
            mujoco.mj_resetData(m, d)
            d.qpos[:] = start
            begun = time.process_time()
            mujoco.mj_step(m, d, nstep=steps)
            best = min(best, time.process_time() - begun)
        print(f"{name}\t{1e6 * best / steps:.3f}", flush=True)


main()
