//! The contact problem as a program over second-order cones, solved by clarabel's interior points.
//!
//! Coulomb's law in De Saxcé's form: `K ∋ λ ⊥ ξ + μ |ξ_T| e_N ∈ K*`. With the slip speeds s known, λ minimises
//! `½ λᵀ G λ + λᵀ (c + μ s e_N)` over the cones; the fixed point over s (Cadoux, 2009) is the whole law.
use super::Numbers;
use super::solver::random;
use bipedc_analysis::simulate::{Cone, Law, Problem, Solver, Tolerance};
use bipedc_lapack as _;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// ξ at the minimum for these slip speeds (one per contact).
fn minimised(problem: &Problem, slip: &[f64]) -> Vec<f64> {
    let n = problem.rows();
    let mut linear = problem.free.clone();
    let (mut rows, mut right, mut cones) = (Vec::<Vec<f64>>::new(), Vec::new(), Vec::new());
    let unit = |column: usize, value: f64| {
        let mut row = vec![0.0; n];
        row[column] = value;
        row
    };
    let mut contact = 0;
    for block in &problem.blocks {
        let i = block.first;
        // Rows say: right − row · λ is in the cone.
        match block.law {
            Law::Unilateral => {
                rows.push(unit(i, -1.0));
                right.push(0.0);
                cones.push(SupportedConeT::NonnegativeConeT(1));
            }
            Law::Limited { low, high } => {
                rows.extend([unit(i, -1.0), unit(i, 1.0)]);
                right.extend([-low, high]);
                cones.push(SupportedConeT::NonnegativeConeT(2));
            }
            Law::Contact { friction, tangents, .. } => {
                linear[i] += friction * slip[contact];
                contact += 1;
                rows.push(unit(i, -friction));
                rows.extend((1..=tangents).map(|k| unit(i + k, -1.0)));
                right.extend(vec![0.0; 1 + tangents]);
                cones.push(SupportedConeT::SecondOrderConeT(1 + tangents));
            }
            Law::Sole { .. } => unreachable!("the random problems have point contacts"),
        }
    }
    let upper: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| if j >= i { problem.row(i)[j] } else { 0.0 }).collect()).collect();
    let p = CscMatrix::from(upper.iter());
    let a = CscMatrix::from(rows.iter());
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-13,
        tol_gap_rel: 1e-13,
        tol_feas: 1e-13,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(&p, &linear, &a, &right, &cones, settings).unwrap();
    solver.solve();
    let fine = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    assert!(fine || solver.solution.r_dual < 1e-9, "{:?}", solver.solution.status);
    let impulse = &solver.solution.x;
    (0..n).map(|i| problem.free[i] + (0..n).map(|j| problem.row(i)[j] * impulse[j]).sum::<f64>()).collect()
}

fn slips(problem: &Problem, velocity: &[f64]) -> Vec<f64> {
    let contacts = problem.blocks.iter().filter_map(|block| match block.law {
        Law::Contact { tangents, .. } => {
            let own = &velocity[block.first + 1..block.first + 1 + tangents];
            Some(own.iter().map(|x| x * x).sum::<f64>().sqrt())
        }
        _ => None,
    });
    contacts.collect()
}

#[test]
fn an_interior_point_solver_finds_the_same_velocities() {
    let mut numbers = Numbers(11);
    let tolerance = Tolerance { relative: 1e-11, sweeps: 2000 };
    let (mut worst, mut sliding) = (0.0_f64, 0);
    for case in 0..30 {
        let tangents = 1 + case % 2;
        let mut problem = random(&mut numbers, 1 + case % 6, tangents, Cone::Round);
        let solved = Solver::default().solve(&mut problem, &tolerance);
        assert!(solved.converged, "case {case}: {solved:?}");
        let scale = problem.free.iter().fold(1e-3, |m: f64, x| m.max(x.abs()));
        // Our slip speeds are a fixed point: the cone program with them gives our velocities.
        let found = minimised(&problem, &slips(&problem, &problem.velocity));
        let miss = found.iter().zip(&problem.velocity).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        worst = worst.max(miss / scale);
        sliding += slips(&problem, &problem.velocity).iter().filter(|s| **s > 1e-6).count();
    }
    println!("30 problems: velocities agree to {worst:.1e} of the largest; {sliding} sliding contacts");
    assert!(worst < 1e-6 && sliding > 20, "{worst} {sliding}");
}

#[test]
fn the_fixed_point_from_rest_ends_at_our_answer() {
    let mut numbers = Numbers(12);
    for case in 0..6 {
        let mut problem = random(&mut numbers, 3, 2, Cone::Round);
        Solver::default().solve(&mut problem, &Tolerance { relative: 1e-11, sweeps: 2000 });
        let mut slip = vec![0.0; 3];
        let mut found = Vec::new();
        for _ in 0..60 {
            found = minimised(&problem, &slip);
            let next = slips(&problem, &found);
            let change = next.iter().zip(&slip).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
            slip = next;
            if change < 1e-9 {
                break;
            }
        }
        let miss = found.iter().zip(&problem.velocity).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(miss < 1e-5, "case {case}: {miss}");
    }
}
