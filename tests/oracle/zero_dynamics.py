"""Steps of the thesis' gaits on their zero dynamics, to thirty digits (pip install mpmath==1.3.0).

    python zero_dynamics.py > ../data/gaits/zero_dynamics.json

Nothing of bipedc takes part. Bodies of a planar robot are described by absolute angles (from foot to hip or hip to head, forward
positive); the angular momentum about the foot is summed body by body, gravity's moment is that of the centre of mass, the impact is
solved in hip coordinates, h_p is the cubic of its four conditions. The masses are those of the robots' URDFs (the legs of three_link
without their 1e-4 kg m2).
"""
import json

from mpmath import mp, mpf, asin, cos, findroot, matrix, lu_solve, quad, sin, sqrt, diff

mp.dps = 30

# A body: mass, inertia about its centre, and how far along each absolute angle its centre lies from the hip. Angles: torso, then thigh
# and shank (or leg) of the stance side, then of the swing side. The last number of a leg is where its foot is.
THREE = {
    "g": mpf("9.8"),
    "bodies": [
        (25, mpf("1.5"), [mpf("0.2"), 0, 0]),
        (5, mpf(0), [0, mpf("-0.5"), 0]),
        (5, mpf(0), [0, 0, mpf("-0.5")]),
    ],
    "feet": ([0, -1, 0], [0, 0, -1]),
    "swap": [0, 2, 1],
    "length": mpf(1),
}
FEMUR, TIBIA = mpf("0.4"), mpf("0.4")
FIVE = {
    "g": mpf("9.81"),
    "bodies": [
        (12, mpf("1.33"), [mpf("0.24"), 0, 0, 0, 0]),
        (mpf("6.8"), mpf("0.47"), [0, mpf("-0.11"), 0, 0, 0]),
        (mpf("3.2"), mpf("0.2"), [0, -FEMUR, mpf("-0.24"), 0, 0]),
        (mpf("6.8"), mpf("0.47"), [0, 0, 0, mpf("-0.11"), 0]),
        (mpf("3.2"), mpf("0.2"), [0, 0, 0, -FEMUR, mpf("-0.24")]),
    ],
    "feet": ([0, -FEMUR, -TIBIA, 0, 0], [0, 0, 0, -FEMUR, -TIBIA]),
    "swap": [0, 3, 4, 1, 2],
    "length": FEMUR + TIBIA,
}


def place(arms, angles):
    """From the hip: x and z."""
    return (sum(a * sin(t) for a, t in zip(arms, angles)), sum(a * cos(t) for a, t in zip(arms, angles)))


def speed(arms, angles, rates):
    return (
        sum(a * cos(t) * r for a, t, r in zip(arms, angles, rates)),
        -sum(a * sin(t) * r for a, t, r in zip(arms, angles, rates)),
    )


def momentum(robot, angles, rates):
    """Angular momentum about the stance foot, which stands still."""
    foot = robot["feet"][0]
    total = mpf(0)
    for index, (m, inertia, arms) in enumerate(robot["bodies"]):
        arm = [a - f for a, f in zip(arms, foot)]
        (x, z), (vx, vz) = place(arm, angles), speed(arm, angles, rates)
        total += m * (z * vx - x * vz) + inertia * rates[index]
    return total


def gravity(robot, angles):
    """gamma: minus the moment of gravity about the foot."""
    foot = robot["feet"][0]
    moment = mpf(0)
    for m, _, arms in robot["bodies"]:
        moment += m * place([a - f for a, f in zip(arms, foot)], angles)[0]
    return -robot["g"] * moment


def impact(robot, angles, rates):
    """Rates after the swing foot has struck and the legs have swapped; impulse on it (x, z)."""
    n = len(angles)
    hip = [-v for v in speed(robot["feet"][0], angles, rates)]
    before = matrix(hip + list(rates))
    mass = matrix(n + 2, n + 2)
    columns = lambda arms: [[1, 0], [0, 1]] + [[a * cos(t), -a * sin(t)] for a, t in zip(arms, angles)]
    for index, (m, inertia, arms) in enumerate(robot["bodies"]):
        c = columns(arms)
        for i in range(n + 2):
            for j in range(n + 2):
                mass[i, j] += m * (c[i][0] * c[j][0] + c[i][1] * c[j][1])
        mass[index + 2, index + 2] += inertia
    foot = columns(robot["feet"][1])
    system = matrix(n + 4, n + 4)
    right = matrix(n + 4, 1)
    momenta = mass * before
    for i in range(n + 2):
        right[i] = momenta[i]
        for j in range(n + 2):
            system[i, j] = mass[i, j]
        for k in range(2):
            system[i, n + 2 + k] = -foot[i][k]
            system[n + 2 + k, i] = foot[i][k]
    after = lu_solve(system, right)
    return [after[2 + s] for s in robot["swap"]], [after[n + 2], after[n + 3]]


