#!/usr/bin/env python3
"""States with Pinocchio's torques for any URDF, in the format of `bipedc evaluate --states`.

    VENV/bin/python make_states.py OUTPUT_FOLDER [NAME=]URDF:BASE ...        BASE: floating or fixed
    VENV/bin/python make_states.py OUTPUT_FOLDER --list FILE                 one such word per line

For each URDF: `OUTPUT_FOLDER/<name>/robot.urdf` (a copy), `states.json` and `about.json`. `states.json` is an array of
states; beside the state itself each has `"expected": {"rows", "inverse_dynamics", "bias", "gravity", "kinetic_energy",
"potential_energy"}`, `"forward_dynamics"` where the mass matrix is safely positive definite (from `effort` and the base's
`force`, `torque`), and with a floating base `"center_of_mass"`. Joints that mimic others are treated as independent, as
Pinocchio does unless told otherwise; for URDFs in which such a joint moves, a second robot `<name>_nomimic` is
written, the same with `<mimic>` removed. A URDF that Pinocchio cannot read goes to `OUTPUT_FOLDER/_unread/<name>`
with the reason. `about.json` counts links and joints and lists what a careful reader may refuse or warn of.
"""
import json
import os
import re
import shutil
import sys
import tempfile
import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin

from make_reference import call, symmetric

SEED = 7
STATES = 4


def about(urdf, model, base):
    root = ET.parse(urdf).getroot()
    links = {l.get("name"): l for l in root.findall("link")}
    joints = root.findall("joint")
    kinds = [j.get("type") for j in joints]
    moving = [j for j in joints if j.get("type") != "fixed"]
    subtree = np.array([model.inertias[i].mass for i in range(model.njoints)])
    for i in range(model.njoints - 1, 0, -1):
        subtree[model.parents[i]] += subtree[i]
    children = {j.find("child").get("link") for j in joints}
    axes = [[float(x) for x in j.find("axis").get("xyz").split()] for j in moving
            if j.find("axis") is not None and j.find("axis").get("xyz")]
    return dict(
        base=base, root=[n for n in links if n not in children], links=len(links), moving_joints=len(moving),
        fixed_joints=kinds.count("fixed"), kinds=sorted(set(kinds)), mass=pin.computeTotalMass(model),
        nv=model.nv,
        moving_mimic=[j.get("name") for j in moving if j.find("mimic") is not None],
        fixed_mimic=[j.get("name") for j in joints if j.get("type") == "fixed" and j.find("mimic") is not None],
        unsupported_joints=[j.get("name") for j in joints
                            if j.get("type") not in ("fixed", "revolute", "continuous", "prismatic")],
        massless_moving_subtrees=[model.names[i] for i in range(1, model.njoints) if subtree[i] <= 0],
        links_without_inertial=sum(l.find("inertial") is None for l in links.values()),
        indefinite_inertias=[model.names[i] for i in range(1, model.njoints) if model.inertias[i].mass > 0
                             and np.linalg.eigvalsh(model.inertias[i].inertia)[0] < -1e-12],
        axes_not_unit=sum(abs(np.linalg.norm(a) - 1) > 1e-6 for a in axes),
        transmissions=len(root.findall("transmission")), meshes=len(root.findall(".//mesh")),
        gazebo=len(root.findall("gazebo")))


