//! Derivatives, Coriolis matrix and the ways of forward dynamics on random trees, against dual numbers of the
//! plain functions.
#![allow(missing_docs)]
mod random_tree;

use bipedc_compiler::derive::{
    InertiaMode, Motions, RobotModel, articulated, composite, coriolis, derivatives, joint_axes, newton_euler,
};
use bipedc_compiler::description::model::Base;
use bipedc_compiler::expression::{Expr, Graph, Sym};
use bipedc_compiler::program::{Dual, Evaluator, Order, lower};
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_runtime::{Argument, Real, State};
use random_tree::{Random, robot};

const SEED: u64 = 20_261_121;

/// A state: q, v, a, tau.
type Values<R> = [Vec<R>; 4];

fn evaluator(graph: &Graph, outputs: &[Sym<'_>]) -> Evaluator {
    let outputs: Vec<Expr> = outputs.iter().map(|x| x.expr).collect();
    Evaluator::new(&lower(graph, &outputs, Order::DepthFirst))
}

fn flat<'g>(rows: Vec<Vec<Sym<'g>>>) -> Vec<Sym<'g>> {
    rows.into_iter().flatten().collect()
}

fn run<R: Real>(evaluator: &Evaluator, [q, v, a, tau]: &Values<R>) -> Vec<R> {
    let state =
        State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a).with(Argument::Tau, tau);
    let mut out = vec![R::constant(0.0); evaluator.outputs()];
    evaluator.run(&state, &mut evaluator.workspace(), &mut out);
    out
}

fn state(random: &mut Random, tree: &Tree) -> Values<f64> {
    let mut q = random.vector(tree.nq, 2.0);
    if tree.base == BaseKind::Floating {
        let length = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
        q[3..7].iter_mut().for_each(|x| *x /= length);
    }
    [q, random.vector(tree.nv, 2.0), random.vector(tree.nv, 5.0), random.vector(tree.nv, 20.0)]
}

fn with_rates(values: &Values<f64>, rates: [Option<Vec<f64>>; 4]) -> Values<Dual> {
    let mut rates = rates.into_iter();
    values.each_ref().map(|x| {
        let rate = rates.next().flatten().unwrap_or_else(|| vec![0.0; x.len()]);
        x.iter().zip(rate).map(|(&x, d)| Dual(x, d)).collect()
    })
}

/// Derivatives of `function` by q (tangent space), v and τ, column after column.
fn dual_columns(
    tree: &Tree,
    function: &Evaluator,
    values: &Values<f64>,
    argument: Argument,
) -> Vec<Vec<f64>> {
    let unit = |k: usize| (0..tree.nv).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
    let column = |k: usize| {
        let rates = match argument {
            Argument::Q => [Some(tree.configuration_rate(&values[0], &unit(k))), None, None, None],
            Argument::V => [None, Some(unit(k)), None, None],
            _ => [None, None, None, Some(unit(k))],
        };
        run(function, &with_rates(values, rates)).iter().map(|x| x.1).collect()
    };
    (0..tree.nv).map(column).collect()
}

/// Largest difference of a matrix by rows from columns, relative to the largest element.
fn difference(rows: &[f64], columns: &[Vec<f64>]) -> f64 {
    let n = columns.len();
    let scale = columns.iter().flatten().fold(1e-3_f64, |m, x| m.max(x.abs()));
    let entries = (0..n).flat_map(|r| (0..n).map(move |c| (r, c)));
    entries.fold(0.0_f64, |m, (r, c)| m.max((rows[r * n + c] - columns[c][r]).abs())) / scale
}

fn close(a: &[f64], b: &[f64], tolerance: f64, what: &str) {
    let scale = b.iter().fold(1e-3_f64, |m, x| m.max(x.abs()));
    let worst = a.iter().zip(b).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs())) / scale;
    assert!(worst <= tolerance, "{what}: {worst:e}");
}

/// Calls `check` with random trees on every kind of base.
fn on_random_trees(check: impl Fn(&mut Random, &Tree, &str)) {
    let mut random = Random(SEED);
    for round in 0..6 {
        let description = robot(&mut random, 2 + round);
        let link = description.root_link.clone();
        let bases = [
            Base::Floating { root: link.clone() },
            // Rooted at a leaf: joints run backwards.
            Base::Floating { root: description.links.last().expect("there are links").name.clone() },
            Base::Planar { root: link.clone() },
            Base::Pivot { about: link.clone() },
            Base::Fixed { link },
        ];
        for base in bases {
            let tree = Tree::new(&description, &base).unwrap_or_else(|e| panic!("{e:?}"));
            if tree.nv > 0 {
                check(&mut random, &tree, &format!("seed {SEED}, round {round}, {base:?}"));
            }
        }
    }
}

#[test]
fn derivatives_of_inverse_dynamics_are_those_of_dual_numbers() {
    on_random_trees(|random, tree, what| {
        for mode in [InertiaMode::Folded, InertiaMode::Plain] {
            let graph = Graph::new();
            let model = RobotModel::new(&graph, tree, mode);
            let function = evaluator(&graph, &newton_euler::generalised_forces(&model, Motions::ALL, false));
            let (dq, dv) = derivatives::inverse_dynamics(&model);
            let (dq, dv) = (evaluator(&graph, &flat(dq)), evaluator(&graph, &flat(dv)));
            let values = state(random, tree);
            for (rows, argument) in [(&dq, Argument::Q), (&dv, Argument::V)] {
                let columns = dual_columns(tree, &function, &values, argument);
                let worst = difference(&run(rows, &values), &columns);
                assert!(worst < 1e-12, "{what}, {mode:?}, {argument:?}: {worst:e}");
            }
        }
    });
}

