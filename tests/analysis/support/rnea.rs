//! A plain recursive Newton-Euler algorithm over a URDF tree, numeric and slow, kept only for tests.
//!
//! Fixed joints keep their links; bases are fixed or floating (q: position, quaternion x y z w; v and a in the
//! root's axes). Gravity is 9.81 m/s² along −z.
use bipedc_analysis::robot::{BaseKind, Batch, EvaluationError, InverseDynamics};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

type V3 = Vector3<f64>;

struct Link {
    name: String,
    mass: f64,
    com: V3,
    inertia: Matrix3<f64>,
}

/// A joint and the link below it.
struct Body {
    parent: usize,
    name: String,
    /// `None`: fixed.
    axis: Option<V3>,
    translation: V3,
    rotation: Matrix3<f64>,
    link: Link,
}

pub struct Robot {
    base: BaseKind,
    root: Link,
    /// Parents first; body i has index i + 1 among the links.
    bodies: Vec<Body>,
}

fn numbers(node: roxmltree::Node<'_, '_>, attribute: &str) -> V3 {
    let text = node.attribute(attribute).unwrap_or("0 0 0");
    V3::from_iterator(text.split_whitespace().map(|n| n.parse().unwrap()))
}

fn child<'a, 'i>(node: roxmltree::Node<'a, 'i>, name: &str) -> Option<roxmltree::Node<'a, 'i>> {
    node.children().find(|c| c.has_tag_name(name))
}

fn origin(node: roxmltree::Node<'_, '_>) -> (V3, Matrix3<f64>) {
    let Some(origin) = child(node, "origin") else { return (V3::zeros(), Matrix3::identity()) };
    let rpy = numbers(origin, "rpy");
    (numbers(origin, "xyz"), Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z).into_inner())
}

fn link(root: roxmltree::Node<'_, '_>, name: &str) -> Link {
    let node = root.children().find(|n| n.has_tag_name("link") && n.attribute("name") == Some(name)).unwrap();
    let Some(inertial) = child(node, "inertial") else {
        return Link { name: name.into(), mass: 0.0, com: V3::zeros(), inertia: Matrix3::zeros() };
    };
    let (com, rotation) = origin(inertial);
    let mass = child(inertial, "mass").unwrap().attribute("value").unwrap().parse().unwrap();
    let inertia = child(inertial, "inertia").unwrap();
    let i = |name: &str| inertia.attribute(name).unwrap().parse::<f64>().unwrap();
    let (xy, xz, yz) = (i("ixy"), i("ixz"), i("iyz"));
    let about_com = Matrix3::new(i("ixx"), xy, xz, xy, i("iyy"), yz, xz, yz, i("izz"));
    Link { name: name.into(), mass, com, inertia: rotation * about_com * rotation.transpose() }
}

impl Robot {
    pub fn parse(urdf: &str, base: BaseKind) -> Self {
        let document = roxmltree::Document::parse(urdf).unwrap();
        let root = document.root_element();
        let joints: Vec<_> = root.children().filter(|n| n.has_tag_name("joint")).collect();
        let end = |joint: roxmltree::Node<'_, '_>, tag| {
            child(joint, tag).unwrap().attribute("link").unwrap().to_owned()
        };
        let children: Vec<_> = joints.iter().map(|j| end(*j, "child")).collect();
        let links = root.children().filter(|n| n.has_tag_name("link")).filter_map(|n| n.attribute("name"));
        let top = links.into_iter().find(|name| !children.iter().any(|c| c == name)).unwrap();
        let mut robot = Self { base, root: link(root, top), bodies: Vec::new() };
        // Repeated passes put parents before children whatever the order in the file.
        while robot.bodies.len() < joints.len() {
            for joint in &joints {
                let (parent, below) = (end(*joint, "parent"), end(*joint, "child"));
                if robot.index(&below).is_some() {
                    continue;
                }
                let Some(parent) = robot.index(&parent) else { continue };
                let (translation, rotation) = origin(*joint);
                let axis = child(*joint, "axis").map_or(V3::x(), |a| numbers(a, "xyz").normalize());
                let kind = joint.attribute("type").unwrap();
                assert!(matches!(kind, "revolute" | "continuous" | "fixed"), "{kind}");
                let name = joint.attribute("name").unwrap().to_owned();
                let axis = (kind != "fixed").then_some(axis);
                robot.bodies.push(Body {
                    parent,
                    name,
                    axis,
                    translation,
                    rotation,
                    link: link(root, &below),
                });
            }
        }
        robot
    }

