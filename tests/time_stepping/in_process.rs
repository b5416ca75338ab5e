//! TUlip's model in process: emitted code is not optimised in tests, and several times slower.
use bipedc::simulation::filmed_model;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::ProgramModel;
use std::path::Path;
use std::sync::LazyLock;

static TULIP: LazyLock<ProgramModel> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip");
    let robot = Robot::read(&folder).unwrap_or_else(|list| panic!("{list}"));
    filmed_model(&robot, &[]).unwrap_or_else(|error| panic!("{error}"))
});

/// With energies and centre of mass.
pub fn tulip() -> &'static ProgramModel {
    &TULIP
}
