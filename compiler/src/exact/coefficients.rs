//! The space that a regressor's rows span, and its exact coefficients from several primes.
use super::arithmetic::Rounded;
use super::elimination::Echelon;
use super::field::Field;
use super::fraction::{Fraction, chinese_remainder};
use super::least_squares::solve;
use super::regressor::Regressor;
use super::states::StateSpace;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::random::Random;
use num_bigint::BigInt;
use num_traits::ToPrimitive;

/// States without new information after which the rank counts as final. One would do: a random state misses
/// what is left to find with a probability of about degree / 2⁶¹.
const IDLE_STATES: usize = 3;

/// Primes after which coefficients that are still too long are given as rounded numbers.
const PRIMES: usize = 6;

/// The same after so many primes in a row that certified nothing.
const IDLE_PRIMES: usize = 2;

/// The reduced echelon form of one field, pivots first.
type Reduced = Vec<(usize, Vec<u64>)>;

/// A coefficient of a dependent column.
#[derive(Debug, Clone, PartialEq)]
pub enum Coefficient {
    /// Certified with a prime and states that were not used to find it.
    Exact(Fraction),
    /// Too long; from a least-squares fit in the exactly known pattern.
    Rounded(f64),
}

/// One row of the reduced form: the pivot column and what is grouped with it.
pub struct Group {
    /// The column that represents the group.
    pub leading: usize,
    /// The other columns and their coefficients.
    pub others: Vec<(usize, Coefficient)>,
}

/// The reduced form, in exact numbers.
pub struct Groups {
    /// By leading column.
    pub groups: Vec<Group>,
    /// Primes that took part.
    pub primes: usize,
}

/// Eliminates over one field.
fn reduce(
    field: Field,
    regressor: &Regressor<'_>,
    space: &StateSpace<'_>,
    seed: u64,
) -> Result<Reduced, Diagnostic> {
    let evaluator = regressor.evaluator(field)?;
    let mut random = Random::new(seed ^ field.prime());
    let mut echelon = Echelon::new(field, regressor.columns.len());
    let mut idle = 0;
    while idle < IDLE_STATES {
        let rank = echelon.rank();
        for row in regressor.random_rows(&evaluator, space, &mut random)? {
            echelon.insert(regressor.preference.iter().map(|&column| row[column]).collect());
        }
        idle = if echelon.rank() == rank { idle + 1 } else { 0 };
    }
    Ok(in_column_order(echelon.reduced(), &regressor.preference))
}

/// Undoes the reordering by preference.
fn in_column_order(reduced: Reduced, preference: &[usize]) -> Reduced {
    let restore = |(pivot, row): (usize, Vec<u64>)| {
        let mut restored = vec![0; row.len()];
        for (&column, value) in preference.iter().zip(row) {
            restored[column] = value;
        }
        (preference[pivot], restored)
    };
    let mut out: Reduced = reduced.into_iter().map(restore).collect();
    out.sort_by_key(|(pivot, _)| *pivot);
    out
}

/// One entry on the way to its fraction.
struct Entry {
    group: usize,
    column: usize,
    residue: BigInt,
    candidate: Option<Fraction>,
    certified: bool,
}

/// Finds rank, groups and exact coefficients.
///
/// # Errors
/// States that cannot be drawn, expressions without exact values.
pub fn groups(regressor: &Regressor<'_>, space: &StateSpace<'_>, seed: u64) -> Result<Groups, Diagnostic> {
    let mut fields = Field::all();
    let mut next = || -> Result<(Field, Reduced), Diagnostic> {
        let field = fields.next().ok_or_else(|| Diagnostic::error("out of primes"))?;
        Ok((field, reduce(field, regressor, space, seed)?))
    };
    let pivots = |reduced: &Reduced| reduced.iter().map(|(pivot, _)| *pivot).collect::<Vec<_>>();
    let (field, mut first) = next()?;
    let mut entries = entries(&first);
    let mut modulus = BigInt::from(field.prime());
    propose(&mut entries, &modulus);
    let (mut primes, mut idle) = (1, 0);
    let open = |entries: &[Entry]| entries.iter().filter(|entry| !entry.certified).count();
    // The second field runs even without coefficients: it certifies rank and pattern.
    while primes == 1 || (primes < PRIMES && idle < IDLE_PRIMES && open(&entries) > 0) {
        let (field, reduced) = next()?;
        let before = open(&entries);
        primes += 1;
        if pivots(&reduced) != pivots(&first) || !same_pattern(&reduced, &first) {
            // One of the two primes divides a minor (probability below 2⁻⁴⁰): begin again with this one.
            (entries, modulus) = (self::entries(&reduced), BigInt::from(field.prime()));
            first = reduced;
            (primes, idle) = (1, 0);
        } else {
            certify(&mut entries, field, &reduced, &mut modulus);
            idle = if primes > 2 && open(&entries) == before { idle + 1 } else { 0 };
        }
        propose(&mut entries, &modulus);
    }
    Ok(Groups { groups: collect(&first, &entries, regressor, space, seed)?, primes })
}