def three_link(p):
    end = asin(p["step_length"] / 2)
    names = ["torso", "swing"]
    read = lambda angles: (angles[1], [angles[0], angles[2]])
    wanted = lambda phi: [-p["torso_lean"], -phi]
    build = lambda phi, h: [h[0], phi, h[1]]
    return THREE, end, read, wanted, build, len(names)


def five_link(p):
    end = asin(p["step_length"] / (4 * FEMUR))
    # Absolute angles to: line of the stance leg; torso, stance knee, line of the swing leg, swing knee.
    read = lambda t: ((t[1] + t[2]) / 2, [t[0], t[2] - t[1], (t[3] + t[4]) / 2, t[4] - t[3]])
    bend = lambda phi: p["knee"] * (1 - (phi / end) ** 2) ** 2
    wanted = lambda phi: [p["torso_lean"], bend(phi), -phi, bend(phi)]
    build = lambda phi, h: [h[0], phi - h[1] / 2, phi + h[1] / 2, h[2] - h[3] / 2, h[2] + h[3] / 2]
    return FIVE, end, read, wanted, build, 4


def slope(f, x):
    """All derivatives here are of smooth functions, by mpmath's differences at twice the digits."""
    return diff(f, x)


def cubic(start, end, value, rate):
    """c0 + c1 x + c2 x2 + c3 x3 with this value and slope at the start and none at the end."""
    rows = []
    for x in (start, end):
        rows.append([1, x, x**2, x**3])
        rows.append([0, 1, 2 * x, 3 * x**2])
    c = lu_solve(matrix(rows), matrix([value, rate, 0, 0]))
    return lambda x: c[0] + x * (c[1] + x * (c[2] + x * c[3]))


def landing(gait):
    """End of a step at unit speed."""
    robot, end, read, wanted, build, count = gait
    angles = build(end, wanted(end))
    rates = [slope(lambda x, i=i: build(x, wanted(x))[i], end) for i in range(len(angles))]
    after, impulse = impact(robot, angles, rates)
    swapped = [angles[s] for s in robot["swap"]]
    start, outputs = read(swapped)
    eta, output_rates = read(after)
    before = momentum(robot, angles, rates)
    sigma = momentum(robot, swapped, after)
    return {
        "start": start, "eta": eta, "outputs": outputs, "rates": [r / eta for r in output_rates],
        "before": before, "after": sigma, "delta": (sigma / before) ** 2, "impulse": impulse,
    }


def course(gait, entry):
    robot, end, read, wanted, build, count = gait
    start = entry["start"]
    polynomials = []
    for i in range(count):
        h = lambda x, i=i: wanted(x)[i]
        polynomials.append(cubic(start, end, entry["outputs"][i] - h(start), entry["rates"][i] - slope(h, start)))
    angles = lambda phi: build(phi, [h + c(phi) for h, c in zip(wanted(phi), polynomials)])
    rates = lambda phi: [slope(lambda x, i=i: angles(x)[i], phi) for i in range(len(robot["bodies"]))]
    alpha = lambda phi: momentum(robot, angles(phi), rates(phi))
    gamma = lambda phi: gravity(robot, angles(phi))
    pieces = [start + (end - start) * k / 4 for k in range(5)]
    potential = lambda phi: quad(lambda s: alpha(s) * gamma(s), [x for x in pieces if x < phi] + [phi])
    p_minus = potential(end)
    # Where gamma changes sign from above to below; else an end.
    samples = [start + (end - start) * k / 64 for k in range(65)]
    values = [gamma(s) for s in samples]
    best = (mpf(0), start) if p_minus <= 0 else (p_minus, end)
    for k in range(64):
        if values[k] > 0 >= values[k + 1]:
            phi = findroot(gamma, (samples[k], samples[k + 1]), solver="anderson", tol=mpf(10) ** -50)
            best = max(best, (potential(phi), phi))
    return {"alpha": alpha, "gamma": gamma, "angles": angles, "start": start, "end": end, "p_minus": p_minus,
            "p_max": best[0], "phi_m": best[1], "alpha_m": alpha(best[1]), "potential": potential, "robot": robot}


