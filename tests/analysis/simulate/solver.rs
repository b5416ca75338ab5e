//! Contact problems: are the laws obeyed, do sweeps and Newton steps agree, is what is not reached reported?
use super::Numbers;
use bipedc_analysis::simulate::{Block, Cone, Law, Problem, Solver, Tolerance};

/// As many contacts as a humanoid on two feet, with or without redundancy, and dry joints and stops.
pub fn random(numbers: &mut Numbers, contacts: usize, tangents: usize, cone: Cone) -> Problem {
    let size = 1 + tangents;
    let others = 4;
    let rows = contacts * size + others;
    // Fewer velocities than rows: the impulses are not unique, as with four corners on a foot.
    let velocities = if contacts > 4 { rows / 2 } else { rows + 2 };
    let y: Vec<Vec<f64>> = (0..velocities).map(|_| numbers.fill(rows)).collect();
    let v = numbers.fill(velocities);
    let mut problem = Problem::default();
    problem.clear(rows);
    problem.set_delassus(|i, j| y.iter().map(|row| row[i] * row[j]).sum());
    for i in 0..rows {
        // In the range of Yᵀ: there is a velocity that no row minds.
        problem.free[i] = y.iter().zip(&v).map(|(row, v)| row[i] * v).sum();
    }
    for contact in 0..contacts {
        let friction = 0.2 + numbers.next().abs();
        problem.blocks.push(Block { first: contact * size, law: Law::Contact { friction, tangents, cone } });
    }
    for k in 0..others {
        let first = contacts * size + k;
        let law = if k % 2 == 0 { Law::Unilateral } else { Law::Limited { low: -0.05, high: 0.1 } };
        problem.blocks.push(Block { first, law });
    }
    problem
}

fn laws_hold(problem: &Problem, tolerance: f64) {
    let n = problem.rows();
    let velocity: Vec<f64> = (0..n)
        .map(|i| problem.free[i] + (0..n).map(|j| problem.row(i)[j] * problem.impulse[j]).sum::<f64>())
        .collect();
    for block in &problem.blocks {
        let (i, impulse) = (block.first, problem.impulse[block.first]);
        match block.law {
            Law::Limited { low, high } => {
                assert!(impulse >= low - tolerance && impulse <= high + tolerance);
                if velocity[i].abs() > tolerance {
                    let wall = if velocity[i] > 0.0 { low } else { high };
                    assert!((impulse - wall).abs() < tolerance, "{impulse} {wall}");
                }
            }
            _ => {
                assert!(impulse > -tolerance && velocity[i] > -tolerance, "{impulse} {}", velocity[i]);
                assert!(impulse.min(velocity[i]) < tolerance, "{impulse} {}", velocity[i]);
            }
        }
        if let Law::Contact { friction, tangents: 2, cone: Cone::Round } = block.law {
            let force = [problem.impulse[i + 1], problem.impulse[i + 2]];
            let slip = [velocity[i + 1], velocity[i + 2]];
            let (size, speed) = (force[0].hypot(force[1]), slip[0].hypot(slip[1]));
            assert!(size <= friction * impulse + tolerance, "{size} {impulse}");
            if speed > tolerance && impulse > tolerance {
                // λ_T = −μ λ_N ξ_T/|ξ_T|
                for k in 0..2 {
                    let expected = -friction * impulse * slip[k] / speed;
                    assert!((force[k] - expected).abs() < 1e3 * tolerance, "{force:?} {slip:?}");
                }
            }
        }
    }
}

#[test]
fn the_laws_hold_and_sweeps_alone_agree() {
    let mut numbers = Numbers(3);
    let tolerance = Tolerance { relative: 1e-10, sweeps: 2000 };
    let (mut newton, mut sweeps, mut slow) = (0, 0, 0);
    for case in 0..120 {
        let contacts = 1 + case % 8;
        let (tangents, cone) = [(2, Cone::Round), (1, Cone::Round), (2, Cone::Pyramid)][case % 3];
        let mut problem = random(&mut numbers, contacts, tangents, cone);
        let mut other = problem.clone();
        let solved = Solver::with_room(problem.rows()).solve(&mut problem, &tolerance);
        assert!(solved.converged && solved.residual <= 1e-10, "case {case}: {solved:?}");
        laws_hold(&problem, 1e-7);
        let by_sweeps = Solver::solve_by_sweeps(&mut other, &Tolerance { relative: 1e-10, sweeps: 50_000 });
        assert!(by_sweeps.converged, "case {case}: {by_sweeps:?}");
        laws_hold(&other, 1e-6);
        newton += solved.newton;
        sweeps += solved.sweeps;
        slow += by_sweeps.sweeps;
    }
    println!("120 problems: {sweeps} sweeps and {newton} Newton steps; sweeps alone {slow}");
    assert!(5 * (newton + sweeps) < slow);
}

#[test]
fn what_was_not_reached_is_said() {
    let mut problem = random(&mut Numbers(5), 8, 2, Cone::Round);
    let solved = Solver::default().solve(&mut problem, &Tolerance { relative: 0.0, sweeps: 50 });
    assert!(!solved.converged && solved.residual > 0.0, "{solved:?}");
    let solved = Solver::default().solve(&mut problem, &Tolerance::default());
    assert!(solved.converged, "{solved:?}");
    problem.free[0] = f64::NAN;
    let solved = Solver::default().solve(&mut problem, &Tolerance::default());
    assert!(!solved.converged, "{solved:?}");
}
