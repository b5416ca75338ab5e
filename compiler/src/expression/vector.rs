//! Vectors and matrices of three; structural zeros vanish because the graph folds them.
use super::graph::Graph;
use super::symbol::Sym;
use std::ops::{Add, Index, IndexMut, Mul, Neg, Sub};

/// Three components.
#[derive(Debug, Clone, Copy)]
pub struct Vector3<'g>(pub [Sym<'g>; 3]);

/// Three rows.
#[derive(Debug, Clone, Copy)]
pub struct Matrix3<'g>(pub [[Sym<'g>; 3]; 3]);

impl<'g> Vector3<'g> {
    /// A constant vector.
    pub fn constant(graph: &'g Graph, value: [f64; 3]) -> Self {
        Self(value.map(|x| Sym::new(graph, graph.constant(x))))
    }
    /// Zero.
    pub fn zero(graph: &'g Graph) -> Self {
        Self::constant(graph, [0.0; 3])
    }
    /// Whether all components are the constant 0.
    pub fn is_zero(self) -> bool {
        self.0.iter().all(|x| x.is_zero())
    }
    /// Cross product.
    pub fn cross(self, b: Self) -> Self {
        let a = self;
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }
    /// Scalar product.
    pub fn dot(self, b: Self) -> Sym<'g> {
        self[0] * b[0] + self[1] * b[1] + self[2] * b[2]
    }
    /// All components times `factor`.
    pub fn scale(self, factor: Sym<'g>) -> Self {
        Self(self.0.map(|x| x * factor))
    }
    /// The matrix that does `self ×`.
    pub fn skew(self) -> Matrix3<'g> {
        let [x, y, z] = self.0;
        let o = x.zero();
        Matrix3([[o, -z, y], [z, o, -x], [-y, x, o]])
    }
}

impl<'g> Matrix3<'g> {
    /// A constant matrix, given by rows.
    pub fn constant(graph: &'g Graph, rows: [[f64; 3]; 3]) -> Self {
        Self(rows.map(|row| row.map(|x| Sym::new(graph, graph.constant(x)))))
    }
    /// The unit matrix.
    pub fn identity(graph: &'g Graph) -> Self {
        Self::constant(graph, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    }
    /// Columns side by side.
    pub fn from_columns(columns: [Vector3<'g>; 3]) -> Self {
        Self([0, 1, 2].map(|r| [0, 1, 2].map(|c| columns[c][r])))
    }
    /// Column `c`.
    pub fn column(self, c: usize) -> Vector3<'g> {
        Vector3([self.0[0][c], self.0[1][c], self.0[2][c]])
    }
    /// Row `r`.
    pub fn row(self, r: usize) -> Vector3<'g> {
        Vector3(self.0[r])
    }
    /// Transpose.
    pub fn transpose(self) -> Self {
        Self([0, 1, 2].map(|r| [0, 1, 2].map(|c| self.0[c][r])))
    }
    /// Each element through `f`.
    pub fn map(self, f: impl Fn(Sym<'g>) -> Sym<'g>) -> Self {
        Self(self.0.map(|row| row.map(&f)))
    }
}

impl<'g> Index<usize> for Vector3<'g> {
    type Output = Sym<'g>;
    fn index(&self, i: usize) -> &Sym<'g> {
        &self.0[i]
    }
}
impl<'g> IndexMut<usize> for Vector3<'g> {
    fn index_mut(&mut self, i: usize) -> &mut Sym<'g> {
        &mut self.0[i]
    }
}
impl<'g> Index<(usize, usize)> for Matrix3<'g> {
    type Output = Sym<'g>;
    fn index(&self, (r, c): (usize, usize)) -> &Sym<'g> {
        &self.0[r][c]
    }
}
impl<'g> IndexMut<(usize, usize)> for Matrix3<'g> {
    fn index_mut(&mut self, (r, c): (usize, usize)) -> &mut Sym<'g> {
        &mut self.0[r][c]
    }
}
impl<'g> Add for Vector3<'g> {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self([0, 1, 2].map(|i| self[i] + b[i]))
    }
}
impl<'g> Sub for Vector3<'g> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self([0, 1, 2].map(|i| self[i] - b[i]))
    }
}
impl<'g> Neg for Vector3<'g> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}
impl<'g> Mul<Vector3<'g>> for Matrix3<'g> {
    type Output = Vector3<'g>;
    fn mul(self, v: Vector3<'g>) -> Vector3<'g> {
        Vector3([0, 1, 2].map(|r| self.row(r).dot(v)))
    }
}
impl<'g> Mul for Matrix3<'g> {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self([0, 1, 2].map(|r| [0, 1, 2].map(|c| self.row(r).dot(b.column(c)))))
    }
}
impl<'g> Add for Matrix3<'g> {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self([0, 1, 2].map(|r| [0, 1, 2].map(|c| self.0[r][c] + b.0[r][c])))
    }
}
impl<'g> Sub for Matrix3<'g> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self([0, 1, 2].map(|r| [0, 1, 2].map(|c| self.0[r][c] - b.0[r][c])))
    }
}