def forces(c, energy, phi):
    """Force on the foot that stands, from the motion of the centre of mass."""
    robot, foot = c["robot"], c["robot"]["feet"][0]
    mass = sum(m for m, _, _ in robot["bodies"])
    def centre(axis):
        return lambda x: sum(m * place([a - f for a, f in zip(arms, foot)], c["angles"](x))[axis]
                             for m, _, arms in robot["bodies"]) / mass
    rate = sqrt(2 * (energy - c["potential"](phi))) / c["alpha"](phi)
    bend = (-c["gamma"](phi) - diff(c["alpha"], phi) * rate**2) / c["alpha"](phi)
    a = [diff(centre(k), phi, 2) * rate**2 + diff(centre(k), phi) * bend for k in (0, 1)]
    return [mass * a[0], mass * (a[1] + robot["g"])]


def case(name, make, speed, to, before=None):
    before = before or to
    now_gait, next_gait = make(before), make(to)
    entry = landing(now_gait)
    now = course(now_gait, entry)
    then = course(next_gait, entry)
    energy = (now["alpha_m"] * speed) ** 2 / 2 + now["p_max"]
    next_energy = entry["delta"] * (energy - now["p_minus"])
    kinetic = next_energy - then["p_max"]
    own = landing(next_gait)
    steady = course(next_gait, own)
    limit = steady["p_minus"] * own["delta"] / (own["delta"] - 1) - steady["p_max"]
    found = lambda k, c: float(sqrt(2 * k) / c["alpha_m"]) if k > 0 else None
    places = [then["start"] + (then["end"] - then["start"]) * k / 10 for k in (1, 4, 8)]
    return {
        "robot": name, "speed": float(speed),
        "set": {k: float(v) for k, v in to.items()}, "from": {k: float(v) for k, v in before.items()},
        "next_speed": found(kinetic, then), "delta": float(entry["delta"]), "eta": float(entry["eta"]),
        "p_minus": float(then["p_minus"]), "p_max": float(then["p_max"]), "phi_m": float(then["phi_m"]),
        "phi_end": float(then["end"]), "limit_speed": found(limit, steady) if own["delta"] < 1 else None,
        "this_step": {"p_minus": float(now["p_minus"]), "p_max": float(now["p_max"]), "phi_m": float(now["phi_m"])},
        "energy": float(energy), "next_energy": float(next_energy),
        "courses": [{"phase": float(x), "alpha": float(then["alpha"](x)), "gamma": float(then["gamma"](x)),
                     "potential": float(then["potential"](x)),
                     "force": [float(f) for f in forces(then, next_energy, x)] if kinetic > 0 else None}
                    for x in places],
    }


def main():
    n = lambda **p: {k: mpf(v) for k, v in p.items()}
    three = lambda s, lean: n(step_length=s, torso_lean=lean)
    five = lambda s, lean, knee: n(step_length=s, torso_lean=lean, knee=knee)
    cases = [
        case("three_link", three_link, mpf("1.5"), three("0.5", "-0.5")),
        case("three_link", three_link, mpf("2"), three("0.7", "-0.8")),
        case("three_link", three_link, mpf("0.8"), three("0.3", "0.2")),
        case("three_link", three_link, mpf("1.2"), three("0.9", "-0.2")),
        case("three_link", three_link, mpf("3"), three("1.2", "-1.5")),
        # The dead centre at the beginning of the step, and at its end.
        case("three_link", three_link, mpf("2.5"), three("0.1", "-1.2")),
        case("three_link", three_link, mpf("2.5"), three("0.1", "0.8")),
        case("three_link", three_link, mpf("1.5"), three("0.6", "-0.3"), three("0.4", "-0.6")),
        case("three_link", three_link, mpf("1.8"), three("0.3", "-0.3"), three("0.8", "-0.3")),
        case("five_link", five_link, mpf("2"), five("0.4", "0.2", "0.3")),
        case("five_link", five_link, mpf("1.5"), five("0.3", "0.4", "0.15")),
        case("five_link", five_link, mpf("1"), five("0.5", "0.6", "0.5")),
        case("five_link", five_link, mpf("3"), five("0.6", "-0.1", "0.4")),
        case("five_link", five_link, mpf("1.7"), five("0.35", "0.3", "0.2"), five("0.45", "0.1", "0.4")),
    ]
    print(json.dumps({"generator": "mpmath, 30 digits", "cases": cases}, indent=1))


if __name__ == "__main__":
    main()
