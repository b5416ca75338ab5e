#!/usr/bin/env python3
"""Compares every URDF below a folder with Pinocchio: five functions, floating and fixed base.

    python3 -m venv VENV && VENV/bin/pip install pin==4.1.0 example-robot-data numpy
    cargo build --release
    VENV/bin/python tests/oracle/compare_folder.py target/release/bipedc FOLDER [--states 4] [--markdown]

At random states (the seed is fixed) of each robot, inverse dynamics, mass matrix, forward dynamics and the derivatives of
both are computed by `bipedc evaluate` and by Pinocchio; a figure is the largest difference over the largest element of
Pinocchio's answer (of each of the three blocks of derivatives). Forward dynamics and its derivatives lose digits with the condition number of the mass matrix, which is
printed beside them: the bound is 1e-9. Where derivatives of forward dynamics differ by more, the
proof is that they differ by less than one rounding of the mass matrix may change them (its condition number times 2.2e-16),
and that bipedc's residual of the equation that defines them, M dq̈ + dτ = 0 with Pinocchio's M and dτ, is not above Pinocchio's.
Exit code 1 if a robot lies above without that proof. Robots that either side refuses are listed with its words.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import pinocchio as pin

SEED = 20261122
BOUND = 1e-9
FUNCTIONS = ["inverse_dynamics", "mass_matrix", "forward_dynamics", "inverse_dynamics_derivatives",
             "forward_dynamics_derivatives"]


class Oracle:
    """A URDF in Pinocchio, with the places of its joints by name."""

    def __init__(self, path, floating):
        root = [pin.JointModelFreeFlyer()] if floating else []
        self.model = pin.buildModelFromUrdf(str(path), *root)
        self.model.gravity.linear = np.array([0.0, 0.0, -9.81])
        self.data = self.model.createData()
        self.floating = floating
        first = 2 if floating else 1
        self.joints = [(self.model.names[k], self.model.joints[k]) for k in range(first, self.model.njoints)]

    def draw(self, random):
        """q, v, a, tau, and the same as a state of `bipedc evaluate`."""
        nv = self.model.nv
        q, (v, a, tau) = pin.neutral(self.model), (random.uniform(-2, 2, nv), random.uniform(-5, 5, nv),
                                                  random.uniform(-20, 20, nv))
        state = {"position": {}, "velocity": {}, "acceleration": {}, "effort": {}}
        if self.floating:
            q[:3] = random.uniform(-1, 1, 3)
            turn = random.normal(size=4)
            q[3:7] = turn / np.linalg.norm(turn)
            state["base"] = {
                "position": list(q[:3]), "orientation": list(q[3:7]),
                "linear_velocity": list(v[:3]), "angular_velocity": list(v[3:6]),
                "linear_acceleration": list(a[:3]), "angular_acceleration": list(a[3:6]),
                "force": list(tau[:3]), "torque": list(tau[3:6]),
            }
        for name, joint in self.joints:
            x = random.uniform(-2, 2)
            q[joint.idx_q:joint.idx_q + joint.nq] = [x] if joint.nq == 1 else [np.cos(x), np.sin(x)]
            state["position"][name] = x
            for key, values in (("velocity", v), ("acceleration", a), ("effort", tau)):
                state[key][name] = values[joint.idx_v]
        return (q, v, a, tau), state

    def answers(self, q, v, a, tau):
        """By function, in Pinocchio's order."""
        model, data = self.model, self.data
        mass = pin.crba(model, data, q).copy()
        mass = np.triu(mass) + np.triu(mass, 1).T
        pin.computeRNEADerivatives(model, data, q, v, a)
        inverse = [data.dtau_dq.copy(), data.dtau_dv.copy(), mass]
        pin.computeABADerivatives(model, data, q, v, tau)
        minverse = np.triu(data.Minv) + np.triu(data.Minv, 1).T
        forward = [data.ddq_dq.copy(), data.ddq_dv.copy(), minverse]
        acceleration = pin.aba(model, data, q, v, tau).copy()
        pin.computeRNEADerivatives(model, data, q, v, acceleration)
        driven = [data.dtau_dq.copy(), data.dtau_dv.copy(), -np.eye(model.nv)]
        return {
            "inverse_dynamics": pin.rnea(model, data, q, v, a).copy(),
            "mass_matrix": mass,
            "forward_dynamics": acceleration,
            "inverse_dynamics_derivatives": inverse,
            "forward_dynamics_derivatives": forward,
            "driven": driven,
        }

    def order(self, rows):
        """Places in Pinocchio's velocity of the rows that `bipedc` names."""
        places = {name: joint.idx_v for name, joint in self.joints}
        base = ["base/linear/x", "base/linear/y", "base/linear/z", "base/angular/x", "base/angular/y",
                "base/angular/z"]
        places.update({name: k for k, name in enumerate(base)})
        return np.array([places[row] for row in rows])


def evaluate(program, path, function, base, states):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(states, file)
        file.flush()
        command = [program, "evaluate", str(path), function, "--base", base, "--states", file.name, "--json"]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise RuntimeError(next((line for line in run.stderr.splitlines() if line.startswith("error")), run.stderr[:200]))
    return json.loads(run.stdout)


