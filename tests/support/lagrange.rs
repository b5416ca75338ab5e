//! Equations of motion by Lagrange, straight from the URDF's text: nothing of the compiler is used.
//!
//! L = K − P over plain forward kinematics; all derivatives by nested dual numbers:
//! τᵢ = d/dt ∂L/∂q̇ᵢ − ∂L/∂qᵢ and Dᵢⱼ = ∂²K/∂q̇ᵢ∂q̇ⱼ.
use bipedc_compiler::program::Dual;
use bipedc_runtime::Real;
use roxmltree::{Document, Node};

type Vector<T> = [T; 3];
type Matrix<T> = [[T; 3]; 3];

struct Body {
    name: String,
    mass: f64,
    com: Vector<f64>,
    /// ∫ r rᵀ dm about the centre of mass, axes of the link.
    second_moments: Matrix<f64>,
}

struct Joint {
    name: String,
    kind: String,
    parent: String,
    child: String,
    xyz: Vector<f64>,
    rotation: Matrix<f64>,
    axis: Vector<f64>,
}

/// A robot in a gravity field along −z, its root link bolted to the world or free in the x-z plane.
pub struct Lagrangian {
    bodies: Vec<Body>,
    joints: Vec<Joint>,
    root: String,
    planar: bool,
    /// Names of the joints that move, in the order of the file: q after the base's x, z, pitch.
    moving: Vec<String>,
}

const GRAVITY: f64 = 9.81;

fn numbers<const N: usize>(text: Option<&str>, default: [f64; N]) -> [f64; N] {
    text.map_or(default, |text| {
        let list: Vec<f64> = text.split_whitespace().map(|x| x.parse().unwrap()).collect();
        list.try_into().unwrap()
    })
}

fn constant<T: Real>(m: Matrix<f64>) -> Matrix<T> {
    m.map(|row| row.map(T::constant))
}
fn add<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
fn apply<T: Real>(m: &Matrix<T>, x: Vector<T>) -> Vector<T> {
    m.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
}
fn product<T: Real>(a: &Matrix<T>, b: &Matrix<T>) -> Matrix<T> {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c]))
}
fn transposed<T: Real>(m: &Matrix<T>) -> Matrix<T> {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| m[c][r]))
}

