//! What the simplifications of section 4.2 leave out.
use super::levels::{frontal_plane, rockers, simulated};
use super::trials::tulip;
use bipedc_analysis::simulate::Scenario;

#[test]
fn rigid_bodies_on_ankles_keep_their_momentum_or_their_energy() {
    let [plastic, smooth, single] = rockers().unwrap();
    println!("{plastic:#?}\n{smooth:#?}\n{single:#?}");
    // Without impact the body comes back as high as it was: upright on the other leg.
    assert!(smooth.lost.unwrap().abs() < 1e-9 && (smooth.roll.unwrap() + 0.3).abs() < 1e-3, "{smooth:?}");
    // With one it does not.
    assert!(plastic.lost.unwrap() > 0.5 && plastic.roll.unwrap() > -0.25, "{plastic:?}");
    // A body's own inertia carries momentum through the impact: a single mass loses more.
    assert!(single.lost.unwrap() > plastic.lost.unwrap(), "{single:?} {plastic:?}");
}

#[test]
fn in_the_frontal_plane_nothing_pitches() {
    // At five times the step of the page, controllers have to work within it.
    let edit = |s: &mut Scenario| (s.ground.normal_restitution, s.inside) = (0.0, true);
    let found = simulated("frontal plane", &frontal_plane(tulip().unwrap()), 5e-4, edit).unwrap();
    println!("{found:#?}");
    assert!(found.pitch < 1e-6 && found.roll.unwrap() < -0.05, "{found:?}");
}