def difference(ours, theirs):
    """Largest difference of any block over the block's largest element, or a thousandth of the whole's: blocks of a
    robot whose torques do not depend on its position hold rounding alone."""
    worst, whole = 0.0, max(np.abs(other).max() for other in theirs)
    for mine, other in zip(ours, theirs):
        mine = np.array(mine, dtype=float)
        if not np.isfinite(mine).all():
            return np.inf
        worst = max(worst, np.abs(mine - other).max() / max(np.abs(other).max(), 1e-3 * whole))
    return worst


def residual(mass, change, driven):
    """Of M x + d = 0, column by column, over the sum of its terms' magnitudes; the worst column of all blocks."""
    worst = 0.0
    for x, d in zip(change, driven):
        size = np.abs(mass) @ np.abs(x) + np.abs(d)
        worst = max(worst, (np.abs(mass @ x + d).max(axis=0) / (size.max(axis=0) + 1e-12 * size.max())).max())
    return worst


def compare(program, path, floating, count):
    oracle = Oracle(path, floating)
    if oracle.model.nv == 0:
        raise RuntimeError("nothing moves")
    random = np.random.default_rng(SEED)
    drawn = [oracle.draw(random) for _ in range(count)]
    worst = dict.fromkeys(FUNCTIONS, 0.0)
    condition, residuals = 0.0, [0.0, 0.0]
    theirs = [oracle.answers(*state) for state, _ in drawn]
    for function in FUNCTIONS:
        answer = evaluate(program, path, function, "floating" if floating else "fixed", [s for _, s in drawn])
        order = oracle.order(answer["rows"])
        for values, answers in zip(answer["values"], theirs):
            values = np.array(values, dtype=float)
            expected = answers[function]
            if not isinstance(expected, list):
                blocks = [expected[np.ix_(order, order)] if expected.ndim == 2 else expected[order]]
                ours = [values]
            else:
                blocks = [block[np.ix_(order, order)] for block in expected]
                n = len(order)
                ours = [values[:, k * n:(k + 1) * n] for k in range(3)]
            worst[function] = max(worst[function], difference(ours, blocks))
            if function == "forward_dynamics_derivatives":
                mass, driven = answers["mass_matrix"][np.ix_(order, order)], [d[np.ix_(order, order)] for d in answers["driven"]]
                residuals = [max(a, residual(mass, x, driven)) for a, x in zip(residuals, (ours, blocks))]
    for answers in theirs:
        condition = max(condition, np.linalg.cond(answers["mass_matrix"]))
    return oracle.model.nv, condition, worst, residuals


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--states", type=int, default=4)
    parser.add_argument("--markdown", action="store_true", help="print the table of the documentation")
    parser.add_argument("--base", choices=["floating", "fixed"], help="this base alone")
    arguments = parser.parse_args()
    files = sorted(arguments.folder.rglob("*.urdf")) if arguments.folder.is_dir() else [arguments.folder]
    bad, proofs, refused, rows = [], [], {}, 0
    if arguments.markdown:
        print("| robot | base | degrees of freedom | condition | " + " | ".join(f"`{f}`" for f in FUNCTIONS) + " |")
        print("|---" * (4 + len(FUNCTIONS)) + "|")
    for path in files:
        name = str(path.relative_to(arguments.folder)) if arguments.folder.is_dir() else path.name
        for floating in [False, True]:
            base = "floating" if floating else "fixed"
            if arguments.base not in (None, base):
                continue
            try:
                nv, condition, worst, residuals = compare(arguments.program, path, floating, arguments.states)
            except Exception as error:  # noqa: BLE001: whatever either side says is listed
                refused.setdefault(name, str(error).strip().splitlines()[0][:160])
                continue
            rows += 1
            above = [f for f in FUNCTIONS if worst[f] > BOUND]
            excused = (above == ["forward_dynamics_derivatives"] and residuals[0] <= residuals[1]
                       and worst[above[0]] < 2.2e-16 * condition)
            wrong = bool(above) and not excused
            if above and not wrong:
                proofs.append(f"{name} ({base}): residuals {residuals[0]:.1e} (bipedc), {residuals[1]:.1e} (Pinocchio)")
            figures = [f"{worst[f]:.1e}" for f in FUNCTIONS]
            if arguments.markdown:
                print(f"| {name} | {base} | {nv} | {condition:.0e} | " + " | ".join(figures) + " |", flush=True)
            else:
                mark = "WRONG" if wrong else "ok"
                print(f"{mark:6} {name} {base} nv={nv} condition={condition:.0e} " + " ".join(figures), flush=True)
            if wrong:
                bad.append(f"{name} ({base})")
    print(f"\n{rows} models, {len(bad)} outside the bound" + "".join(f"\n  {x}" for x in bad))
    for proof in proofs:
        print(f"above 1e-9, within one rounding of the mass matrix: {proof}")
    for name, words in refused.items():
        print(f"not compared: {name}: {words}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
