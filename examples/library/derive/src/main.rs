use nalgebra::SVector;

fn main() {
    let mut q = SVector::<f64, { tulip::NQ }>::zeros();
    q[6] = 1.0; // upright: the quaternion's w
    let (v, a) = (SVector::<f64, { tulip::NV }>::zeros(), SVector::<f64, { tulip::NV }>::zeros());
    let tau = tulip::inverse_dynamics(&q, &v, &a); // 1156 operations, no allocation
    let d = tulip::mass_matrix(&q);
    let jacobian = tulip::jacobian_of_left_foot_front_left(&q); // world axes, linear rows first
    println!("{:.2} N carry {:.3} kg, {} by {}", tau[2], d[(0, 0)], jacobian.nrows(), jacobian.ncols());
}

#[derive(bipedc_macros::Biped)]
#[biped(description = "../../../robots/tulip")]
struct Tulip;
