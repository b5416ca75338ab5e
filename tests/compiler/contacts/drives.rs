//! Drive trains of TUlip's first leg against the equations written out.
use super::support::*;
use bipedc_compiler::derive::newton_euler::generalised_forces;
use bipedc_compiler::derive::{Motions, composite, drive};
use bipedc_effects::drive::Transmission;
use bipedc_runtime::Argument::{A, MotorA, MotorQ, MotorV, Q, V};

#[test]
fn series_elastic_stiff_and_passive_drives() {
    let description = robot("tulip_v1_leg");
    let drives = &description.drives;
    let tree = tree(&description, "fixed");
    let n = tree.joints.len();
    let mut listed = [Vec::new(), Vec::new(), Vec::new()];
    let function = Function::derive(&tree, |model| {
        let lists = [
            drive::spring_torques(model, drives),
            drive::gear_torques(model, drives),
            drive::motor_torques(model, drives),
        ];
        listed = [0, 1, 2].map(|k: usize| lists[k].iter().map(|t| t.joint).collect());
        let mut out: Vec<Vec<_>> = lists.iter().map(|l| l.iter().map(|t| t.torque).collect()).collect();
        out.push(drive::inverse_dynamics(model, drives));
        out.push(generalised_forces(model, Motions::ALL, false));
        out.push(drive::mass_matrix(model, drives).into_iter().flatten().collect());
        out.push(composite::mass_matrix(model).into_iter().flatten().collect());
        out
    });
    let mut random = Random::new(SEED + 6);
    let state: Vec<Vec<f64>> = (0..6).map(|_| random.vector(n, 2.0)).collect();
    let [q, v, a, mq, mv, ma] = [0, 1, 2, 3, 4, 5].map(|k: usize| state[k].as_slice());
    let out = function.call(&[(Q, q), (V, v), (A, a), (MotorQ, mq), (MotorV, mv), (MotorA, ma)]);
    let at = |list: usize, joint: usize| out[list][listed[list].iter().position(|&k| k == joint).unwrap()];
    let mut worst = Worst::default();
    for (k, joint) in tree.joints.iter().enumerate() {
        let d = description.drive(&joint.name).unwrap();
        let (gear, own) = (d.gear_ratio, out[4][k]);
        match d.transmission {
            Transmission::SeriesElastic {
                motor_pulley_radius: rm,
                load_pulley_radius: rl,
                spring_stiffness: ks,
            } => {
                let force = ks * (rm * mq[k] / gear - rl * q[k]);
                worst.note("tau_L (4.29b)", &[at(0, k)], &[rl * force]);
                worst.note("tau_N (4.29a)", &[at(1, k)], &[rm * force]);
                let shaft = d.rotor_inertia * ma[k] + d.viscous_friction * mv[k] + rm * force / gear;
                worst.note("tau_M (4.31)", &[at(2, k)], &[shaft]);
                worst.note("unchanged joint torque", &[out[3][k]], &[own]);
            }
            Transmission::Stiff => {
                let (ma, mv) = (gear * a[k], gear * v[k]);
                let shaft = d.rotor_inertia * ma + d.viscous_friction * mv + own / gear;
                worst.note("tau_M stiff (4.26)", &[at(2, k)], &[shaft]);
                worst.note("reflected torque", &[out[3][k]], &[shaft * gear]);
                assert!(!listed[0].contains(&k));
            }
            Transmission::Passive { stiffness, damping } => {
                worst.note("passive torque", &[at(0, k)], &[-stiffness * q[k] - damping * v[k]]);
                worst.note("passive residual", &[out[3][k]], &[own + stiffness * q[k] + damping * v[k]]);
                assert!(!listed[2].contains(&k));
            }
        }
        let reflected = drive::reflected_inertia(&tree, drives)[k];
        worst.note("mass matrix", &[out[5][k * n + k]], &[out[6][k * n + k] + reflected]);
        worst.note("Coulomb", &[drive::coulomb_friction(&tree, drives)[k]], &[d.coulomb_friction]);
    }
    assert_eq!([listed[0].len(), listed[1].len(), listed[2].len()], [4, 3, 5]);
    worst.check(1e-13);
}
