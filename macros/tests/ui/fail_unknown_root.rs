use bipedc_macros::Biped;

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
    base = "floating",
    root = "rodd",
)]
pub struct Pendulum;

fn main() {
    // What the user goes on to name gives no further errors.
    let _ = pendulum::NQ;
    let model: &dyn bipedc_runtime::Model<f64> = &Pendulum;
    let _ = model.nq();
}
