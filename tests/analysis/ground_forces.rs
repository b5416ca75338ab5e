//! How two feet share the ground's force, against the same quadratic program written by hand and solved by clarabel.
use bipedc_lapack as _;
use bipedc_runtime::walking::ground_forces::{Limits, Shared, StandingFoot, share_certified};
use bipedc_runtime::walking::space::{Pose, Turn, about_z, product};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

/// Random numbers in -1 to 1, the same every time (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * 0.5 * (1.0 + self.next())
    }
}

const JOINTS: usize = 6;
/// How much more what is missing counts than the distribution.
const MISSING: f64 = 1e4;

/// A robot of some weight on two feet.
struct Posture {
    soles: [Pose<f64>; 2],
    extent: [f64; 4],
    jacobian: [[[f64; 6]; JOINTS]; 2],
    shares: [f64; 2],
    required: [f64; 6],
    friction: f64,
    turning: f64,
    least: f64,
    torques: [f64; 2 * JOINTS],
    limits: [f64; 2 * JOINTS],
}

/// About x by a small angle.
fn tilted(angle: f64) -> Turn<f64> {
    let (s, c) = angle.sin_cos();
    [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
}

impl Posture {
    /// Feet beside one another somewhere, tilted a little; the required wrench is what random loads give.
    fn random(n: &mut Numbers) -> Self {
        let weight = n.between(50.0, 800.0);
        let place = [3.0 * n.next(), 3.0 * n.next()];
        let mut sole = |side: f64| Pose {
            position: [place[0] + 0.2 * n.next(), place[1] + side * n.between(0.08, 0.2), 0.05 * n.next()],
            turn: product(about_z(0.5 * n.next()), tilted(0.1 * n.next())),
        };
        let soles = [sole(-1.0), sole(1.0)];
        let extent =
            [-n.between(0.06, 0.12), n.between(0.08, 0.15), -n.between(0.03, 0.06), n.between(0.03, 0.06)];
        let jacobian = [(); 2].map(|()| {
            [(); JOINTS].map(|()| std::array::from_fn(|k| if k < 3 { 0.4 } else { 1.0 } * n.next()))
        });
        let share = n.between(0.02, 0.98);
        // Beyond the soles now and then.
        let beyond = n.between(0.3, 1.1);
        let mut required = [0.0; 6];
        for (sole, part) in soles.iter().zip([share + 0.2 * n.next(), 1.0 - share]) {
            let load = weight * part.clamp(0.02, 1.0);
            let point = Vector3::new(
                beyond * if n.next() > 0.0 { extent[1] } else { extent[0] } * n.next().abs(),
                beyond * if n.next() > 0.0 { extent[3] } else { extent[2] } * n.next().abs(),
                0.0,
            );
            let force = Vector3::new(0.3 * beyond * load * n.next(), 0.3 * beyond * load * n.next(), load);
            let place = Vector3::from(sole.position) + matrix(sole.turn) * point;
            let moment = place.cross(&force) + Vector3::z() * (0.02 * load * n.next());
            for k in 0..3 {
                required[k] += force[k];
                required[3 + k] += moment[k];
            }
        }
        let torques = std::array::from_fn(|_| 0.1 * weight * n.next());
        // From drives that cannot hold the legs to strong ones.
        let strength = if n.next() > 0.8 { 0.1 } else { n.between(0.2, 0.8) };
        let limits = std::array::from_fn(|_| weight * strength * n.between(0.3, 1.0));
        let (friction, turning) = (n.between(0.3, 0.9), n.between(0.02, 0.1));
        let shares = [share, 1.0 - share];
        Self {
            soles,
            extent,
            jacobian,
            shares,
            required,
            friction,
            turning,
            least: 0.01 * weight,
            torques,
            limits,
        }
    }

    /// Verdict, torques, wrenches.
    fn shared(&self) -> (Shared<f64>, [f64; 2 * JOINTS], [[f64; 6]; 2]) {
        let joints: [usize; 2 * JOINTS] = std::array::from_fn(|k| k);
        let feet: [StandingFoot<'_, f64>; 2] = std::array::from_fn(|k| StandingFoot {
            sole: self.soles[k],
            extent: self.extent,
            joints: &joints[k * JOINTS..(k + 1) * JOINTS],
            jacobian: &self.jacobian[k],
            share: self.shares[k],
        });
        let Self { friction, turning, least: least_load, limits, .. } = self;
        let limits =
            Limits { friction: *friction, turning: *turning, least_load: *least_load, torque: limits };
        let (mut torques, mut wrenches) = (self.torques, [[0.0; 6]; 2]);
        let (found, certificate) =
            share_certified(&feet, self.required, &limits, &mut torques, &mut wrenches);
        assert!(certificate.holds_within(1e-9), "{certificate:?}");
        (found, torques, wrenches)
    }
}