fn entries(reduced: &Reduced) -> Vec<Entry> {
    let mut out = Vec::new();
    for (group, (pivot, row)) in reduced.iter().enumerate() {
        for (column, &value) in row.iter().enumerate().filter(|&(c, &x)| c != *pivot && x != 0) {
            out.push(Entry { group, column, residue: value.into(), candidate: None, certified: false });
        }
    }
    out
}

fn same_pattern(a: &Reduced, b: &Reduced) -> bool {
    let same = |x: &[u64], y: &[u64]| x.iter().zip(y).all(|(x, y)| (*x == 0) == (*y == 0));
    a.iter().zip(b).all(|((_, x), (_, y))| same(x, y))
}

/// Guesses the fractions that are not certain yet.
fn propose(entries: &mut [Entry], modulus: &BigInt) {
    for entry in entries.iter_mut().filter(|entry| !entry.certified) {
        entry.candidate = Fraction::from_residue(&entry.residue, modulus);
    }
}

/// Compares the guesses with a fresh prime; where they are wrong, takes its residue in.
fn certify(entries: &mut [Entry], field: Field, reduced: &Reduced, modulus: &mut BigInt) {
    let prime = field.prime();
    let remainder = (&*modulus % prime).to_u64().unwrap_or(1);
    let inverse = field.inverse(remainder);
    for entry in entries.iter_mut().filter(|entry| !entry.certified) {
        let value = reduced[entry.group].1[entry.column];
        entry.certified =
            entry.candidate.as_ref().is_some_and(|candidate| field.fraction(candidate) == Some(value));
        entry.residue = chinese_remainder(&entry.residue, modulus, value, prime, inverse);
    }
    *modulus *= prime;
}

fn collect(
    reduced: &Reduced,
    entries: &[Entry],
    regressor: &Regressor<'_>,
    space: &StateSpace<'_>,
    seed: u64,
) -> Result<Vec<Group>, Diagnostic> {
    let mut groups: Vec<Group> =
        reduced.iter().map(|(leading, _)| Group { leading: *leading, others: Vec::new() }).collect();
    let open: Vec<usize> =
        entries.iter().filter(|entry| !entry.certified).map(|entry| entry.column).collect();
    let fitted = if open.is_empty() { Vec::new() } else { fit(reduced, &open, regressor, space, seed)? };
    for entry in entries {
        let exact = entry.candidate.clone().filter(|_| entry.certified);
        let coefficient = match exact {
            Some(fraction) => Coefficient::Exact(fraction),
            None => Coefficient::Rounded(fitted[entry.column][entry.group]),
        };
        groups[entry.group].others.push((entry.column, coefficient));
    }
    Ok(groups)
}

/// Coefficients of the `open` columns in rounded arithmetic: by column and group.
///
/// The pivot columns are known exactly to be independent, so the fit has full rank.
fn fit(
    reduced: &Reduced,
    open: &[usize],
    regressor: &Regressor<'_>,
    space: &StateSpace<'_>,
    seed: u64,
) -> Result<Vec<Vec<f64>>, Diagnostic> {
    let evaluator = regressor.evaluator(Rounded)?;
    let mut random = Random::new(seed);
    let mut rows: Vec<Vec<f64>> = Vec::new();
    while rows.len() < 2 * reduced.len() + 10 {
        rows.extend(regressor.random_rows(&evaluator, space, &mut random)?);
    }
    let pick = |columns: &[usize]| -> Vec<Vec<f64>> {
        rows.iter().map(|row| columns.iter().map(|&c| row[c]).collect()).collect()
    };
    let pivots: Vec<usize> = reduced.iter().map(|(pivot, _)| *pivot).collect();
    let mut open = open.to_vec();
    open.sort_unstable();
    open.dedup();
    let solution = solve(&pick(&pivots), &pick(&open));
    let mut fitted = vec![vec![0.0; reduced.len()]; regressor.columns.len()];
    for (group, row) in solution.iter().enumerate() {
        for (&column, &value) in open.iter().zip(row) {
            fitted[column][group] = value;
        }
    }
    Ok(fitted)
}
