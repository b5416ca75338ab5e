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

/// Joints whose names are none in Rust, or the same when they become some.
#[derive(Biped)]
#[biped(
    urdf = r#"<robot name="odd">
  <link name="l0"/>
  <link name="l1"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="l2"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="l3"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="l4"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="2dof" type="continuous"><parent link="l0"/><child link="l1"/><axis xyz="0 1 0"/></joint>
  <joint name="日本" type="continuous"><parent link="l1"/><child link="l2"/><axis xyz="1 0 0"/></joint>
  <joint name="_" type="continuous"><parent link="l2"/><child link="l3"/><axis xyz="0 0 1"/></joint>
  <joint name="`a` *fn" type="continuous"><parent link="l3"/><child link="l4"/><axis xyz="0 1 0"/></joint>
</robot>"#,
    toml = "base = { kind = \"fixed\", link = \"l0\" }",
    functions = ["inverse_dynamics", "mass_matrix"],
)]
struct Odd;

#[test]
fn odd_names_of_joints_give_code() {
    let state = SVector::<f64, { odd::NQ }>::from_fn(|k, _| 0.1 + k as f64);
    let at_rest = odd::inverse_dynamics(&state, &SVector::zeros(), &state);
    assert!((odd::mass_matrix(&state) * state - at_rest).amax() < 1e-12);
    assert_eq!(odd::V_NAMES[..2], ["2dof", "日本"]);
}

#[test]
fn a_pendulum_weighs_what_it_weighs() {
    let q = SVector::<f64, { pendulum::NQ }>::from_element(std::f64::consts::FRAC_PI_2);
    let gravity = pendulum::gravity(&q);
    assert!((gravity[0].abs() - 2.0 * 9.81 * 0.5).abs() < 1e-12, "{gravity}");
}
