"""Centre of mass of TUlip dropped and collapsing, by MuJoCo with stiff contacts: data/simulate/mujoco_tulip.json.

    pip install mujoco==4.0.0 && python tests/oracle/mujoco_tulip.py

Prints the rows; the file states the settings.
"""
import re
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
POSTURE = {"hip_pitch": -0.2, "knee_pitch": 0.4, "ankle_pitch": -0.2}


def model(friction, radius):
    """TUlip on a free base above a plane; only the corners of its soles touch."""
    text = (ROOT / "robots/tulip/robot.urdf").read_text()
    option = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'
    spec = mujoco.MjSpec.from_string(re.sub(r"(<robot[^>]*>)", r"\1" + option, text, count=1))
    spec.body("torso").add_freejoint()
    ground = spec.worldbody.add_geom()
    ground.type, ground.size, ground.condim = mujoco.mjtGeom.mjGEOM_PLANE, [5, 5, 1], 3
    ground.friction = [friction, 0, 0]
    for side in ("right", "left"):
        for x in (0.15, -0.09):
            for y in (0.06, -0.06):
                corner = spec.body(f"{side}_foot").add_geom()
                corner.type, corner.size = mujoco.mjtGeom.mjGEOM_SPHERE, [radius, 0, 0]
                corner.pos, corner.mass, corner.condim = [x, y, -0.055 + radius], 0, 3
                corner.friction, corner.contype, corner.conaffinity = [friction, 0, 0], 2, 1
    m = spec.compile()
    for i in range(m.ngeom):
        if m.geom_type[i] == mujoco.mjtGeom.mjGEOM_PLANE:
            m.geom_contype[i], m.geom_conaffinity[i] = 1, 2
        elif m.geom_contype[i] != 2:
            m.geom_contype[i] = m.geom_conaffinity[i] = 0
    m.jnt_limited[:] = 0
    m.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    m.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    m.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_OVERRIDE
    m.opt.tolerance, m.opt.iterations, m.opt.impratio = 1e-12, 200, 100
    return m


def run(m, clearance, tilt, stiffness, damping, step, impedance, time, every):
    m.opt.timestep, m.opt.o_solref[:] = step, [4 * step, 1.0]
    m.opt.o_solimp[:] = [*impedance, 0.0001, 0.5, 2]
    m.dof_damping[:6], m.dof_damping[6:] = 0, damping
    d = mujoco.MjData(m)
    for j in range(m.njnt):
        name = mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_JOINT, j) or ""
        for part, angle in POSTURE.items():
            if part in name:
                d.qpos[m.jnt_qposadr[j]] = angle
    d.qpos[3:7] = [np.cos(tilt / 2), 0, np.sin(tilt / 2), 0]
    mujoco.mj_forward(m, d)
    corners = [i for i in range(m.ngeom) if m.geom_contype[i] == 2]
    d.qpos[2] += clearance - min(d.geom_xpos[i][2] - m.geom_size[i][0] for i in corners)
    goal = d.qpos[7:].copy()
    for k in range(round(time / step) + 1):
        if k % round(every / step) == 0:
            look = mujoco.MjData(m)
            look.qpos[:] = d.qpos
            mujoco.mj_forward(m, look)
            print([round(k * step, 4), *(round(float(x), 6) for x in look.subtree_com[0])])
        d.qfrc_applied[6:] = stiffness * (goal - d.qpos[7:])
        mujoco.mj_step(m, d)


print("drop")
run(model(0.6, 0.002), 0.05, 0.0, 500, 5, 2.5e-5, [0.95, 0.99], 0.5, 0.1)
print("collapse")
run(model(2.0, 0.00002), 0.0, 0.1, 0, 0.1, 2.5e-5, [0.9999, 0.9999], 0.3, 0.05)
