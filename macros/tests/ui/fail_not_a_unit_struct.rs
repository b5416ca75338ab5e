use bipedc_macros::Biped;

#[derive(Biped)]
#[biped(description = "robots/pendulum")]
pub struct Pendulum {
    mass: f64,
}

fn main() {
    let _ = pendulum::NQ;
}