fn matrix(rows: Turn<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// The program in unknowns x: wrench in axes of the sole = scale x; least |x − start|², A x = b, G x ≤ h.
struct Program {
    /// From x to both wrenches in the world, about the origins of the soles.
    to_world: SMatrix<f64, 12, 12>,
    start: SMatrix<f64, 12, 1>,
    a: SMatrix<f64, 6, 12>,
    b: SMatrix<f64, 6, 1>,
    g: Vec<[f64; 12]>,
    h: Vec<f64>,
    /// The first so many limits are those of the ground.
    ground: usize,
}

impl Program {
    fn of(posture: &Posture) -> Self {
        let [rear, front, right, left] = posture.extent;
        let [width, length] = [(left - right) / 2.0, (front - rear) / 2.0];
        let force = Vector3::from_column_slice(&posture.required[..3]);
        let moment = Vector3::from_column_slice(&posture.required[3..]);
        let weight = force.norm();
        let middle =
            (Vector3::from(posture.soles[0].position) + Vector3::from(posture.soles[1].position)) / 2.0;
        let (mut to_world, mut start) = (SMatrix::<f64, 12, 12>::zeros(), SMatrix::<f64, 12, 1>::zeros());
        let mut a = SMatrix::<f64, 6, 12>::zeros();
        let (mut g, mut h) = (Vec::new(), Vec::new());
        for k in 0..2 {
            let (turn, share, first) = (matrix(posture.soles[k].turn), posture.shares[k], 6 * k);
            let scale = [1.0, 1.0, 1.0, width, length, length].map(|x| x * weight * share.sqrt());
            for i in 0..3 {
                for j in 0..3 {
                    to_world[(first + i, first + j)] = turn[(i, j)] * scale[j];
                    to_world[(first + 3 + i, first + 3 + j)] = turn[(i, j)] * scale[3 + j];
                }
            }
            let own = turn.transpose() * force * share;
            let planned =
                [own.x, own.y, own.z, own.z * (left + right) / 2.0, -own.z * (front + rear) / 2.0, 0.0];
            (0..6).for_each(|i| start[first + i] = planned[i] / scale[i]);
            let arm = (Vector3::from(posture.soles[k].position) - middle).cross_matrix();
            let mut to_middle = SMatrix::<f64, 6, 6>::identity();
            to_middle.fixed_view_mut::<3, 3>(3, 0).copy_from(&arm);
            let part = to_middle * to_world.fixed_view::<6, 6>(first, first);
            a.fixed_view_mut::<6, 6>(0, first).copy_from(&part);
            let mut limit = |pairs: &[(usize, f64)], bound: f64| {
                let mut row = [0.0; 12];
                pairs.iter().for_each(|(i, factor)| row[first + i] += factor * scale[*i]);
                g.push(row);
                h.push(bound);
            };
            limit(&[(2, -1.0)], -posture.least.min(own.z.max(0.0)));
            let (mu, turning) = (posture.friction, posture.turning);
            for sign in [1.0, -1.0] {
                limit(&[(0, sign), (2, -mu)], 0.0);
                limit(&[(1, sign), (2, -mu)], 0.0);
                limit(&[(5, sign), (2, -turning)], 0.0);
            }
            limit(&[(3, 1.0), (2, -left)], 0.0);
            limit(&[(3, -1.0), (2, right)], 0.0);
            limit(&[(4, -1.0), (2, -front)], 0.0);
            limit(&[(4, 1.0), (2, rear)], 0.0);
        }
        let ground = g.len();
        for (joint, limit) in posture.limits.iter().enumerate() {
            let column =
                SMatrix::<f64, 1, 6>::from_row_slice(&posture.jacobian[joint / JOINTS][joint % JOINTS]);
            let first = 6 * (joint / JOINTS);
            let part = column * to_world.fixed_view::<6, 6>(first, first);
            for sign in [1.0, -1.0] {
                let mut row = [0.0; 12];
                (0..6).for_each(|i| row[first + i] = -sign * part[i]);
                g.push(row);
                h.push(limit - sign * posture.torques[joint]);
            }
        }
        let lever = weight * length;
        let about = moment - middle.cross(&force);
        let mut b = SMatrix::<f64, 6, 1>::zeros();
        for i in 0..3 {
            b[i] = force[i] / weight;
            b[3 + i] = about[i] / lever;
        }
        for mut row in a.row_iter_mut().take(3) {
            row /= weight;
        }
        for mut row in a.row_iter_mut().skip(3) {
            row /= lever;
        }
        Self { to_world, start, a, b, g, h, ground }
    }

    /// x by clarabel; `None`: there is none. With `missing` the equations are part of what is least; the first `limits` of the limits hold.
    fn solve(&self, missing: bool, limits: usize) -> Result<Option<SMatrix<f64, 12, 1>>, Undecided> {
        let (mut p, mut q) = (SMatrix::<f64, 12, 12>::identity(), -self.start);
        if missing {
            p += MISSING * self.a.transpose() * self.a;
            q -= MISSING * self.a.transpose() * self.b;
        }
        let (mut rows, mut right, mut cones) = (Vec::new(), Vec::new(), Vec::new());
        if !missing {
            rows.extend(self.a.row_iter().map(|row| row.iter().copied().collect::<Vec<_>>()));
            right.extend(self.b.iter());
            cones.push(SupportedConeT::ZeroConeT(6));
        }
        let equations = rows.len();
        for (row, bound) in self.g.iter().zip(&self.h).take(limits) {
            let length = row.iter().map(|x| x * x).sum::<f64>().sqrt();
            rows.push(row.iter().map(|x| x / length).collect());
            right.push(bound / length);
        }
        cones.push(SupportedConeT::NonnegativeConeT(limits));
        let upper: Vec<Vec<f64>> =
            (0..12).map(|i| (0..12).map(|j| if j >= i { p[(i, j)] } else { 0.0 }).collect()).collect();
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-12,
            tol_gap_rel: 1e-12,
            tol_feas: 1e-12,
            ..DefaultSettings::default()
        };
        let (costs, conditions) = (CscMatrix::from(upper.iter()), CscMatrix::from(rows.iter()));
        let mut solver =
            DefaultSolver::new(&costs, q.as_slice(), &conditions, &right, &cones, settings).unwrap();
        solver.solve();
        let solution = &solver.solution;
        match solution.status {
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => return Ok(None),
            SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => {}
            _ => return Err(Undecided),
        }
        // An interior point is near; the limits that it says are met with equality give the point itself.
        let near = SMatrix::<f64, 12, 1>::from_iterator(solution.x.iter().copied());
        let guess = |factor: f64| -> Vec<usize> {
            (0..rows.len()).filter(|&k| k < equations || solution.z[k] > factor * solution.s[k]).collect()
        };
        let guesses = [1.0, 1e-2, 1e2, 1e-4, 1e4, 1e-6, 1e6].into_iter().map(guess);
        let mut found = guesses.filter_map(|active| polished((&p, &q), (&rows, &right), equations, active));
        let x = found.next().filter(|x| (x - near).amax() < 1e-4);
        x.map(Some).ok_or(Undecided)
    }
}

