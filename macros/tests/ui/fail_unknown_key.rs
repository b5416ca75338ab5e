use bipedc_macros::Biped;

#[derive(Biped)]
#[biped(descripton = "robots/pendulum")]
pub struct Pendulum;

fn main() {
    // What the user goes on to name gives no further errors.
    let _ = pendulum::NQ;
    let model: &dyn bipedc_runtime::Model<f64> = &Pendulum;
    let _ = model.nq();
}
