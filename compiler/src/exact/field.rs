//! Prime fields: exact arithmetic of fixed cost.
use super::arithmetic::{Angle, Arithmetic};
use super::fraction::Fraction;
use bipedc_effects::random::Random;

/// Integers modulo a prime `p ≡ 3 (mod 4)` of 61 or 62 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    prime: u64,
    /// The prime is 2^bits − gap.
    bits: u32,
    gap: u64,
}

impl Field {
    /// The first field is modulo 2⁶¹ − 1, the others modulo the largest primes below 2⁶².
    pub fn all() -> impl Iterator<Item = Self> {
        // p ≡ 3 (mod 4): a square root is one power.
        let others = (0..1_u64 << 20).map(|i| 4 * i + 1).filter(|gap| is_prime((1_u64 << 62) - gap));
        let field = |bits, gap| Self { prime: (1_u64 << bits) - gap, bits, gap };
        std::iter::once(field(61, 1)).chain(others.map(move |gap| field(62, gap)))
    }

    /// The prime.
    pub fn prime(self) -> u64 {
        self.prime
    }

    /// `a b`
    pub fn product(self, a: u64, b: u64) -> u64 {
        // 2^bits = gap: the upper bits are folded onto the lower ones, which takes no division.
        let lower = u128::from((1_u64 << self.bits) - 1);
        let fold = |x: u128| (x & lower) + (x >> self.bits) * u128::from(self.gap);
        let folded = fold(fold(u128::from(a) * u128::from(b))) as u64;
        if folded >= self.prime { folded - self.prime } else { folded }
    }

    /// `aⁿ`
    pub fn power(self, a: u64, n: u64) -> u64 {
        power(a, n, |x, y| self.product(x, y))
    }

    /// `1/a` for a ≠ 0.
    pub fn inverse(self, a: u64) -> u64 {
        self.power(a, self.prime - 2)
    }

    /// A fraction; `None` if the prime divides its denominator.
    pub fn fraction(self, value: &Fraction) -> Option<u64> {
        let (n, d) = value.modulo(self.prime);
        self.div(n, d)
    }
}

fn power(mut a: u64, mut n: u64, product: impl Fn(u64, u64) -> u64) -> u64 {
    let mut result = 1;
    while n > 0 {
        if n & 1 == 1 {
            result = product(result, a);
        }
        a = product(a, a);
        n >>= 1;
    }
    result
}

/// Miller and Rabin's test; with these bases it is a proof for all 64-bit numbers.
fn is_prime(n: u64) -> bool {
    const BASES: [u64; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    if n < 41 || BASES.iter().any(|b| n.is_multiple_of(*b)) {
        return BASES.contains(&n);
    }
    let multiply = |a, b| (u128::from(a) * u128::from(b) % u128::from(n)) as u64;
    let twos = (n - 1).trailing_zeros();
    BASES.iter().all(|&base| {
        let mut x = power(base, (n - 1) >> twos, multiply);
        if x == 1 || x == n - 1 {
            return true;
        }
        (1..twos).any(|_| {
            x = multiply(x, x);
            x == n - 1
        })
    })
}

impl Arithmetic for Field {
    type Value = u64;
    fn zero(&self) -> u64 {
        0
    }
    fn one(&self) -> u64 {
        1
    }
    fn constant(&self, value: f64) -> Option<u64> {
        self.fraction(&Fraction::read(value))
    }
    fn constant_angle(&self, angle: f64) -> Option<Angle<u64>> {
        let t = self.constant((0.5 * angle).tan())?;
        let square = self.mul(t, t);
        let sum = self.add(1, square);
        Some((self.div(self.add(t, t), sum)?, self.div(self.sub(1, square), sum)?))
    }
    fn add(&self, a: u64, b: u64) -> u64 {
        let sum = a + b;
        if sum >= self.prime { sum - self.prime } else { sum }
    }
    fn neg(&self, a: u64) -> u64 {
        if a == 0 { 0 } else { self.prime - a }
    }
    fn mul(&self, a: u64, b: u64) -> u64 {
        self.product(a, b)
    }
    fn div(&self, a: u64, b: u64) -> Option<u64> {
        (b != 0).then(|| self.mul(a, self.inverse(b)))
    }
    fn sqrt(&self, a: u64) -> Option<u64> {
        let root = self.power(a, self.prime.div_ceil(4));
        (self.mul(root, root) == a).then_some(root)
    }
    fn is_zero(&self, a: u64) -> bool {
        a == 0
    }
    fn random(&self, random: &mut Random) -> u64 {
        random.bits() % self.prime
    }
    // An angle and its sine are algebraically independent, so any number will do.
    fn angle_number(&self, _: Angle<u64>, random: &mut Random) -> u64 {
        self.random(random)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_fields() {
        let mut random = Random::new(1);
        for field in Field::all().take(4) {
            assert!(is_prime(field.prime()) && field.prime() % 4 == 3);
            for _ in 0..100 {
                let (a, b) = (field.random(&mut random), field.random(&mut random));
                let reference = u128::from(a) * u128::from(b) % u128::from(field.prime());
                assert_eq!(u128::from(field.mul(a, b)), reference);
                assert_eq!(field.div(field.mul(a, b), b), Some(a));
                assert_eq!(field.add(field.sub(a, b), b), a);
                let root = field.sqrt(field.mul(a, a)).unwrap();
                assert!(root == a || root == field.neg(a));
                assert!(field.sqrt(field.neg(field.mul(a, a))).is_none());
            }
        }
    }

    #[test]
    fn angles_lie_on_the_circle() {
        let mut random = Random::new(2);
        let field = Field::all().nth(1).unwrap();
        for _ in 0..20 {
            let a = field.random_angle(&mut random).unwrap();
            let b = field.constant_angle(random.symmetric()).unwrap();
            let (s, c) = field.add_angles(a, b);
            assert_eq!(field.add(field.mul(s, s), field.mul(c, c)), 1);
        }
    }

    #[test]
    fn small_primes_are_recognised() {
        let primes: Vec<u64> = (0..60).filter(|&n| is_prime(n)).collect();
        assert_eq!(primes, [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59]);
        assert!(!is_prime(3_215_031_751) && !is_prime((1 << 61) - 3) && is_prime((1 << 61) - 1));
    }
}
