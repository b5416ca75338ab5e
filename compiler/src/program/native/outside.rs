//! What machine code calls: the very functions of the evaluator.
use crate::expression::Call;
use bipedc_runtime::Real;
use bipedc_runtime::lanes::F64x4;
use bipedc_runtime::math::sin_cos;

/// Sines and cosines behind `count` angles: four at once, which fill a register, and what is left by twos.
pub unsafe extern "sysv64" fn sines(angles: *mut f64, count: usize) {
    // SAFETY: the code that calls has three times as many numbers there.
    let all = unsafe { std::slice::from_raw_parts_mut(angles, 3 * count) };
    let (angles, rest) = all.split_at_mut(count);
    let (sines, cosines) = rest.split_at_mut(count);
    let fours = count / 4 * 4;
    together::<4>(&angles[..fours], &mut sines[..fours], &mut cosines[..fours]);
    together::<2>(&angles[fours..], &mut sines[fours..], &mut cosines[fours..]);
}

fn together<const N: usize>(angles: &[f64], sines: &mut [f64], cosines: &mut [f64]) {
    for ((angles, sines), cosines) in angles.chunks(N).zip(sines.chunks_mut(N)).zip(cosines.chunks_mut(N)) {
        let some = std::array::from_fn(|k| angles.get(k).copied().unwrap_or(0.0));
        let (s, c): ([f64; N], [f64; N]) = f64::sin_cos_all(some);
        sines.iter_mut().zip(s).for_each(|(to, s)| *to = s);
        cosines.iter_mut().zip(c).for_each(|(to, c)| *to = c);
    }
}

/// The same of four states; the next angle's stand eight numbers behind.
pub unsafe extern "sysv64" fn four_sines(angles: *mut f64, count: usize) {
    for k in 0..count {
        // SAFETY: the code that calls has three times `count` places of eight numbers there, of which the first four are these states'.
        unsafe {
            let at = |place: usize| angles.add(8 * place).cast::<[f64; 4]>();
            let ([s], [c]) = F64x4::sin_cos_all([F64x4::from_array(at(k).read())]);
            at(count + k).write(s.to_array());
            at(2 * count + k).write(c.to_array());
        }
    }
}

extern "sysv64" fn exp(x: f64) -> f64 {
    Real::exp(x)
}
extern "sysv64" fn tanh(x: f64) -> f64 {
    Real::tanh(x)
}
extern "sysv64" fn magnitude(x: f64) -> f64 {
    Real::abs(x)
}
extern "sysv64" fn sign(x: f64) -> f64 {
    Real::sign(x)
}
extern "sysv64" fn sine(x: f64) -> f64 {
    sin_cos(x).0
}
extern "sysv64" fn cosine(x: f64) -> f64 {
    sin_cos(x).1
}

/// The function behind a call.
pub fn of(call: Call) -> extern "sysv64" fn(f64) -> f64 {
    match call {
        Call::Exp => exp,
        Call::Tanh => tanh,
        Call::Abs => magnitude,
        Call::Sign => sign,
        Call::Sin => sine,
        Call::Cos => cosine,
    }
}