def states(model, base):
    rng = np.random.default_rng(SEED)
    head = 6 if base == "floating" else 0
    names = {i: model.names[i] for i in range(1, model.njoints) if model.names[i] != "root_joint"}
    rows = [f"base/{k}/{c}" for k in ("linear", "angular") for c in "xyz"][:head]
    order = sorted(names, key=lambda i: model.joints[i].idx_v)
    rows += [names[i] for i in order]
    assert len(rows) == model.nv
    out = []
    for _ in range(STATES):
        v, a, tau = rng.uniform(-2, 2, model.nv), rng.uniform(-5, 5, model.nv), rng.uniform(-20, 20, model.nv)
        q, position = np.zeros(model.nq), {}
        state = {}
        if base == "floating":
            q[:3] = rng.uniform(-1, 1, 3)
            quaternion = rng.normal(size=4)
            q[3:7] = quaternion / np.linalg.norm(quaternion)
            state["base"] = dict(position=q[:3], orientation=q[3:7], linear_velocity=v[:3], angular_velocity=v[3:6],
                                 linear_acceleration=a[:3], angular_acceleration=a[3:6], force=tau[:3], torque=tau[3:6])
        for i in order:
            joint, angle = model.joints[i], rng.uniform(-1.2, 1.2)
            position[names[i]] = angle
            if joint.nq == 2:  # a continuous joint: cosine, sine
                q[joint.idx_q:joint.idx_q + 2] = np.cos(angle), np.sin(angle)
            else:
                q[joint.idx_q] = angle
        by_name = lambda x: {names[i]: x[model.joints[i].idx_v] for i in order}
        state.update(position=position, velocity=by_name(v), acceleration=by_name(a), effort=by_name(tau))
        expected = dict(rows=rows, inverse_dynamics=call(pin.rnea, model, q, v, a),
                        bias=call(pin.nonLinearEffects, model, q, v),
                        gravity=call(pin.computeGeneralizedGravity, model, q),
                        kinetic_energy=call(pin.computeKineticEnergy, model, q, v),
                        potential_energy=call(pin.computePotentialEnergy, model, q))
        if base == "floating":
            expected["center_of_mass"] = call(pin.centerOfMass, model, q)
        # Massless moving parts have no forward dynamics.
        eigenvalues = np.linalg.eigvalsh(symmetric(call(pin.crba, model, q)))
        if np.all(eigenvalues > 1e-8 * np.max(eigenvalues, initial=0.0)):
            expected["forward_dynamics"] = call(pin.aba, model, q, v, tau)
        state["expected"] = expected
        out.append(state)
    return out


def write(path, value):
    with open(path, "w") as f:
        json.dump(value, f, indent=1, allow_nan=False, default=lambda x: x.tolist())
        f.write("\n")


def read(urdf, base):
    """The model, or the parser's complaints, which it writes to file descriptor 2."""
    with open(urdf, encoding="utf-8", errors="replace") as f:
        text = f.read()
    if re.search(r'<parent\s+link\s*=\s*"world"', text) and not re.search(r'<link\s+name\s*=\s*"world"', text):
        # An undeclared root link `world` is common; Pinocchio's parser wants it declared.
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as declared:
            declared.write(text.replace("</robot>", '<link name="world"/></robot>'))
            declared.flush()
            return read(declared.name, base)
    with tempfile.TemporaryFile() as complaints:
        stderr = os.dup(2)
        os.dup2(complaints.fileno(), 2)
        try:
            if base == "floating":
                return pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer()), None
            return pin.buildModelFromUrdf(urdf), None
        except Exception as error:
            complaints.seek(0)
            return None, f"{error}\n{complaints.read().decode()}"
        finally:
            os.dup2(stderr, 2)
            os.close(stderr)


def one(folder, name, urdf, base):
    target = os.path.join(folder, name)
    model, error = read(urdf, base)
    if model is None:
        target = os.path.join(folder, "_unread", name)
        os.makedirs(target, exist_ok=True)
        shutil.copyfile(urdf, os.path.join(target, "robot.urdf"))
        with open(os.path.join(target, "reason.txt"), "w") as f:
            f.write(error)
        return None
    facts = about(urdf, model, base)
    os.makedirs(target, exist_ok=True)
    if os.path.abspath(urdf) != os.path.abspath(os.path.join(target, "robot.urdf")):
        shutil.copyfile(urdf, os.path.join(target, "robot.urdf"))
    facts["source"] = urdf
    write(os.path.join(target, "about.json"), facts)
    if not facts["unsupported_joints"]:
        write(os.path.join(target, "states.json"), states(model, base))
    return facts


def main():
    folder, words = sys.argv[1], sys.argv[2:]
    if words[:1] == ["--list"]:
        with open(words[1]) as f:
            words = f.read().split()
    for word in words:
        urdf, base = word.rsplit(":", 1)
        name, _, urdf = urdf.rpartition("=")
        name = name or os.path.splitext(os.path.basename(urdf))[0]
        facts = one(folder, name, urdf, base)
        if facts and facts["moving_mimic"]:
            plain = os.path.join(folder, name + "_nomimic")
            os.makedirs(plain, exist_ok=True)
            with open(urdf, encoding="utf-8", errors="replace") as f:
                text = re.sub(r"<mimic\b[^>]*/>|<mimic\b.*?</mimic>", "", f.read(), flags=re.S)
            with open(os.path.join(plain, "robot.urdf"), "w", encoding="utf-8") as f:
                f.write(text)
            one(folder, name + "_nomimic", os.path.join(plain, "robot.urdf"), base)
        print(name, "unread" if facts is None else f"{facts['moving_joints']} joints", file=sys.stderr)


if __name__ == "__main__":
    main()