#[test]
fn derivatives_of_forward_dynamics_are_those_of_dual_numbers() {
    on_random_trees(|random, tree, what| {
        let graph = Graph::new();
        let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
        let tau = articulated::given_forces(&model);
        let function = evaluator(&graph, &articulated::factored(&model, &tau));
        let (dq, dv, dtau) = derivatives::forward_dynamics(&model);
        let values = state(random, tree);
        for (rows, argument) in [(dq, Argument::Q), (dv, Argument::V), (dtau, Argument::Tau)] {
            let columns = dual_columns(tree, &function, &values, argument);
            let worst = difference(&run(&evaluator(&graph, &flat(rows)), &values), &columns);
            assert!(worst < 1e-10, "{what}, {argument:?}: {worst:e}");
        }
    });
}

#[test]
fn all_ways_of_forward_dynamics_undo_inverse_dynamics() {
    on_random_trees(|random, tree, what| {
        let graph = Graph::new();
        let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
        let tau = articulated::given_forces(&model);
        let inverse = newton_euler::generalised_forces(&model, Motions::ALL, false);
        let mut values = state(random, tree);
        values[3] = run(&evaluator(&graph, &inverse), &values);
        let ways = [
            ("factored", articulated::factored(&model, &tau)),
            ("absolute", articulated::absolute(&model, &tau)),
            ("articulated", articulated::articulated(&model, &tau)),
            ("chosen", articulated::forward_dynamics(&model, &tau)),
        ];
        for (name, way) in ways {
            let a = run(&evaluator(&graph, &way), &values);
            close(&a, &values[2], 1e-9, &format!("{what}, {name}"));
        }
    });
}

#[test]
fn joint_axes_do_not_change_forces_and_mass_matrix() {
    on_random_trees(|random, tree, what| {
        let graph = Graph::new();
        let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
        let values = state(random, tree);
        let run = |x: Vec<Sym<'_>>| run(&evaluator(&graph, &x), &values);
        let forces = run(joint_axes::generalised_forces(&model, Motions::ALL));
        let expected = run(newton_euler::generalised_forces(&model, Motions::ALL, false));
        close(&forces, &expected, 1e-12, what);
        let mass = run(flat(joint_axes::mass_matrix(&model)));
        close(&mass, &run(flat(composite::mass_matrix(&model))), 1e-12, what);
    });
}

#[test]
fn coriolis_matrix_gives_the_coriolis_forces_and_a_skew_difference() {
    let coriolis_only = Motions { velocity: true, acceleration: false, gravity: false };
    on_random_trees(|random, tree, what| {
        let graph = Graph::new();
        let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
        let values = state(random, tree);
        let n = tree.nv;
        let c = run(&evaluator(&graph, &flat(coriolis::coriolis_matrix(&model))), &values);
        let forces: Vec<f64> = (0..n).map(|r| (0..n).map(|k| c[r * n + k] * values[1][k]).sum()).collect();
        let expected = newton_euler::generalised_forces(&model, coriolis_only, false);
        close(&forces, &run(&evaluator(&graph, &expected), &values), 1e-12, what);
        let along =
            with_rates(&values, [Some(tree.configuration_rate(&values[0], &values[1])), None, None, None]);
        let d = run(&evaluator(&graph, &flat(composite::mass_matrix(&model))), &along);
        let sum: Vec<f64> = (0..n * n).map(|k| c[k] + c[k % n * n + k / n]).collect();
        let rates: Vec<f64> = d.iter().map(|x| x.1).collect();
        close(&sum, &rates, 1e-12, what);
    });
}

#[test]
fn coriolis_matrix_of_coordinates_is_that_of_christoffel_symbols() {
    on_random_trees(|random, tree, what| {
        if tree.base == BaseKind::Floating {
            return;
        }
        let graph = Graph::new();
        let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
        let values = state(random, tree);
        let c = run(&evaluator(&graph, &flat(coriolis::coriolis_matrix(&model))), &values);
        let (_, dv) = derivatives::inverse_dynamics(&model);
        let half: Vec<f64> = run(&evaluator(&graph, &flat(dv)), &values).iter().map(|x| 0.5 * x).collect();
        close(&c, &half, 1e-12, what);
    });
}

#[test]
fn moving_a_planar_robot_changes_no_force() {
    let mut random = Random(SEED);
    let description = robot(&mut random, 5);
    let tree = Tree::new(&description, &Base::Planar { root: description.root_link.clone() }).unwrap();
    let graph = Graph::new();
    let model = RobotModel::new(&graph, &tree, InertiaMode::Folded);
    let (dq, dv) = derivatives::inverse_dynamics(&model);
    assert!(dq.iter().chain(&dv).all(|row| row[0].is_zero() && row[1].is_zero()));
}