/// The solver did not come to an end, or its point is not that of any limits: what is barely possible, or barely not.
#[derive(Debug)]
struct Undecided;

/// The least of ½ xᵀ P x + qᵀ x from a guess of the limits that are met with equality: changed until no limit is violated and no multiplier negative. In
/// coordinates y = Lᵀ (x + P⁻¹ q) with P = L Lᵀ that is the point nearest to 0: y = Aᵀ (A Aᵀ)⁻¹ b of the active rows.
fn polished(
    (p, q): (&SMatrix<f64, 12, 12>, &SMatrix<f64, 12, 1>),
    (rows, right): (&[Vec<f64>], &[f64]),
    equations: usize,
    mut active: Vec<usize>,
) -> Option<SMatrix<f64, 12, 1>> {
    let factor = p.cholesky()?;
    let centre = -factor.solve(q);
    let lower = factor.l();
    let mut changed = DMatrix::zeros(rows.len(), 12);
    let mut bounds = DVector::zeros(rows.len());
    for (k, row) in rows.iter().enumerate() {
        let row = SMatrix::<f64, 12, 1>::from_column_slice(row);
        let own = lower.solve_lower_triangular(&row)?;
        let length = own.norm();
        changed.row_mut(k).copy_from(&(own / length).transpose());
        bounds[k] = (right[k] - row.dot(&centre)) / length;
    }
    for _ in 0..100 {
        // Aᵀ = Q R, y = Q R⁻ᵀ b, and y = −Aᵀ u.
        let (q, r) = changed.select_rows(&active).transpose().qr().unpack();
        if active.len() > 12 || r.diagonal().iter().any(|x| x.abs() < 1e-12) {
            return None;
        }
        let along = r.transpose().solve_lower_triangular(&bounds.select_rows(&active))?;
        let multipliers = -r.solve_upper_triangular(&along)?;
        let y = q * along;
        let negative = (equations..active.len()).min_by(|a, b| multipliers[*a].total_cmp(&multipliers[*b]));
        if let Some(place) = negative.filter(|place| multipliers[*place] < -1e-11) {
            active.remove(place);
            continue;
        }
        let over = &changed * &y - &bounds;
        let worst = (equations..rows.len()).max_by(|a, b| over[*a].total_cmp(&over[*b]));
        match worst.filter(|k| over[*k] > 1e-10) {
            Some(k) if !active.contains(&k) => active.push(k),
            // The rows depend on one another: another guess.
            Some(_) => return None,
            None => {
                let y = SMatrix::<f64, 12, 1>::from_column_slice(y.as_slice());
                return Some(centre + lower.transpose().solve_upper_triangular(&y)?);
            }
        }
    }
    None
}

