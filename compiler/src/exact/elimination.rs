//! Row reduction over a prime field, one row at a time.
use super::arithmetic::Arithmetic;
use super::field::Field;

/// The space that the rows so far span, in echelon form: each kept row starts with a 1 at its pivot.
pub struct Echelon {
    field: Field,
    /// By pivot column.
    rows: Vec<Option<Vec<u64>>>,
}

impl Echelon {
    /// No rows yet.
    pub fn new(field: Field, columns: usize) -> Self {
        Self { field, rows: vec![None; columns] }
    }

    /// Adds a row; tells whether it was independent.
    pub fn insert(&mut self, mut row: Vec<u64>) -> bool {
        for column in 0..self.rows.len() {
            if row[column] == 0 {
                continue;
            }
            if let Some(pivot) = &self.rows[column] {
                subtract(self.field, &mut row, pivot, column);
                continue;
            }
            let inverse = self.field.inverse(row[column]);
            for x in &mut row[column..] {
                *x = self.field.product(*x, inverse);
            }
            self.rows[column] = Some(row);
            return true;
        }
        false
    }

    /// Dimension of the space.
    pub fn rank(&self) -> usize {
        self.rows.iter().flatten().count()
    }

    /// The reduced echelon form, which depends on the space alone: (pivot column, row) by column.
    pub fn reduced(mut self) -> Vec<(usize, Vec<u64>)> {
        // From the right: every row then already is reduced when it is subtracted from others.
        for column in (0..self.rows.len()).rev() {
            let Some(mut row) = self.rows[column].take() else { continue };
            for other in column + 1..self.rows.len() {
                if let (true, Some(pivot)) = (row[other] != 0, &self.rows[other]) {
                    subtract(self.field, &mut row, pivot, other);
                }
            }
            self.rows[column] = Some(row);
        }
        let numbered = self.rows.into_iter().enumerate();
        numbered.filter_map(|(column, row)| row.map(|row| (column, row))).collect()
    }
}

/// Takes the multiple of `pivot` away that clears `row[column]`.
fn subtract(field: Field, row: &mut [u64], pivot: &[u64], column: usize) {
    let factor = field.neg(row[column]);
    for (x, &p) in row.iter_mut().zip(pivot).skip(column) {
        if p != 0 {
            *x = field.add(*x, field.product(factor, p));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::random::Random;

    #[test]
    fn the_reduced_form_depends_on_the_space_alone() {
        let field = Field::all().nth(1).unwrap();
        let mut random = Random::new(7);
        let basis: Vec<Vec<u64>> =
            (0..4).map(|_| (0..9).map(|_| field.random(&mut random)).collect()).collect();
        let mut forms = (0..2).map(|_| {
            let mut echelon = Echelon::new(field, 9);
            for _ in 0..6 {
                let weights: Vec<u64> = (0..4).map(|_| field.random(&mut random)).collect();
                let entry = |c: usize| {
                    (0..4).fold(0, |sum, r: usize| field.add(sum, field.product(weights[r], basis[r][c])))
                };
                echelon.insert((0..9).map(entry).collect());
            }
            assert_eq!(echelon.rank(), 4);
            echelon.reduced()
        });
        let (first, second) = (forms.next().unwrap(), forms.next().unwrap());
        assert_eq!(first, second);
        assert!(first.iter().enumerate().all(|(i, (pivot, row))| *pivot == i && row[i] == 1));
    }
}
