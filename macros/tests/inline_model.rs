//! A model without files.
#![deny(warnings)]
#![forbid(unsafe_code)]
#![allow(missing_docs)]
use bipedc_macros::Biped;
use bipedc_runtime::nalgebra::SVector;

#[derive(Biped)]
#[biped(
    urdf = r#"<robot name="pendulum">
  <link name="world"/>
  <link name="rod">
    <inertial>
      <origin xyz="0 0 -0.5"/>
      <mass value="2"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="world"/>
    <child link="rod"/>
    <axis xyz="0 1 0"/>
  </joint>
</robot>"#,
    toml = "base = { kind = \"fixed\", link = \"world\" }",
    functions = ["gravity", "inverse_dynamics"],
)]
struct Pendulum;

#[test]
fn a_pendulum_weighs_what_it_weighs() {
    let q = SVector::<f64, { pendulum::NQ }>::from_element(std::f64::consts::FRAC_PI_2);
    let gravity = pendulum::gravity(&q);
    assert!((gravity[0].abs() - 2.0 * 9.81 * 0.5).abs() < 1e-12, "{gravity}");
}
