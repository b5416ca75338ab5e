//! Which inertial parameters a regressor has as columns, and how the thesis' lists follow from the ten
//! standard ones.
use super::arithmetic::Arithmetic;
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;
use std::collections::BTreeMap;

/// A list of parameters per link.
///
/// All of them are about the origin and in the axes of the body's main link; links on fixed joints belong to
/// that body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterList {
    /// m, m cₓ, m c_y, m c_z and the six moments of inertia about the link's origin.
    Standard,
    /// m, m cₓ, m c_y, m c_z: the thesis' (5.20), enough for the centre of mass.
    FirstMoments,
    /// The thesis' 16 per link (5.4.2): those four, the moments of inertia about the centre of mass and
    /// m cᵢ cⱼ. Their rank is that of [`Self::Standard`]: I and m cᵢ cⱼ only appear together.
    Thesis16,
}

impl std::str::FromStr for ParameterList {
    type Err = Diagnostic;
    /// `standard`, `first-moments`, `thesis16`.
    fn from_str(name: &str) -> Result<Self, Diagnostic> {
        match name {
            "standard" => Ok(Self::Standard),
            "first-moments" => Ok(Self::FirstMoments),
            "thesis16" => Ok(Self::Thesis16),
            _ => Err(Diagnostic::error(format!("`{name}` is no list of inertial parameters"))
                .help("lists are standard (ten per link), first-moments (four), thesis16")),
        }
    }
}

/// One column of a regressor: one inertial parameter of one body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Column {
    /// `body.m`, `body.m*cx`, `body.Ixx`; in the list of 16 `body.Ixx_com`, `body.m*cx*cy`.
    pub name: String,
    /// Name of the body: that of its main link.
    pub link: String,
    /// The name without the body: `m`, `m*cx`, `Ixx`, …
    pub parameter: &'static str,
    /// `kg`, `kg m` or `kg m²`.
    pub unit: &'static str,
    /// Index of the body in the tree.
    #[serde(skip)]
    pub body: usize,
    /// Sum of standard parameters' columns, `(k of the ten, sign)`.
    #[serde(skip)]
    parts: &'static [(u32, bool)],
}

type ColumnPart = (&'static str, &'static str, &'static [(u32, bool)]);

const MASS: [ColumnPart; 4] = [
    ("m", "kg", &[(0, true)]),
    ("m*cx", "kg m", &[(1, true)]),
    ("m*cy", "kg m", &[(2, true)]),
    ("m*cz", "kg m", &[(3, true)]),
];

const INERTIA: [ColumnPart; 6] = [
    ("Ixx", "kg m²", &[(4, true)]),
    ("Ixy", "kg m²", &[(5, true)]),
    ("Ixz", "kg m²", &[(6, true)]),
    ("Iyy", "kg m²", &[(7, true)]),
    ("Iyz", "kg m²", &[(8, true)]),
    ("Izz", "kg m²", &[(9, true)]),
];

// L = I + m (c² 1 − c cᵀ): m cₓ² adds to L_yy and L_zz, m cₓ c_y to −L_xy.
const CENTRAL: [ColumnPart; 12] = [
    ("Ixx_com", "kg m²", &[(4, true)]),
    ("Iyy_com", "kg m²", &[(7, true)]),
    ("Izz_com", "kg m²", &[(9, true)]),
    ("Ixy_com", "kg m²", &[(5, true)]),
    ("Iyz_com", "kg m²", &[(8, true)]),
    ("Ixz_com", "kg m²", &[(6, true)]),
    ("m*cx*cx", "kg m²", &[(7, true), (9, true)]),
    ("m*cy*cy", "kg m²", &[(4, true), (9, true)]),
    ("m*cz*cz", "kg m²", &[(4, true), (7, true)]),
    ("m*cx*cy", "kg m²", &[(5, false)]),
    ("m*cy*cz", "kg m²", &[(8, false)]),
    ("m*cx*cz", "kg m²", &[(6, false)]),
];

impl ParameterList {
    fn parts(self) -> Vec<ColumnPart> {
        match self {
            Self::Standard => MASS.iter().chain(&INERTIA).copied().collect(),
            Self::FirstMoments => MASS.to_vec(),
            Self::Thesis16 => MASS.iter().chain(&CENTRAL).copied().collect(),
        }
    }

    /// The columns for a tree, from the root outwards.
    pub fn columns(self, tree: &Tree) -> Vec<Column> {
        let real = tree.bodies.iter().enumerate().filter(|(_, body)| !body.is_virtual);
        real.flat_map(|(index, body)| {
            self.parts().into_iter().map(move |(name, unit, parts)| Column {
                name: format!("{}.{name}", body.name),
                link: body.name.clone(),
                parameter: name,
                unit,
                body: index,
                parts,
            })
        })
        .collect()
    }

    /// The columns in the order in which they are preferred as representatives of their group.
    ///
    /// Bodies near the root come first: what moves rigidly with the parent is grouped into the parent. Within
    /// a body moments of inertia come before first moments, these before the mass: so factors are lengths and
    /// their squares, not their inverses.
    pub fn preference(self, tree: &Tree) -> Vec<usize> {
        let columns = self.columns(tree);
        let moment = |column: &Column| column.parts[0].0.min(4).div_ceil(3);
        let mut order: Vec<usize> = (0..columns.len()).collect();
        order.sort_by_key(|&c| (columns[c].body, std::cmp::Reverse(moment(&columns[c])), c));
        order
    }

    /// The parameters of the description, in the order of [`Self::columns`].
    pub fn values(self, tree: &Tree) -> Vec<f64> {
        let mut out = Vec::new();
        for body in tree.bodies.iter().filter(|body| !body.is_virtual) {
            let ten = body.inertia.transformed(&body.main_link.inverse()).parameters();
            match self {
                Self::Standard => out.extend(ten),
                Self::FirstMoments => out.extend(&ten[..4]),
                Self::Thesis16 => out.extend(central(&ten)),
            }
        }
        out
    }
}

/// The thesis' 16 from the ten; a massless body has its centre of mass at the origin.
fn central(ten: &[f64; 10]) -> Vec<f64> {
    let c = [1, 2, 3].map(|k| if ten[0] == 0.0 { 0.0 } else { ten[k] / ten[0] });
    let product = |i: usize, j: usize| ten[1 + i] * c[j];
    let squares = [product(0, 0), product(1, 1), product(2, 2)];
    let mixed = [product(0, 1), product(1, 2), product(0, 2)];
    let diagonal = [
        ten[4] - squares[1] - squares[2],
        ten[7] - squares[0] - squares[2],
        ten[9] - squares[0] - squares[1],
    ];
    let off = [ten[5] + mixed[0], ten[8] + mixed[1], ten[6] + mixed[2]];
    [&ten[..4], &diagonal, &off, &squares, &mixed].concat()
}

impl Column {
    /// The column's entry in a row given by the coefficients of the standard parameters (10 · body + k).
    pub fn entry<A: Arithmetic>(&self, a: &A, standard: &BTreeMap<u32, A::Value>) -> A::Value {
        self.parts.iter().fold(a.zero(), |sum, &(k, positive)| {
            let Some(&value) = standard.get(&(10 * self.body as u32 + k)) else { return sum };
            if positive { a.add(sum, value) } else { a.sub(sum, value) }
        })
    }
}
