//! Problems with known answers, and such as have none.
use super::*;

/// A program by functions of numbers; derivatives by complex-step-free hand work of each test.
struct Small {
    bounds: Vec<[f64; 2]>,
    limits: Vec<[f64; 2]>,
    f: fn(&[f64]) -> f64,
    g: fn(&[f64]) -> Vec<f64>,
    c: fn(&[f64]) -> Vec<f64>,
    /// Rows of ∂c/∂x.
    j: fn(&[f64]) -> Vec<Vec<f64>>,
    /// The whole Hessian of w f + y c.
    h: Hessian,
}

type Hessian = fn(&[f64], f64, &[f64]) -> Vec<Vec<f64>>;

impl Program for Small {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.bounds.clone()
    }
    fn limits(&self) -> Vec<[f64; 2]> {
        self.limits.clone()
    }
    fn objective(&self, x: &[f64]) -> f64 {
        (self.f)(x)
    }
    fn gradient(&self, x: &[f64], gradient: &mut [f64]) {
        gradient.copy_from_slice(&(self.g)(x));
    }
    fn constraints(&self, x: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&(self.c)(x));
    }
    fn jacobian_structure(&self) -> Vec<[usize; 2]> {
        let n = self.bounds.len();
        (0..self.limits.len()).flat_map(|row| (0..n).map(move |column| [row, column])).collect()
    }
    fn jacobian(&self, x: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&(self.j)(x).concat());
    }
    fn hessian_structure(&self) -> Vec<[usize; 2]> {
        (0..self.bounds.len()).flat_map(|i| (0..=i).map(move |j| [i, j])).collect()
    }
    fn hessian(&self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let h = (self.h)(x, weight, multipliers);
        let lower = (0..h.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        values.iter_mut().zip(lower).for_each(|(value, (i, j))| *value = h[i][j]);
    }
}

const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn solve(program: &Small, x: &[f64]) -> Solution {
    let start = Start { x, central: None };
    InteriorPoint { tolerance: 1e-9, ..InteriorPoint::default() }.minimise(program, &start, &mut |_| true)
}

fn near(found: &Solution, x: &[f64]) {
    assert_eq!(found.ending, Ending::Minimum, "{found:?}");
    let far = found.x.iter().zip(x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(far < 1e-6, "{found:?} {x:?}");
}

/// Hock and Schittkowski, problem 71.
fn hs71() -> Small {
    Small {
        bounds: vec![[1.0, 5.0]; 4],
        limits: vec![[25.0, f64::INFINITY], [40.0, 40.0]],
        f: |x| x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2],
        g: |x| {
            let s = x[0] + x[1] + x[2];
            vec![x[3] * (s + x[0]), x[0] * x[3], x[0] * x[3] + 1.0, x[0] * s]
        },
        c: |x| vec![x.iter().product(), x.iter().map(|x| x * x).sum()],
        j: |x| {
            let others = |k: usize| (0..4).filter(|&i| i != k).map(|i| x[i]).product();
            vec![(0..4).map(others).collect(), x.iter().map(|x| 2.0 * x).collect()]
        },
        h: |x, w, y| {
            let s = 2.0 * x[0] + x[1] + x[2];
            let of_f = [
                [2.0 * x[3], x[3], x[3], s],
                [x[3], 0.0, 0.0, x[0]],
                [x[3], 0.0, 0.0, x[0]],
                [s, x[0], x[0], 0.0],
            ];
            let of_c = |i: usize, j: usize| {
                let others: f64 = (0..4).filter(|&k| k != i && k != j).map(|k| x[k]).product();
                if i == j { 2.0 * y[1] } else { y[0] * others }
            };
            let row = |i: usize| (0..4).map(|j| w * of_f[i][j] + of_c(i, j)).collect();
            (0..4).map(row).collect()
        },
    }
}

#[test]
fn hock_and_schittkowski_71() {
    let found = solve(&hs71(), &[1.0, 5.0, 5.0, 1.0]);
    near(&found, &[1.0, 4.742_999_64, 3.821_149_98, 1.379_408_29]);
    assert!((found.objective - 17.014_017_3).abs() < 1e-6);
}

