//! What each optimisation saves, on the peers' humanoid legs and the six robots.
use crate::compiled::support;
use bipedc_compiler::Robot;
use bipedc_compiler::derive::solve::Factor;
use bipedc_compiler::derive::{InertiaMode, Motions, RobotModel, composite, momentum, newton_euler};
use bipedc_compiler::description::SourceFiles;
use bipedc_compiler::expression::{Expr, Graph, Sym};
use bipedc_compiler::program::{Instruction, Operand, Operations, Order, Program, lower};
use bipedc_compiler::tree::Tree;
use bipedc_runtime::Argument;

fn tree(path: &str) -> Tree {
    Robot::read(&support::project().join(path)).unwrap().tree().unwrap()
}

fn lower12() -> Tree {
    tree("benches/robots/lower12")
}

fn outputs(list: &[Sym<'_>]) -> Vec<Expr> {
    list.iter().map(|x| x.expr).collect()
}

fn inverse_dynamics(model: &RobotModel<'_, '_>) -> Vec<Expr> {
    outputs(&newton_euler::generalised_forces(model, Motions::ALL, false))
}

fn mass_matrix(model: &RobotModel<'_, '_>) -> Vec<Expr> {
    outputs(&composite::mass_matrix(model).concat())
}

fn center_of_mass(model: &RobotModel<'_, '_>) -> Vec<Expr> {
    outputs(&momentum::center_of_mass(model).0)
}

fn program(
    tree: &Tree,
    mode: InertiaMode,
    derive: impl Fn(&RobotModel<'_, '_>) -> Vec<Expr>,
    order: Order,
) -> Program {
    let graph = Graph::new();
    let outputs = derive(&RobotModel::new(&graph, tree, mode));
    lower(&graph, &outputs, order)
}

fn total(program: &Program) -> usize {
    Operations::of(program).total()
}

/// Percent of the operations that regrouped inertias save at least.
#[test]
fn regrouping_inertias_along_the_axes_saves_operations() {
    let tree = lower12();
    let saves = |what: &str, derive: fn(&RobotModel<'_, '_>) -> Vec<Expr>, percent: usize| {
        let count = |mode| total(&program(&tree, mode, derive, Order::Derivation));
        let (plain, folded) = (count(InertiaMode::Plain), count(InertiaMode::Folded));
        assert!(
            100 * folded <= (100 - percent) * plain,
            "{what}: {folded} operations regrouped, {plain} plain: less than {percent} % saved"
        );
    };
    saves("inverse dynamics", inverse_dynamics, 14);
    // The composite rigid bodies fill up again towards the root.
    saves("mass matrix", mass_matrix, 3);
}

/// Operations if every use computed its operands anew, as the expanded text of the equations would.
fn expanded(graph: &Graph, outputs: &[Expr]) -> f64 {
    let nodes = graph.nodes();
    let mut cost = vec![0.0_f64; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        let operands: Vec<Expr> = node.operands().collect();
        let own = f64::from(u8::from(!operands.is_empty()));
        cost[index] = own + operands.iter().map(|e| cost[e.node()]).sum::<f64>();
    }
    outputs.iter().map(|e| cost[e.node()]).sum()
}

#[test]
fn common_subexpressions_save_orders_of_magnitude() {
    let tree = lower12();
    let graph = Graph::new();
    let outputs = inverse_dynamics(&RobotModel::new(&graph, &tree, InertiaMode::Folded));
    let shared = total(&lower(&graph, &outputs, Order::Derivation)) as f64;
    let text = expanded(&graph, &outputs);
    assert!(text > 100.0 * shared, "{shared} operations shared, {text} expanded");
}

/// The ground's wrench needs the same motions and wrenches of the bodies as the inverse dynamics.
#[test]
fn functions_derived_together_share_their_work() {
    fn ground_wrench(model: &RobotModel<'_, '_>) -> Vec<Expr> {
        let wrench = momentum::ground_wrench(model);
        outputs(&[wrench.linear.0, wrench.angular.0].concat())
    }
    let tree = lower12();
    let count = |derive: &dyn Fn(&RobotModel<'_, '_>) -> Vec<Expr>| {
        total(&program(&tree, InertiaMode::Folded, derive, Order::Derivation))
    };
    let apart = count(&inverse_dynamics) + count(&ground_wrench);
    let together = count(&|model| [inverse_dynamics(model), ground_wrench(model)].concat());
    assert!(10 * together < 6 * apart, "{together} operations together, {apart} apart");
}

#[test]
fn dead_code_is_not_lowered() {
    let tree = lower12();
    let graph = Graph::new();
    let model = RobotModel::new(&graph, &tree, InertiaMode::Folded);
    let (_, _, wanted) = (inverse_dynamics(&model), mass_matrix(&model), center_of_mass(&model));
    let among_others = lower(&graph, &wanted, Order::Derivation);
    let alone = program(&tree, InertiaMode::Folded, center_of_mass, Order::Derivation);
    assert_eq!(total(&among_others), total(&alone));
    assert!(10 * among_others.instructions.len() < graph.len());
    // Every value is used.
    let mut used = vec![false; alone.instructions.len()];
    let operands = alone.instructions.iter().flat_map(Instruction::operands);
    for operand in operands.chain(alone.outputs.iter().copied()).chain(alone.angles.iter().copied()) {
        if let bipedc_compiler::program::Operand::Value(k) = operand {
            used[k as usize] = true;
        }
    }
    assert!(used.into_iter().all(|x| x));
}

#[test]
fn fused_operations_shorten_programs() {
    let tree = lower12();
    for derive in [inverse_dynamics as fn(&RobotModel<'_, '_>) -> Vec<Expr>, mass_matrix] {
        let count = Operations::of(&program(&tree, InertiaMode::Folded, derive, Order::Derivation));
        let instructions = count.total() - count.fused;
        assert!(3 * count.fused > instructions, "{count}: {instructions} instructions");
    }
}

#[test]
fn signs_ride_on_edges() {
    let tree = lower12();
    let graph = Graph::new();
    let outputs = inverse_dynamics(&RobotModel::new(&graph, &tree, InertiaMode::Folded));
    let nodes = graph.nodes();
    let negated =
        nodes.iter().flat_map(|n| n.operands().collect::<Vec<_>>()).filter(|e| e.is_negated()).count();
    let lowered = lower(&graph, &outputs, Order::Derivation);
    let negations = lowered.instructions.iter().filter(|i| matches!(i, Instruction::Neg(_))).count();
    assert!(negated > 200 && 20 * negations < negated, "{negations} negations of {negated} negative edges");
}

/// Turning a joint's axis around changes signs alone.
#[test]
fn opposite_axes_cost_nothing() {
    let count = |axis: &str| {
        let path = support::project().join("robots/tulip");
        let sources = SourceFiles::load(&path).unwrap();
        let urdf_text = sources.urdf_text.replace("<axis xyz=\"0 1 0\"/>", axis);
        let robot = SourceFiles { urdf_text, ..sources.clone() };
        if axis.contains("-1") {
            assert_ne!(robot.urdf_text, sources.urdf_text, "the URDF writes its axes in another way");
        }
        let (description, _) = robot.parse().unwrap();
        let tree = Tree::new(&description, &description.base).unwrap();
        total(&program(&tree, InertiaMode::Folded, inverse_dynamics, Order::Derivation))
    };
    assert_eq!(count("<axis xyz=\"0 1 0\"/>"), count("<axis xyz=\"0 -1 0\"/>"));
}

#[test]
fn sine_and_cosine_squared_cost_nothing() {
    let graph = Graph::new();
    let angle = Sym::new(&graph, graph.input(Argument::Q, 0));
    let (s, c) = (angle.sin(), angle.cos());
    let one = lower(&graph, &[(s * s + c * c).expr], Order::Derivation);
    assert_eq!((one.instructions.len(), one.angles.len()), (0, 0));
    assert!(!one.arguments.has(Argument::Q));
}

/// Zeros are found while deriving: legs do not couple, joints across the plane of motion do not see gravity.
#[test]
fn structural_zeros_are_constants() {
    use Operand::Constant;
    let zeros = |program: &Program| program.outputs.iter().filter(|&&o| o == Constant(0.0)).count();
    let mass = program(&lower12(), InertiaMode::Folded, mass_matrix, Order::Derivation);
    // Six joints of one leg by six of the other, both triangles, and the base's linear block.
    assert!(zeros(&mass) >= 2 * 36 + 6, "{}", zeros(&mass));
}

#[test]
fn divisions_are_few() {
    let tree = lower12();
    let com = Operations::of(&program(&tree, InertiaMode::Folded, center_of_mass, Order::Derivation));
    assert_eq!(com.divisions, 0, "by the constant total mass");
    let robot = Robot::read(&support::project().join("benches/robots/lower12")).unwrap();
    let request = bipedc_compiler::compile::FunctionRequest::of_robot("forward_dynamics");
    let solved = robot.compile_only(&[request]).unwrap().functions[0].operations;
    assert!(solved.divisions <= tree.nv, "{solved}: one reciprocal per pivot");
}

/// Most values that are still needed at one time, in the order in which they are emitted.
fn alive(program: &Program) -> usize {
    let mut last = vec![0; program.instructions.len()];
    for (index, instruction) in program.instructions.iter().enumerate() {
        for operand in instruction.operands() {
            if let Operand::Value(value) = operand {
                last[value as usize] = index;
            }
        }
    }
    let mut ends = vec![0; last.len() + 1];
    let (mut now, mut most) = (0_usize, 0);
    for (index, &end) in last.iter().enumerate() {
        now += 1;
        most = most.max(now);
        ends[end.max(index)] += 1;
        now -= ends[index];
    }
    most
}

#[test]
fn the_order_of_long_eliminations_keeps_fewer_values_alive() {
    let tree = lower12();
    let derive = |model: &RobotModel<'_, '_>| {
        let factor = Factor::new(model, &composite::mass_matrix(model));
        let bias = newton_euler::generalised_forces(model, Motions::NO_ACCELERATION, true);
        outputs(&factor.solve(&bias))
    };
    let places = |order| {
        let program = program(&tree, InertiaMode::Folded, derive, order);
        (total(&program), alive(&program))
    };
    let [derivation, depth_first, balanced] =
        [Order::Derivation, Order::DepthFirst, Order::Balanced].map(places);
    assert!(derivation.0 == depth_first.0 && derivation.0 == balanced.0, "order changes no operation");
    assert!(depth_first.1 < derivation.1, "{derivation:?} {depth_first:?} {balanced:?}");
    assert!(balanced.1 < derivation.1, "{derivation:?} {depth_first:?} {balanced:?}");
}
