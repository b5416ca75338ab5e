//! What evaluation and sampling need of a number, so that one algorithm serves prime fields and `f64`.
use bipedc_effects::random::Random;

/// Sine and cosine of an angle; angles have no other value in a field.
pub type Angle<V> = (V, V);

/// A field of numbers.
pub trait Arithmetic {
    /// A number.
    type Value: Copy + PartialEq + std::fmt::Debug;
    /// 0
    fn zero(&self) -> Self::Value;
    /// 1
    fn one(&self) -> Self::Value;
    /// A number of the model; `None` if this field cannot hold it.
    fn constant(&self, value: f64) -> Option<Self::Value>;
    /// A constant angle of the model (rad).
    fn constant_angle(&self, angle: f64) -> Option<Angle<Self::Value>>;
    /// `a + b`
    fn add(&self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// `-a`
    fn neg(&self, a: Self::Value) -> Self::Value;
    /// `a - b`
    fn sub(&self, a: Self::Value, b: Self::Value) -> Self::Value {
        self.add(a, self.neg(b))
    }
    /// `a b`
    fn mul(&self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// `a / b`; `None` if `b` is 0.
    fn div(&self, a: Self::Value, b: Self::Value) -> Option<Self::Value>;
    /// A square root, if there is one.
    fn sqrt(&self, a: Self::Value) -> Option<Self::Value>;
    /// Whether it counts as 0.
    fn is_zero(&self, a: Self::Value) -> bool;
    /// A random number.
    fn random(&self, random: &mut Random) -> Self::Value;
    /// The number that stands for an angle where the angle itself is used, not its sine or cosine.
    fn angle_number(&self, angle: Angle<Self::Value>, random: &mut Random) -> Self::Value;

    /// A random angle, by the tangent of its half.
    fn random_angle(&self, random: &mut Random) -> Option<Angle<Self::Value>> {
        let t = self.random(random);
        let square = self.mul(t, t);
        let sum = self.add(self.one(), square);
        let sine = self.div(self.add(t, t), sum)?;
        Some((sine, self.div(self.sub(self.one(), square), sum)?))
    }

    /// Sine and cosine of the sum of two angles.
    fn add_angles(&self, a: Angle<Self::Value>, b: Angle<Self::Value>) -> Angle<Self::Value> {
        let sine = self.add(self.mul(a.0, b.1), self.mul(a.1, b.0));
        (sine, self.sub(self.mul(a.1, b.1), self.mul(a.0, b.0)))
    }

    /// Scalar product.
    fn dot(&self, a: [Self::Value; 3], b: [Self::Value; 3]) -> Self::Value {
        (0..3).fold(self.zero(), |sum, i| self.add(sum, self.mul(a[i], b[i])))
    }

    /// Cross product.
    fn cross(&self, a: [Self::Value; 3], b: [Self::Value; 3]) -> [Self::Value; 3] {
        [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.sub(self.mul(a[j], b[k]), self.mul(a[k], b[j]))
        })
    }
}

/// Ordinary rounded arithmetic.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rounded;

impl Arithmetic for Rounded {
    type Value = f64;
    fn zero(&self) -> f64 {
        0.0
    }
    fn one(&self) -> f64 {
        1.0
    }
    fn constant(&self, value: f64) -> Option<f64> {
        Some(value)
    }
    fn constant_angle(&self, angle: f64) -> Option<Angle<f64>> {
        Some(angle.sin_cos())
    }
    fn add(&self, a: f64, b: f64) -> f64 {
        a + b
    }
    fn neg(&self, a: f64) -> f64 {
        -a
    }
    fn mul(&self, a: f64, b: f64) -> f64 {
        a * b
    }
    fn div(&self, a: f64, b: f64) -> Option<f64> {
        (b != 0.0).then(|| a / b)
    }
    fn sqrt(&self, a: f64) -> Option<f64> {
        (a >= 0.0).then(|| a.sqrt())
    }
    // Only the choice of a joint that can level a foot asks, at random states.
    fn is_zero(&self, a: f64) -> bool {
        a.abs() < 1e-9
    }
    fn random(&self, random: &mut Random) -> f64 {
        random.symmetric()
    }
    fn angle_number(&self, (sine, cosine): Angle<f64>, _: &mut Random) -> f64 {
        sine.atan2(cosine)
    }
}