/// A neighbour whose limits are others, from a place on the central path: no longer than the same search goes on from there.
#[test]
fn a_neighbour_begun_on_the_central_path_is_short() {
    let first = solve(&hs71(), &[1.0, 5.0, 5.0, 1.0]);
    let central = first.central.unwrap();
    assert!((1e-4..0.1).contains(&central.barrier), "{}", central.barrier);
    let moved = || Small { limits: vec![[26.0, f64::INFINITY], [41.0, 41.0]], ..hs71() };
    let nothing = solve(&moved(), &[1.0, 5.0, 5.0, 1.0]);
    let start = Start { x: &first.x, central: Some(&central) };
    let again = InteriorPoint::default().minimise(&moved(), &start, &mut |_| true);
    near(&again, &nothing.x);
    assert!(again.iterations + 3 <= nothing.iterations, "{} {}", again.iterations, nothing.iterations);
}

/// Rosenbrock's valley within a circle that cuts the minimum off: x² + y² ≤ 1.
#[test]
fn a_curved_valley_that_ends_at_a_circle() {
    let program = Small {
        bounds: vec![ANY; 2],
        limits: vec![[f64::NEG_INFINITY, 1.0]],
        f: |x| 100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2),
        g: |x| {
            let r = x[1] - x[0] * x[0];
            vec![-400.0 * x[0] * r - 2.0 * (1.0 - x[0]), 200.0 * r]
        },
        c: |x| vec![x[0] * x[0] + x[1] * x[1]],
        j: |x| vec![vec![2.0 * x[0], 2.0 * x[1]]],
        h: |x, w, y| {
            let of_x = w * (1200.0 * x[0] * x[0] - 400.0 * x[1] + 2.0);
            vec![vec![of_x + 2.0 * y[0], -400.0 * w * x[0]], vec![-400.0 * w * x[0], 200.0 * w + 2.0 * y[0]]]
        },
    };
    near(&solve(&program, &[-1.2, 1.0]), &[0.786_415_15, 0.617_698_31]);
}

/// Waechter and Biegler's example on which line searches of other interior point methods fail: x² − s₁ = −a, x − s₂ = b.
#[test]
fn the_example_on_which_line_searches_fail() {
    let program = Small {
        bounds: vec![ANY, [0.0, f64::INFINITY], [0.0, f64::INFINITY]],
        limits: vec![[-1.0, -1.0], [2.0, 2.0]],
        f: |x| x[0],
        g: |_| vec![1.0, 0.0, 0.0],
        c: |x| vec![x[0] * x[0] - x[1], x[0] - x[2]],
        j: |x| vec![vec![2.0 * x[0], -1.0, 0.0], vec![1.0, 0.0, -1.0]],
        h: |_, _, y| {
            let mut h = vec![vec![0.0; 3]; 3];
            h[0][0] = 2.0 * y[0];
            h
        },
    };
    near(&solve(&program, &[-2.0, 3.0, 1.0]), &[2.0, 5.0, 0.0]);
}

/// A circle and a line that do not meet: the violated constraints are named, and nothing is claimed.
#[test]
fn what_contradicts_itself_is_infeasible() {
    let program = Small {
        bounds: vec![[-5.0, 5.0]; 2],
        limits: vec![[1.0, 1.0], [3.0, f64::INFINITY]],
        f: |x| x[0],
        g: |_| vec![1.0, 0.0],
        c: |x| vec![x[0] * x[0] + x[1] * x[1], x[0] + x[1]],
        j: |x| vec![vec![2.0 * x[0], 2.0 * x[1]], vec![1.0, 1.0]],
        h: |_, _, y| vec![vec![2.0 * y[0], 0.0], vec![0.0, 2.0 * y[0]]],
    };
    let found = solve(&program, &[0.3, 0.1]);
    assert_eq!(found.ending, Ending::Infeasible, "{found:?}");
    assert!(found.violations.iter().any(|&(row, by)| row == 1 && by < -0.1), "{found:?}");
}

/// Two equations say the same: the multipliers are not unique, the answer is.
#[test]
fn dependent_equations_are_no_obstacle() {
    let program = Small {
        bounds: vec![ANY; 2],
        limits: vec![[1.0, 1.0], [2.0, 2.0]],
        f: |x| x[0] * x[0] + 2.0 * x[1] * x[1],
        g: |x| vec![2.0 * x[0], 4.0 * x[1]],
        c: |x| vec![x[0] + x[1], 2.0 * x[0] + 2.0 * x[1]],
        j: |_| vec![vec![1.0, 1.0], vec![2.0, 2.0]],
        h: |_, w, _| vec![vec![2.0 * w, 0.0], vec![0.0, 4.0 * w]],
    };
    near(&solve(&program, &[5.0, -3.0]), &[2.0 / 3.0, 1.0 / 3.0]);
}
