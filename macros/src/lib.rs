//! `#[derive(Biped)]`: a robot model from its description, at compile time.
//!
//! Everything happens in [`bipedc_compiler::front::attribute`]; a macro crate can export nothing but macros.
use bipedc_compiler::front::attribute;
use proc_macro::TokenStream;
use std::path::PathBuf;

/// Compiles the robot that `#[biped(…)]` names and implements `bipedc_runtime::Model` for the struct.
///
/// ```ignore
/// #[derive(bipedc_macros::Biped)]
/// #[biped(description = "robots/tulip")]
/// pub struct MyRobot;
///
/// let torques = my_robot::inverse_dynamics(&q, &v, &a);
/// ```
///
/// All functions, the lengths `NQ` and `NV` and the indices of the joints stand in a module beside the
/// struct, named after it and as visible. The struct stands at a module's level (not inside a function), and
/// the crate depends on `bipedc-runtime`. The code is compiled anew when the files change.
///
/// | key | value | default |
/// |---|---|---|
/// | `description` | folder of the robot, its `biped.toml` or a URDF, relative to the crate's `Cargo.toml` | required |
/// | `base` | `"floating"`, `"planar"`, `"fixed"` or `"pivot"` | what the description says |
/// | `root` | link or contact point `"foot/point"` that the base holds | what the description says |
/// | `functions` | list of names | what the description asks for |
/// | `split_above` | instructions in one emitted function | 4000 |
/// | `limbs_apart` | `true`: limbs of the same make are computed one after the other, not at once; the bits are the same | `false` |
/// | `gait` | a gait of the robot, by its name in `gaits/` or its file: the module `gait_NAME` | none |
/// | `urdf`, `toml` | texts instead of `description` | |
#[proc_macro_derive(Biped, attributes(biped))]
pub fn derive_biped(input: TokenStream) -> TokenStream {
    // Cargo sets it; without Cargo paths are relative to the working directory.
    let folder = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).unwrap_or_default();
    attribute::expand(input.into(), &folder).into()
}
