//! Plans of a gait of four phases: why there is none.
use super::{WALKER, phased, robot};
use bipedc::gait::plan::SpeedPlan;
use bipedc::gait::{ChainOptions, Over, PhasedBench, PlanOptions, Range};
use bipedc::progress::{Run, Silent};
use bipedc::simulation::walker;
use bipedc_analysis::gait::Reason;
use bipedc_analysis::simulate::phases::PhaseSpec;

const RUN: Run<'_> = Run { progress: &Silent, stop: &|| false };

fn opened() -> (PhasedBench, Vec<PhaseSpec>) {
    (phased(WALKER, "adjustable"), walker(&robot(WALKER)).unwrap().phases)
}

fn over(name: &str, low: f64, high: f64, count: usize) -> Over {
    Over { name: name.to_owned(), range: Range { low, high, count } }
}

/// The way from a speed to another.
fn way(of: &(PhasedBench, Vec<PhaseSpec>), [from, to]: [f64; 2], over: Vec<Over>) -> SpeedPlan {
    let options = PlanOptions { from_speeds: vec![from], to, over, most: 12, ..PlanOptions::default() };
    of.0.plans(&of.1, &options, &RUN).unwrap_or_else(|e| panic!("{e}")).plans.remove(0)
}

/// That plans say what the step says with which none of them goes on.
fn same_reason(speed: f64, to: f64, over: Over, code: Reason) {
    let of = opened();
    let set = vec![(over.name.clone(), over.range.low)];
    let step = of.0.step(&of.1, &ChainOptions { speed, set, from: Vec::new() }).unwrap();
    let plan = way(&of, [speed, to], vec![over]);
    assert_eq!((step.reason_code, plan.reason_code), (Some(code), Some(code.code())), "{speed}: {plan:?}");
    let (step, plan) = (step.reason.unwrap(), plan.reason.unwrap());
    let words = if code == Reason::FallsBack { "falls back" } else { &step };
    assert!(plan.contains(words), "{speed}: {plan}; {step}");
}

#[test]
fn plans_have_the_reason_of_the_step() {
    for (speed, to) in [(3.0, 0.0), (1.2, 0.6)] {
        same_reason(speed, to, over("push_off", -2.0, 4.0, 2), Reason::OutputsMissed);
    }
}

#[test]
#[ignore = "takes long"]
fn plans_fall_back_where_the_step_does() {
    same_reason(0.1, 0.0, over("torso_lean", -0.04, -0.03, 2), Reason::FallsBack);
}
