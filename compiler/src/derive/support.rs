//! Which rows a set of contacts means, from geometry alone: no rows that repeat each other on one foot.
use super::contact::{is_planar, zero_rotations};
use crate::description::model::{Contact, ContactPart, Foot};
use crate::tree::{BaseKind, JointMotion, NEARLY_RIGHT, Tree};
use bipedc_effects::diagnostic::Diagnostic;

/// Lengths (m) and direction cosines below this are rounding.
const TOLERANCE: f64 = 1e-9;

/// A foot that stands still, wholly or in part, as directions fixed in its body.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// Name of the foot.
    pub foot: String,
    /// The body that carries it.
    pub body: usize,
    /// The point whose velocity vanishes, in body axes, m: the contact point, the middle of the edge, or the
    /// middle of all points of the sole.
    pub point: [f64; 3],
    /// Directions, in body axes, in which it may not move and about which it may not turn.
    pub kind: SupportKind,
}

/// How much of a foot stands.
#[derive(Debug, Clone, PartialEq)]
pub enum SupportKind {
    /// A point: three rows (planar: two). The directions span the space or the plane.
    Point {
        /// Unit directions in body axes.
        linear: Vec<[f64; 3]>,
    },
    /// An edge: the three rows of its middle, and no turn but about the edge.
    Edge {
        /// Perpendicular to the edge, along the sole: edge × normal.
        across: [f64; 3],
        /// Perpendicular to the edge and to `across`; vertical when the foot stands flat.
        normal: [f64; 3],
    },
    /// The whole sole: six rows (planar: three).
    Flat {
        /// Unit directions in body axes.
        linear: Vec<[f64; 3]>,
        /// Unit directions of turns: all three axes, or the normal of the plane (world +y).
        angular: Vec<[f64; 3]>,
    },
    /// The foot is the root of a pivoting base and stands on more than the pivot: the pivot's angle is held.
    Pivot,
}

impl Support {
    /// The same in [`Tree::structure`]: directions within [`NEARLY_RIGHT`] of a coordinate axis or plane lie in it.
    pub(super) fn straightened(&self) -> Self {
        let straight = |d: &[f64; 3]| unit(d.map(|x| if x.abs() < NEARLY_RIGHT { 0.0 } else { x }));
        let all = |list: &[[f64; 3]]| list.iter().map(straight).collect::<Vec<_>>();
        let kind = match &self.kind {
            SupportKind::Point { linear } => SupportKind::Point { linear: all(linear) },
            SupportKind::Edge { across, normal } => {
                SupportKind::Edge { across: straight(across), normal: straight(normal) }
            }
            SupportKind::Flat { linear, angular } => {
                SupportKind::Flat { linear: all(linear), angular: all(angular) }
            }
            SupportKind::Pivot => SupportKind::Pivot,
        };
        let point = self.point.map(|x| if x.abs() < TOLERANCE { 0.0 } else { x });
        Self { foot: self.foot.clone(), body: self.body, point, kind }
    }
}

/// The contacts' points of one foot, in body axes.
struct StandingFoot<'a> {
    foot: &'a Foot,
    body: Option<usize>,
    points: Vec<[f64; 3]>,
    /// The same in [`Tree::structure`].
    structure: Vec<[f64; 3]>,
    /// Some contact names the whole foot.
    whole: bool,
}

/// What stands still under `contacts`, one entry per foot in the order of first mention.
///
/// All contacts of one foot count together: rows follow from the points that touch the ground, so two edges
/// of one sole, or three corners, are the whole sole, and in the plane heel and toe are. A foot with one point
/// only stands on that point however it is named. A foot that the base itself holds (fixed there, or pivoting about the same point or edge)
/// has no entry. What remains can depend on each other only through closed chains of two feet: in flat double
/// support the rows are independent as long as the legs between them have six degrees of freedom (planar:
/// three) and are not stretched.
///
/// # Errors
/// A contact that names no foot, edge or point, or an edge of no length.
pub fn supports(tree: &Tree, feet: &[Foot], contacts: &[Contact]) -> Result<Vec<Support>, Diagnostic> {
    let mut standing: Vec<StandingFoot<'_>> = Vec::new();
    for contact in contacts {
        let foot = feet.iter().find(|foot| foot.name == contact.foot).ok_or_else(|| {
            let known: Vec<&str> = feet.iter().map(|foot| foot.name.as_str()).collect();
            Diagnostic::error(format!("contact `{}`: there is no such foot", contact.foot))
                .help(format!("feet are: {}", known.join(", ")))
        })?;
        for name in point_names(foot, &contact.part)? {
            let at =
                tree.points.iter().position(|p| is_point(&p.name, &foot.name, name)).ok_or_else(|| {
                    Diagnostic::error(format!("contact `{}/{name}`: there is no such point", foot.name))
                })?;
            let (frame, straight) = (&tree.points[at], &tree.structure().points[at]);
            let entry = match standing.iter().position(|s| s.foot.name == foot.name) {
                Some(at) => &mut standing[at],
                None => {
                    standing.push(StandingFoot {
                        foot,
                        body: frame.body,
                        points: Vec::new(),
                        structure: Vec::new(),
                        whole: false,
                    });
                    let last = standing.len() - 1;
                    &mut standing[last]
                }
            };
            entry.whole |= contact.part == ContactPart::Flat;
            entry.points.push(frame.placement.translation);
            entry.structure.push(straight.placement.translation);
        }
    }
    Ok(standing.iter().filter_map(|s| support(tree, s)).collect())
}

