"""TUlip standing, dropped, collapsing and rocking, by MuJoCo with stiff contacts: data/simulate/mujoco_tulip.json.

    pip install mujoco==4.0.0 && python tests/oracle/mujoco_tulip.py > tests/data/simulate/mujoco_tulip.json

Minutes. Every case twice: contacts whose time constant is four steps, at steps of 1e-4 s and of 2.5e-5 s.
"""
import json
import re
import sys
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
KNEES = {"hip_pitch": -0.2, "knee_pitch": 0.4, "ankle_pitch": -0.2}
LEGS_APART = {"right_hip_roll": -0.3, "left_hip_roll": 0.3}
STEPS = [1e-4, 2.5e-5]
RADIUS = 2e-5


def model(friction):
    """TUlip on a free base above a plane; only the corners of its soles touch."""
    text = (ROOT / "robots/tulip/robot.urdf").read_text()
    option = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'
    spec = mujoco.MjSpec.from_string(re.sub(r"(<robot[^>]*>)", r"\1" + option, text, count=1))
    spec.body("torso").add_freejoint()
    ground = spec.worldbody.add_geom()
    ground.type, ground.size, ground.condim = mujoco.mjtGeom.mjGEOM_PLANE, [5, 5, 1], 3
    for side in ("right", "left"):
        for x in (0.15, -0.09):
            for y in (0.06, -0.06):
                corner = spec.body(f"{side}_foot").add_geom()
                corner.type, corner.size = mujoco.mjtGeom.mjGEOM_SPHERE, [RADIUS, 0, 0]
                corner.pos, corner.mass, corner.condim = [x, y, -0.055 + RADIUS], 0, 3
                corner.contype, corner.conaffinity = 2, 1
    m = spec.compile()
    for i in range(m.ngeom):
        if m.geom_type[i] == mujoco.mjtGeom.mjGEOM_PLANE:
            m.geom_contype[i], m.geom_conaffinity[i] = 1, 2
        elif m.geom_contype[i] != 2:
            m.geom_contype[i] = m.geom_conaffinity[i] = 0
    m.jnt_limited[:] = 0
    m.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    m.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    m.opt.tolerance, m.opt.iterations, m.opt.impratio = 1e-12, 200, 100
    # The override holds for friction too, which is 1 unless it is stated here.
    m.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_OVERRIDE
    m.opt.o_friction[:] = [friction, friction, 0, 0, 0]
    return m


def run(case, step):
    m = model(case["friction"])
    m.opt.timestep, m.opt.o_solref[:] = step, [4 * step, 3.0]
    m.opt.o_solimp[:] = [*case["impedance"], 0.0001, 0.5, 2]
    d = mujoco.MjData(m)
    stiffness, m.dof_damping[:] = np.zeros(12), 0
    for j in range(1, m.njnt):
        name = mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_JOINT, j)
        angle = [a for part, a in case["posture"].items() if part in name]
        d.qpos[m.jnt_qposadr[j]] = angle[0] if angle else 0.0
        free = "free" in case and case["free"] in name
        stiffness[j - 1] = case["free_stiffness"] if free else case["stiffness"]
        m.dof_damping[5 + j] = case["free_damping"] if free else case["damping"]
    half = 0.5 * np.array([case["roll"], case["tilt"]])
    d.qpos[3:7] = [np.cos(half[0]) * np.cos(half[1]), np.sin(half[0]), np.sin(half[1]), 0]
    assert abs(np.linalg.norm(d.qpos[3:7]) - 1) < 1e-12, "one rotation only"
    mujoco.mj_forward(m, d)
    corners = [i for i in range(m.ngeom) if m.geom_contype[i] == 2]
    d.qpos[2] += case["clearance"] - min(d.geom_xpos[i][2] - RADIUS for i in corners)
    goal, impulse, rows, force = d.qpos[7:].copy(), np.zeros(2), [], np.zeros(6)
    right = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_BODY, "right_foot")
    for k in range(round(case["time"] / step) + 1):
        if k % round(case["every"] / step) == 0:
            look = mujoco.MjData(m)
            look.qpos[:] = d.qpos
            mujoco.mj_forward(m, look)
            values = [k * step, *look.subtree_com[0], *impulse]
            rows.append([round(float(x), 7) for x in values])
        d.qfrc_applied[6:] = stiffness * (goal - d.qpos[7:])
        mujoco.mj_step(m, d)
        for i in range(d.ncon):
            mujoco.mj_contactForce(m, d, i, force)
            foot = m.geom_bodyid[max(d.contact[i].geom1, d.contact[i].geom2)]
            impulse[0 if foot == right else 1] += step * force[0]
    print(f"{case['name']}, step {step}: {rows[-1]}", file=sys.stderr, flush=True)
    return rows


PLAIN = {"posture": KNEES, "clearance": 0.0, "roll": 0.0, "tilt": 0.0, "stiffness": 500.0, "damping": 5.0, "friction": 0.6,
         "impedance": [0.95, 0.99]}
CASES = [
    {**PLAIN, "name": "standing", "time": 0.4, "every": 0.1},
    {**PLAIN, "name": "dropped", "clearance": 0.05, "time": 0.5, "every": 0.1},
    {**PLAIN, "name": "collapsing", "tilt": 0.1, "stiffness": 0.0, "damping": 0.1, "time": 0.3, "every": 0.05},
    {**PLAIN, "name": "rocking", "posture": LEGS_APART, "roll": 0.3, "stiffness": 800.0, "damping": 8.0, "friction": 0.8,
     "free": "ankle_roll", "free_stiffness": 5.0, "free_damping": 0.5, "time": 1.2, "every": 0.1},
]
answer = {
    "source": "MuJoCo 4.0.0, robots/tulip/robot.urdf with a free base; the eight sole corners are spheres of 0.02 mm, elliptic cones; "
    "contacts of a time constant of four steps, three times critically damped (less rebounds), solimp as `impedance` says, impratio 100; implicit joint damping",
    "posture": "joints whose name contains the key, others 0; explicit springs to the posture; `free` joints have their own",
    "units": "s, m, rad, N m/rad, N m s/rad; rows: time, centre of mass x y z, vertical impulse of the ground on right and left foot (N s)",
    "cases": [{**case, "runs": [{"step": step, "rows": run(case, step)} for step in STEPS]} for case in CASES],
}
print(json.dumps(answer, indent=1))