/// How many of each verdict; prints the largest error of a torque, relative to the largest torque.
fn compare(count: usize, seed: u64) -> [usize; 3] {
    let mut numbers = Numbers(seed);
    let (mut verdicts, mut worst, mut undecided) = ([0; 3], 0.0_f64, 0);
    for case in 0..count {
        let posture = Posture::random(&mut numbers);
        let program = Program::of(&posture);
        let all = program.g.len();
        let tries = [(false, all), (true, all), (false, program.ground), (true, program.ground)];
        let mut solved = Ok(None);
        let mut place = 0;
        for (number, (missing, limits)) in tries.into_iter().enumerate() {
            (solved, place) = (program.solve(missing, limits), number);
            if !matches!(solved, Ok(None)) {
                break;
            }
        }
        let Ok(x) = solved else {
            undecided += 1;
            continue;
        };
        let x = x.unwrap();
        let (found, torques, wrenches) = posture.shared();
        let verdict = match found {
            Shared::Met => 0,
            Shared::GroundGaveWay { .. } => 1,
            Shared::Clamped { .. } => 2,
            Shared::Refused => panic!("case {case}: refused"),
        };
        assert_eq!(verdict, place.min(2), "case {case}: {found:?}");
        verdicts[verdict] += 1;
        let world = program.to_world * x;
        let wrench = wrenches.iter().flatten().zip(world.iter()).map(|(a, b)| (a - b).abs());
        let size = world.amax();
        let off = wrench.fold(0.0, f64::max) / size;
        let mut expected = posture.torques;
        for (joint, torque) in expected.iter_mut().enumerate() {
            let column = posture.jacobian[joint / JOINTS][joint % JOINTS];
            let own = world.fixed_rows::<6>(6 * (joint / JOINTS));
            *torque -= column.iter().zip(own.iter()).map(|(a, b)| a * b).sum::<f64>();
            *torque = torque.clamp(-posture.limits[joint], posture.limits[joint]);
        }
        let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let apart = torques.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
        assert!(apart < 1e-8 && off < 1e-8, "case {case}: {found:?}, torques {apart:e}, wrenches {off:e}");
        worst = worst.max(apart);
    }
    println!("met, gave way, clamped: {verdicts:?}; torques within {worst:e}; {undecided} undecided");
    assert!(1000 * undecided <= count, "{undecided}");
    verdicts
}

#[test]
fn feet_share_as_an_interior_point_solver_says() {
    let verdicts = compare(300, 1);
    assert!(verdicts.iter().all(|count| *count >= 10), "{verdicts:?}");
}

#[test]
#[ignore = "takes long"]
fn feet_share_as_an_interior_point_solver_says_in_a_hundred_thousand_postures() {
    let verdicts = compare(100_000, 2);
    assert!(verdicts.iter().all(|count| *count >= 5000), "{verdicts:?}");
}
