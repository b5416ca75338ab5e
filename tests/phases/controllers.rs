//! One door for controllers: whatever answers to the trait drives the robot in both simulators.
use super::{described, scenario_text};
use bipedc::simulation::{driven_model, plant, true_walker};
use bipedc_analysis::simulate::control::{PhasedController, VirtualConstraints};
use bipedc_analysis::simulate::{Mechanics, Run, Sample, Scenario, Simulation};
use bipedc_compiler::compile::ProgramModel;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use bipedc_runtime::{Argument, Model, State};
use std::path::Path;

type Commands<'a> = &'a mut [JointCommand<f64>];

/// A leg on a stand, let go in a bent posture, under a controller; the largest motion of a joint in 0.3 s, rad.
fn largest_motion(controller: impl Fn(&ProgramModel, &Observation<'_, f64>, Commands<'_>)) -> f64 {
    let robot = described("robots/tulip_v1_leg");
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let bent: String = plant.joint_names().map(|name| format!("[joint.{name}]\nposition = 0.2\n")).collect();
    let text =
        format!("duration = 0.3\nstep = 1e-3\n[control]\njoint_stops = false\neffort_limits = false\n{bent}");
    let scenario = Scenario::parse(Path::new("s.toml"), &text, &plant).unwrap_or_else(|e| panic!("{e}"));
    let (model, _) = driven_model(&robot, &[], true).unwrap();
    let mechanics = Mechanics::new(&model, plant.layout.base).unwrap();
    let joints = Model::<f64>::joints(&model);
    let mut largest = 0.0_f64;
    let command = |observed: &Observation<'_, f64>, commands: Commands<'_>| {
        controller(&model, observed, commands);
        Ok(())
    };
    let watch = |sample: &Sample| {
        let q = &sample.q[sample.q.len() - joints..];
        largest = q.iter().fold(largest, |most, q| most.max((q - 0.2).abs()));
    };
    let simulation = Simulation::new(mechanics, &plant, &scenario).unwrap().controlled(command);
    simulation
        .watched(watch)
        .run(&mut Run { row: &mut |_| Ok(()), progress: &|_| (), stop: &|| false })
        .unwrap();
    largest
}

#[test]
fn a_leg_whose_weight_is_carried_stays_where_it_is() {
    let carried = largest_motion(|model, observed, commands| {
        // At rest the bias is the weight.
        let bias = Model::<f64>::function(model, "bias").unwrap();
        let (mut out, rest) = (vec![0.0; observed.v.len()], vec![0.0; observed.v.len()]);
        let state = State::new().with(Argument::Q, observed.q).with(Argument::V, &rest);
        model.evaluate(bias, &state, &mut out).unwrap();
        let first = out.len() - commands.len();
        for (command, torque) in commands.iter_mut().zip(&out[first..]) {
            *command = JointCommand::Torque(*torque);
        }
    });
    let falls = largest_motion(|_, _, commands| commands.fill(JointCommand::Torque(0.0)));
    println!("carried {carried:.1e} rad, falling {falls:.2} rad");
    assert!(carried < 1e-9 && falls > 0.1, "{carried} {falls}");
}

/// The five-link walker under a controller that is made from its virtual constraints, in both simulators: final states.
fn walked(
    file: &str,
    wrap: impl Fn(&mut VirtualConstraints<'_>, &Observation<'_, f64>, Commands<'_>) -> Result<(), Refusal>,
) -> Result<Vec<f64>, Diagnostic> {
    let robot = described("robots/five_link");
    let plant = plant(&robot.description, &robot.tree()?)?;
    let text = scenario_text(file);
    let scenario = Scenario::parse(Path::new("s.toml"), &text, &plant).unwrap_or_else(|e| panic!("{e}"));
    let outputs = scenario.outputs.as_ref().unwrap();
    let mut last = Vec::new();
    let mut keep = |sample: &Sample| last = [&sample.q[..], &sample.v].concat();
    if scenario.events.is_some() {
        let walker = true_walker(&robot, &[], false)?;
        let names: Vec<&str> = walker.phases.iter().map(|phase| phase.dynamics.as_str()).collect();
        let mut inner = VirtualConstraints::new(&walker.model, plant.layout.base, outputs, &names)?;
        let controller =
            |observed: &Observation<'_, f64>, commands: Commands<'_>| wrap(&mut inner, observed, commands);
        let walking = walker.walking(&plant, &scenario);
        let mut run = Run { row: &mut |_| Ok(()), progress: &|_| (), stop: &|| false };
        walking.run_with(controller, &mut run, &mut keep)?;
    } else {
        let (model, phases) = driven_model(&robot, &[], false)?;
        let names: Vec<&str> = phases.iter().map(|phase| phase.dynamics.as_str()).collect();
        let mut inner = VirtualConstraints::new(&model, plant.layout.base, outputs, &names)?;
        let controller =
            |observed: &Observation<'_, f64>, commands: Commands<'_>| wrap(&mut inner, observed, commands);
        let phased = PhasedController::new(&model, &plant, &phases, controller, scenario.phase)?;
        let mechanics = Mechanics::new(&model, plant.layout.base)?;
        let simulation = Simulation::new(mechanics, &plant, &scenario)?.phased(phased);
        simulation.watched(keep).run(&mut Run {
            row: &mut |_| Ok(()),
            progress: &|_| (),
            stop: &|| false,
        })?;
    }
    Ok(last)
}

const GAITS: [&str; 2] =
    ["robots/five_link/scenarios/gait.toml", "robots/five_link/scenarios/gait_time_stepping.toml"];

#[test]
#[ignore = "takes long"]
fn a_controller_of_ones_own_walks_as_the_built_in_one() {
    let own = walked(GAITS[0], |inner, observed, commands| inner.command(observed, commands)).unwrap();
    let (_, samples) = super::walked("robots/five_link", &scenario_text(GAITS[0])).unwrap();
    let last = samples.last().unwrap();
    assert_eq!(own, [&last.q[..], &last.v].concat());
    let own = walked(GAITS[1], |inner, observed, commands| inner.command(observed, commands)).unwrap();
    let samples = super::time_stepped("robots/five_link", &scenario_text(GAITS[1]));
    let last = samples.last().unwrap();
    assert_eq!(own, [&last.q[..], &last.v].concat());
}

#[test]
fn a_controller_may_refuse() {
    for file in GAITS {
        let refused = walked(file, |inner, observed, commands| {
            if observed.time > 0.2 {
                return Err(Refusal::Because("enough"));
            }
            inner.command(observed, commands)
        });
        let message = refused.unwrap_err().to_string();
        assert!(message.contains("phase `") && message.contains("enough"), "{message}");
    }
}