/// Rodrigues: 1 + sin θ [u] + (1 − cos θ) [u]².
fn turn<T: Real>(axis: Vector<f64>, angle: T) -> Matrix<T> {
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = axis.map(|x| x / length);
    let hat = constant::<T>([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]);
    let square = product(&hat, &hat);
    let ([s], [c]) = T::sin_cos_all([angle]);
    let one = T::constant(1.0);
    let identity = constant::<T>([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    [0, 1, 2].map(|r| [0, 1, 2].map(|k| identity[r][k] + s * hat[r][k] + (one - c) * square[r][k]))
}

fn from_rpy([roll, pitch, yaw]: Vector<f64>) -> Matrix<f64> {
    let tilted = product(&turn([0.0, 1.0, 0.0], pitch), &turn([1.0, 0.0, 0.0], roll));
    product(&turn([0.0, 0.0, 1.0], yaw), &tilted)
}

fn origin(node: Node<'_, '_>) -> (Vector<f64>, Matrix<f64>) {
    let origin = node.children().find(|c| c.has_tag_name("origin"));
    let read = |key| numbers(origin.and_then(|o| o.attribute(key)), [0.0; 3]);
    (read("xyz"), from_rpy(read("rpy")))
}

fn body(link: Node<'_, '_>) -> Option<Body> {
    let inertial = link.children().find(|c| c.has_tag_name("inertial"))?;
    let number = |tag: &str, key: &str| -> f64 {
        let node = inertial.children().find(|c| c.has_tag_name(tag)).unwrap();
        node.attribute(key).unwrap().parse().unwrap()
    };
    let [xx, xy, xz, yy, yz, zz] =
        ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|key| number("inertia", key));
    let (com, axes) = origin(inertial);
    // I = tr(Σ) 1 − Σ, so Σ = ½ tr(I) 1 − I.
    let half = 0.5 * (xx + yy + zz);
    let own = [[half - xx, -xy, -xz], [-xy, half - yy, -yz], [-xz, -yz, half - zz]];
    let second_moments = product(&product(&axes, &own), &transposed(&axes));
    Some(Body {
        name: link.attribute("name")?.to_owned(),
        mass: number("mass", "value"),
        com,
        second_moments,
    })
}

fn joint(node: Node<'_, '_>) -> Joint {
    let text = |tag: &str, key: &str| child_attribute(node, tag, key).unwrap_or_default();
    let (xyz, rotation) = origin(node);
    Joint {
        name: node.attribute("name").unwrap().to_owned(),
        kind: node.attribute("type").unwrap().to_owned(),
        parent: text("parent", "link"),
        child: text("child", "link"),
        xyz,
        rotation,
        axis: numbers(child_attribute(node, "axis", "xyz").as_deref(), [1.0, 0.0, 0.0]),
    }
}

fn child_attribute(node: Node<'_, '_>, tag: &str, key: &str) -> Option<String> {
    node.children().find(|c| c.has_tag_name(tag))?.attribute(key).map(str::to_owned)
}

impl Lagrangian {
    pub fn read(urdf: &str, planar: bool) -> Self {
        let document = Document::parse(urdf).unwrap();
        let all = |tag: &'static str| document.root_element().children().filter(move |n| n.has_tag_name(tag));
        let joints: Vec<Joint> = all("joint").map(joint).collect();
        let names = all("link").map(|link| link.attribute("name").unwrap().to_owned());
        let root = names.into_iter().find(|name| joints.iter().all(|j| j.child != *name)).unwrap();
        let moving = joints.iter().filter(|j| j.kind != "fixed").map(|j| j.name.clone()).collect();
        Self { bodies: all("link").filter_map(body).collect(), joints, root, planar, moving }
    }

    /// Position and rotation of a link, up along its joints.
    fn pose<T: Real>(&self, link: &str, q: &[T]) -> (Vector<T>, Matrix<T>) {
        let zero = T::constant(0.0);
        let Some(joint) = self.joints.iter().find(|j| j.child == link) else {
            assert_eq!(link, self.root);
            let still = ([zero; 3], turn([0.0, 1.0, 0.0], zero));
            return if self.planar { ([q[0], zero, q[1]], turn([0.0, 1.0, 0.0], q[2])) } else { still };
        };
        let (position, rotation) = self.pose(&joint.parent, q);
        let position = add(position, apply(&rotation, joint.xyz.map(T::constant)));
        let rotation = product(&rotation, &constant(joint.rotation));
        let first = if self.planar { 3 } else { 0 };
        let index = self.moving.iter().position(|name| *name == joint.name);
        let Some(x) = index.map(|k| q[first + k]) else { return (position, rotation) };
        if joint.kind == "prismatic" {
            let length = joint.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
            let travel = joint.axis.map(|a| T::constant(a / length) * x);
            (add(position, apply(&rotation, travel)), rotation)
        } else {
            (position, product(&rotation, &turn(joint.axis, x)))
        }
    }

    /// K and P; velocities are the dual parts of positions that move with q̇.
    pub fn energies<T: Real>(&self, q: &[T], v: &[T]) -> (T, T) {
        let moving: Vec<Dual<T>> = q.iter().zip(v).map(|(&q, &v)| Dual(q, v)).collect();
        let (mut kinetic, mut potential) = (T::constant(0.0), T::constant(0.0));
        for body in &self.bodies {
            let (position, rotation) = self.pose(&body.name, &moving);
            let com = add(position, apply(&rotation, body.com.map(Dual::constant)));
            let square = com.iter().fold(T::constant(0.0), |sum, x| sum + x.1 * x.1);
            // ∫ |Ṙ r|² dm = tr(Ṙ Σ Ṙᵀ)
            let rate = rotation.map(|row| row.map(|x| x.1));
            let spread = product(&rate, &constant(body.second_moments));
            let turning =
                (0..9).fold(T::constant(0.0), |sum, k| sum + spread[k / 3][k % 3] * rate[k / 3][k % 3]);
            kinetic = kinetic + T::constant(0.5) * (T::constant(body.mass) * square + turning);
            potential = potential + T::constant(body.mass * GRAVITY) * com[2].0;
        }
        (kinetic, potential)
    }

    fn lagrangian<T: Real>(&self, q: &[T], v: &[T]) -> T {
        let (kinetic, potential) = self.energies(q, v);
        kinetic - potential
    }

    /// τ by the equations of Euler and Lagrange.
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let one = |i: usize, k: usize| f64::from(u8::from(i == k));
        let component = |i: usize| {
            // Outer: along ∂/∂q̇ᵢ; inner: along the motion.
            let pair = |x: f64, rate: f64, seed: f64| Dual(Dual(x, rate), Dual(seed, 0.0));
            let q2: Vec<_> = (0..q.len()).map(|k| pair(q[k], v[k], 0.0)).collect();
            let v2: Vec<_> = (0..q.len()).map(|k| pair(v[k], a[k], one(i, k))).collect();
            let momentum_rate = self.lagrangian(&q2, &v2).1.1;
            let q1: Vec<_> = (0..q.len()).map(|k| Dual(q[k], one(i, k))).collect();
            let v1: Vec<_> = v.iter().map(|&x| Dual(x, 0.0)).collect();
            momentum_rate - self.lagrangian(&q1, &v1).1
        };
        (0..q.len()).map(component).collect()
    }

    /// ∂²K/∂q̇∂q̇, column after column.
    pub fn mass_matrix(&self, q: &[f64]) -> Vec<f64> {
        let n = q.len();
        let one = |i: usize, k: usize| f64::from(u8::from(i == k));
        let element = |i: usize, j: usize| {
            let q2: Vec<_> = q.iter().map(|&x| Dual(Dual(x, 0.0), Dual(0.0, 0.0))).collect();
            let v2: Vec<_> = (0..n).map(|k| Dual(Dual(0.0, one(j, k)), Dual(one(i, k), 0.0))).collect();
            self.energies(&q2, &v2).0.1.1
        };
        (0..n * n).map(|k| element(k % n, k / n)).collect()
    }
}