fn is_point(full: &str, foot: &str, point: &str) -> bool {
    full.strip_prefix(foot).and_then(|rest| rest.strip_prefix('/')) == Some(point)
}

fn point_names<'a>(foot: &'a Foot, part: &'a ContactPart) -> Result<Vec<&'a str>, Diagnostic> {
    match part {
        ContactPart::Flat => Ok(foot.points.iter().map(|point| point.name.as_str()).collect()),
        ContactPart::Point(name) => Ok(vec![name]),
        ContactPart::Edge(name) => match foot.edges.iter().find(|edge| edge.name == *name) {
            Some(edge) => Ok(edge.points.iter().map(String::as_str).collect()),
            None => {
                let known: Vec<&str> = foot.edges.iter().map(|edge| edge.name.as_str()).collect();
                Err(Diagnostic::error(format!("contact `{}/{name}`: there is no such edge", foot.name))
                    .help(format!("edges of `{}` are: {}", foot.name, known.join(", "))))
            }
        },
    }
}

fn support(tree: &Tree, standing: &StandingFoot<'_>) -> Option<Support> {
    let body = standing.body?;
    let make = |point, kind| Some(Support { foot: standing.foot.name.clone(), body, point, kind });
    if tree.base == BaseKind::Pivot && body == 0 {
        let JointMotion::Revolute { axis, .. } = tree.bodies[0].motion else { return None };
        let off_axis = |p: &[f64; 3]| p[(axis + 1) % 3].hypot(p[(axis + 2) % 3]) > TOLERANCE;
        return standing
            .structure
            .iter()
            .any(off_axis)
            .then_some(())
            .and_then(|()| make([0.0; 3], SupportKind::Pivot));
    }
    let upright = |tree: &Tree| zero_rotations(tree)[body].map(|row| row.map(tidy));
    let world = upright(tree);
    let planar = is_planar(tree).then_some(world[1]);
    let straight = planar.map(|_| upright(tree.structure())[1]);
    let linear = planar.map_or_else(axes, |normal| in_plane(normal).to_vec());
    let extent = match extent(&standing.structure, straight) {
        Extent::Line if standing.whole => Extent::Area,
        extent => extent,
    };
    let middle = mean(&standing.points);
    match extent {
        Extent::Point => make(middle, SupportKind::Point { linear }),
        Extent::Line => {
            let direction = unit(farthest(&offsets(&standing.points, None))?);
            let across = unit(cross(direction, level(world[2], direction)));
            make(middle, SupportKind::Edge { across, normal: unit(cross(across, direction)) })
        }
        Extent::Area => {
            let sole: Vec<[f64; 3]> = sole_points(tree, standing.foot);
            let angular = planar.map_or_else(axes, |normal| vec![normal]);
            make(mean(&sole), SupportKind::Flat { linear, angular })
        }
    }
}

fn sole_points(tree: &Tree, foot: &Foot) -> Vec<[f64; 3]> {
    let of_foot = |name: &str| foot.points.iter().any(|p| is_point(name, &foot.name, &p.name));
    tree.points.iter().filter(|p| of_foot(&p.name)).map(|p| p.placement.translation).collect()
}

/// How far a set of points reaches.
enum Extent {
    Point,
    Line,
    Area,
}

/// From the first point to each, in the plane with this normal if there is one.
fn offsets(points: &[[f64; 3]], planar: Option<[f64; 3]>) -> Vec<[f64; 3]> {
    let from_first = |p: &[f64; 3]| {
        let d = [0, 1, 2].map(|i| p[i] - points[0][i]);
        planar.map_or(d, |n| [0, 1, 2].map(|i| d[i] - dot(d, n) * n[i]))
    };
    points.iter().map(from_first).collect()
}

fn farthest(offsets: &[[f64; 3]]) -> Option<[f64; 3]> {
    offsets.iter().copied().max_by(|a, b| length(*a).total_cmp(&length(*b)))
}

/// In the plane, points beside each other are one point and any two others fix the foot.
fn extent(points: &[[f64; 3]], planar: Option<[f64; 3]>) -> Extent {
    let offsets = offsets(points, planar);
    let Some(farthest) = farthest(&offsets) else { return Extent::Point };
    if length(farthest) < TOLERANCE {
        return Extent::Point;
    }
    let direction = unit(farthest);
    if planar.is_some() || offsets.iter().any(|d| length(cross(*d, direction)) > TOLERANCE) {
        return Extent::Area;
    }
    Extent::Line
}

/// `up`, unless it runs along the edge: then any other direction does.
fn level(up: [f64; 3], edge: [f64; 3]) -> [f64; 3] {
    if length(cross(edge, up)) > TOLERANCE { up } else { [up[1], up[2], up[0]] }
}

fn axes() -> Vec<[f64; 3]> {
    vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
}

/// Two unit directions perpendicular to `normal`: coordinate axes where possible.
fn in_plane(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let smallest = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let mut start = [0.0; 3];
    start[smallest] = 1.0;
    let first = unit(cross(normal, start));
    [first, unit(cross(normal, first))]
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    let n = points.len() as f64;
    [0, 1, 2].map(|i| {
        let x = points.iter().map(|p| p[i]).sum::<f64>() / n;
        // Symmetric corners leave 1e-18 m behind, which would cost operations.
        if x.abs() < 1e-15 { 0.0 } else { x }
    })
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let n = length(a);
    a.map(|x| tidy(x / n))
}

/// Direction cosines within rounding of 0 and ±1 are meant to be on them.
fn tidy(x: f64) -> f64 {
    let near = x.round();
    if (x - near).abs() < 1e-14 { near } else { x }
}