    fn index(&self, link: &str) -> Option<usize> {
        let names = std::iter::once(&self.root).chain(self.bodies.iter().map(|b| &b.link));
        names.into_iter().position(|l| l.name == link)
    }

    pub fn base(&self) -> BaseKind {
        self.base
    }

    pub fn joint_names(&self) -> impl Iterator<Item = String> {
        self.bodies.iter().filter(|b| b.axis.is_some()).map(|b| b.name.clone())
    }

    /// Generalised forces of one state.
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let (mut omega, mut alpha) = (vec![V3::zeros()], vec![V3::zeros()]);
        // Classical acceleration of the link's origin minus gravity, in link axes.
        let mut acceleration = vec![V3::new(0.0, 0.0, 9.81)];
        let mut turns = vec![Matrix3::identity()];
        if self.base == BaseKind::Floating {
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
            omega[0] = V3::from_column_slice(&v[3..6]);
            alpha[0] = V3::from_column_slice(&a[3..6]);
            acceleration[0] = turn.inverse() * acceleration[0]
                + V3::from_column_slice(&a[..3])
                + omega[0].cross(&V3::from_column_slice(&v[..3]));
        }
        let (mut iq, mut iv) = (self.base.nq(), self.base.nv());
        for body in &self.bodies {
            let (mut turn, mut rate, mut second) = (body.rotation, V3::zeros(), V3::zeros());
            if let Some(axis) = body.axis {
                turn *= Rotation3::from_scaled_axis(axis * q[iq]).into_inner();
                (rate, second) = (axis * v[iv], axis * a[iv]);
                (iq, iv) = (iq + 1, iv + 1);
            }
            let p = body.parent;
            let w = turn.transpose() * omega[p];
            let at_joint = acceleration[p]
                + alpha[p].cross(&body.translation)
                + omega[p].cross(&omega[p].cross(&body.translation));
            acceleration.push(turn.transpose() * at_joint);
            alpha.push(turn.transpose() * alpha[p] + second + w.cross(&rate));
            omega.push(w + rate);
            turns.push(turn);
        }
        self.backwards(&turns, &omega, &alpha, &acceleration)
    }

    fn backwards(&self, turns: &[Matrix3<f64>], omega: &[V3], alpha: &[V3], acceleration: &[V3]) -> Vec<f64> {
        let links = std::iter::once(&self.root).chain(self.bodies.iter().map(|b| &b.link));
        let mut wrenches: Vec<(V3, V3)> = links
            .enumerate()
            .map(|(i, l)| {
                let (w, dw) = (omega[i], alpha[i]);
                let force = l.mass * (acceleration[i] + dw.cross(&l.com) + w.cross(&w.cross(&l.com)));
                (force, l.inertia * dw + w.cross(&(l.inertia * w)) + l.com.cross(&force))
            })
            .collect();
        let mut tau = Vec::new();
        for (i, body) in self.bodies.iter().enumerate().rev() {
            let (force, moment) = wrenches[i + 1];
            tau.extend(body.axis.map(|axis| axis.dot(&moment)));
            let (force, moment) = (turns[i + 1] * force, turns[i + 1] * moment);
            let parent = &mut wrenches[body.parent];
            parent.0 += force;
            parent.1 += moment + body.translation.cross(&force);
        }
        if self.base == BaseKind::Floating {
            let (force, moment) = wrenches[0];
            tau.extend([moment.z, moment.y, moment.x, force.z, force.y, force.x]);
        }
        tau.reverse();
        tau
    }
}

impl InverseDynamics for Robot {
    fn nq(&self) -> usize {
        self.base.nq() + self.joint_names().count()
    }
    fn nv(&self) -> usize {
        self.base.nv() + self.joint_names().count()
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        let (nq, nv) = (self.nq(), self.nv());
        for i in 0..batch.count {
            let part = |values: &[f64], n: usize| values[i * n..(i + 1) * n].to_vec();
            let result = self.inverse_dynamics(&part(batch.q, nq), &part(batch.v, nv), &part(batch.a, nv));
            tau[i * nv..(i + 1) * nv].copy_from_slice(&result);
        }
        Ok(())
    }
}
