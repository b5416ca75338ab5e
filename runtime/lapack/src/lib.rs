//! The 22 BLAS and LAPACK symbols that clarabel's semidefinite cones call, on nalgebra: so that the solver is built by
//! cargo alone, without Fortran, C or a library of the system.
//!
//! clarabel declares them through `blas-sys` and `lapack-sys`; its features `blas-src` and `lapack-src` name provider
//! crates that are empty without features of their own, and this crate provides the symbols instead. Its cones are small
//! (4 × 4 for a rigid body), so plain loops serve. It is used for linking only: `use bipedc_lapack as _;`.
//!
//! Only what clarabel asks for is there: eigenvalues of all of a matrix (`range = 'A'`), singular vectors `'S'`, `'N'`
//! and, of square matrices, `'A'`. Anything else reports failure through `info`.
mod routines;

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn, RealField, U1};
use std::ffi::{c_char, c_int};

type View<'a, T> = DMatrixView<'a, T, U1, Dyn>;
type ViewMut<'a, T> = DMatrixViewMut<'a, T, U1, Dyn>;

fn size(n: c_int) -> usize {
    usize::try_from(n).unwrap_or(0)
}

/// Elements that a column-major matrix spans.
fn span(rows: usize, columns: usize, leading: usize) -> usize {
    if rows == 0 || columns == 0 { 0 } else { leading * (columns - 1) + rows }
}

/// A character argument as an upper-case letter.
///
/// # Safety
/// Points to a character.
unsafe fn letter(c: *const c_char) -> u8 {
    // SAFETY: as above.
    unsafe { *c }.to_ne_bytes()[0].to_ascii_uppercase()
}

/// A number argument.
///
/// # Safety
/// Points to a number.
unsafe fn number(n: *const c_int) -> usize {
    // SAFETY: as above.
    size(unsafe { *n })
}

/// A matrix that is read.
///
/// # Safety
/// `a` points to `rows × columns` numbers, column after column, `*leading` apart; nobody writes them meanwhile.
unsafe fn view<'a, T: RealField>(
    a: *const T,
    rows: usize,
    columns: usize,
    leading: *const c_int,
) -> View<'a, T> {
    // SAFETY: as above.
    let leading = unsafe { number(leading) };
    let count = span(rows, columns, leading);
    // SAFETY: as above; an empty matrix may have a null pointer.
    let slice = if count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(a, count) } };
    DMatrixView::from_slice_with_strides_generic(slice, Dyn(rows), Dyn(columns), U1, Dyn(leading.max(1)))
}

/// A matrix that is written.
///
/// # Safety
/// As [`view`], and nobody else reads it meanwhile.
unsafe fn view_mut<'a, T: RealField>(
    a: *mut T,
    rows: usize,
    columns: usize,
    leading: *const c_int,
) -> ViewMut<'a, T> {
    // SAFETY: as above.
    let leading = unsafe { number(leading) };
    let count = span(rows, columns, leading);
    // SAFETY: as above; an empty matrix may have a null pointer.
    let slice = if count == 0 { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(a, count) } };
    DMatrixViewMut::from_slice_with_strides_generic(slice, Dyn(rows), Dyn(columns), U1, Dyn(leading.max(1)))
}

macro_rules! symbols {
    ($T:ty: $syevr:ident $potrf:ident $potrs:ident $gesdd:ident $gesvd:ident $gemm:ident $gemv:ident
     $symv:ident $syrk:ident $syr2k:ident $gesv:ident) => {
        symbols!(@solve $T: $syevr $potrf $potrs $gesdd $gesvd $gesv);
        symbols!(@multiply $T: $gemm $gemv $symv $syrk $syr2k);
    };
    (@solve $T:ty: $syevr:ident $potrf:ident $potrs:ident $gesdd:ident $gesvd:ident $gesv:ident) => {
        /// Eigenvalues, ascending, and eigenvectors of a symmetric matrix.
        ///
        /// # Safety
        /// As in LAPACK.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $syevr(
            jobz: *const c_char, range: *const c_char, uplo: *const c_char, n: *const c_int, a: *mut $T,
            lda: *const c_int, _vl: *const $T, _vu: *const $T, _il: *const c_int, _iu: *const c_int,
            _abstol: *const $T, m: *mut c_int, w: *mut $T, z: *mut $T, ldz: *const c_int,
            _isuppz: *mut c_int, work: *mut $T, lwork: *const c_int, iwork: *mut c_int,
            liwork: *const c_int, info: *mut c_int,
        ) {
            // SAFETY: the caller follows LAPACK's documentation of this routine.
            unsafe {
                *info = 0;
                if *lwork == -1 || *liwork == -1 {
                    *work = 1.0;
                    *iwork = 1;
                    return;
                }
                if letter(range) != b'A' {
                    *info = -2;
                    return;
                }
                let (count, vectors) = (number(n), letter(jobz) == b'V');
                let a = view(a.cast_const(), count, count, lda);
                let w = std::slice::from_raw_parts_mut(w, count);
                let z = vectors.then(|| view_mut(z, count, count, ldz));
                *info = routines::eigen(&a, letter(uplo) == b'U', w, z);
                *m = *n;
            }
        }

        /// Cholesky factor.
        ///
        /// # Safety
        /// As in LAPACK.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $potrf(
            uplo: *const c_char, n: *const c_int, a: *mut $T, lda: *const c_int, info: *mut c_int,
        ) {
            // SAFETY: the caller follows LAPACK's documentation of this routine.
            unsafe {
                let n = number(n);
                *info = routines::cholesky(&mut view_mut(a, n, n, lda), letter(uplo) == b'U');
            }
        }

        /// Solves with a Cholesky factor.
        ///
        /// # Safety
        /// As in LAPACK.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $potrs(
            uplo: *const c_char, n: *const c_int, nrhs: *const c_int, a: *const $T, lda: *const c_int,
            b: *mut $T, ldb: *const c_int, info: *mut c_int,
        ) {
            // SAFETY: the caller follows LAPACK's documentation of this routine.
            unsafe {
                *info = 0;
                let n = number(n);
                let a = view(a, n, n, lda);
                routines::cholesky_solve(&a, letter(uplo) == b'U', &mut view_mut(b, n, number(nrhs), ldb));
            }
        }

        /// Singular values and vectors.
        ///
        /// # Safety
        /// As in LAPACK.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gesdd(
            jobz: *const c_char, m: *const c_int, n: *const c_int, a: *mut $T, lda: *const c_int,
            s: *mut $T, u: *mut $T, ldu: *const c_int, vt: *mut $T, ldvt: *const c_int, work: *mut $T,
            lwork: *const c_int, _iwork: *mut c_int, info: *mut c_int,
        ) {
            // SAFETY: the arguments are those of the routine called, but for the letter that stands for both.
            unsafe { $gesvd(jobz, jobz, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info) }
        }

        /// Singular values and vectors.
        ///
        /// # Safety
        /// As in LAPACK.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gesvd(
            jobu: *const c_char, jobvt: *const c_char, m: *const c_int, n: *const c_int, a: *mut $T,
            lda: *const c_int, s: *mut $T, u: *mut $T, ldu: *const c_int, vt: *mut $T, ldvt: *const c_int,
            work: *mut $T, lwork: *const c_int, info: *mut c_int,
        ) {
            // SAFETY: the caller follows LAPACK's documentation of this routine.
            unsafe {
                *info = 0;
                if *lwork == -1 {
                    *work = 1.0;
                    return;
                }
                let (m, n, jobs) = (number(m), number(n), [letter(jobu), letter(jobvt)]);
                let least = m.min(n);
                if jobs.iter().any(|job| *job == b'O' || (*job == b'A' && m != n)) {
                    *info = -1;
                    return;
                }
                let a = view(a.cast_const(), m, n, lda);
                let s = std::slice::from_raw_parts_mut(s, least);
                let u = (jobs[0] != b'N').then(|| view_mut(u, m, least, ldu));
                let vt = (jobs[1] != b'N').then(|| view_mut(vt, least, n, ldvt));
                *info = routines::singular(&a, s, u, vt);
            }
        }

        /// Solves a system by LU.
        ///
        /// # Safety
        /// As in LAPACK; the factor itself is not given back.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gesv(
            n: *const c_int, nrhs: *const c_int, a: *mut $T, lda: *const c_int, _ipiv: *mut c_int,
            b: *mut $T, ldb: *const c_int, info: *mut c_int,
        ) {
            // SAFETY: the caller follows LAPACK's documentation of this routine.
            unsafe {
                let n = number(n);
                let a = view(a.cast_const(), n, n, lda);
                *info = routines::solve(&a, &mut view_mut(b, n, number(nrhs), ldb));
            }
        }
    };
    (@multiply $T:ty: $gemm:ident $gemv:ident $symv:ident $syrk:ident $syr2k:ident) => {
        /// `C ← α A B + β C`, with A and B transposed or not.
        ///
        /// # Safety
        /// As in BLAS.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gemm(
            ta: *const c_char, tb: *const c_char, m: *const c_int, n: *const c_int, k: *const c_int,
            alpha: *const $T, a: *const $T, lda: *const c_int, b: *const $T, ldb: *const c_int,
            beta: *const $T, c: *mut $T, ldc: *const c_int,
        ) {
            // SAFETY: the caller follows BLAS' documentation of this routine.
            unsafe {
                let (m, n, k) = (number(m), number(n), number(k));
                let turned = [letter(ta) != b'N', letter(tb) != b'N'];
                let shape = |turn: bool, r: usize, c: usize| if turn { (c, r) } else { (r, c) };
                let (ar, ac) = shape(turned[0], m, k);
                let (br, bc) = shape(turned[1], k, n);
                let (a, b) = (view(a, ar, ac, lda), view(b, br, bc, ldb));
                routines::multiply(&a, &b, turned, [*alpha, *beta], &mut view_mut(c, m, n, ldc));
            }
        }

        /// `y ← α A x + β y`, with A transposed or not.
        ///
        /// # Safety
        /// As in BLAS, increments positive.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gemv(
            t: *const c_char, m: *const c_int, n: *const c_int, alpha: *const $T, a: *const $T,
            lda: *const c_int, x: *const $T, incx: *const c_int, beta: *const $T, y: *mut $T,
            incy: *const c_int,
        ) {
            // SAFETY: the caller follows BLAS' documentation; a strided vector is a matrix of one row.
            unsafe {
                let (m, n, turned) = (number(m), number(n), letter(t) != b'N');
                let (ny, nx) = if turned { (n, m) } else { (m, n) };
                let (a, x) = (view(a, m, n, lda), view(x, 1, nx, incx));
                routines::multiply(&x, &a, [false, !turned], [*alpha, *beta], &mut view_mut(y, 1, ny, incy));
            }
        }

        /// `y ← α A x + β y`, A symmetric.
        ///
        /// # Safety
        /// As in BLAS, increments positive.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symv(
            uplo: *const c_char, n: *const c_int, alpha: *const $T, a: *const $T, lda: *const c_int,
            x: *const $T, incx: *const c_int, beta: *const $T, y: *mut $T, incy: *const c_int,
        ) {
            // SAFETY: the caller follows BLAS' documentation; a strided vector is a matrix of one row.
            unsafe {
                let n = number(n);
                let full = routines::filled(&view(a, n, n, lda), letter(uplo) == b'U');
                let x = view(x, 1, n, incx);
                let full = full.as_view::<Dyn, Dyn, U1, Dyn>();
                routines::multiply(&x, &full, [false, false], [*alpha, *beta], &mut view_mut(y, 1, n, incy));
            }
        }

        /// One triangle of `C ← α A Aᵀ + β C`, or of `α Aᵀ A + β C`.
        ///
        /// # Safety
        /// As in BLAS.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $syrk(
            uplo: *const c_char, t: *const c_char, n: *const c_int, k: *const c_int, alpha: *const $T,
            a: *const $T, lda: *const c_int, beta: *const $T, c: *mut $T, ldc: *const c_int,
        ) {
            // SAFETY: the caller follows BLAS' documentation; half of twice A Aᵀ is A Aᵀ.
            unsafe {
                let half = 0.5 * *alpha;
                $syr2k(uplo, t, n, k, &half, a, lda, a, lda, beta, c, ldc);
            }
        }

        /// One triangle of `C ← α (A Bᵀ + B Aᵀ) + β C`, or with the transposed first.
        ///
        /// # Safety
        /// As in BLAS.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $syr2k(
            uplo: *const c_char, t: *const c_char, n: *const c_int, k: *const c_int, alpha: *const $T,
            a: *const $T, lda: *const c_int, b: *const $T, ldb: *const c_int, beta: *const $T, c: *mut $T,
            ldc: *const c_int,
        ) {
            // SAFETY: the caller follows BLAS' documentation of this routine.
            unsafe {
                let (n, k, turned) = (number(n), number(k), letter(t) != b'N');
                let (rows, columns) = if turned { (k, n) } else { (n, k) };
                let (a, b) = (view(a, rows, columns, lda), view(b, rows, columns, ldb));
                let c = &mut view_mut(c, n, n, ldc);
                routines::rank_two(&a, &b, turned, letter(uplo) == b'U', [*alpha, *beta], c);
            }
        }
    };
}

symbols!(f64: dsyevr_ dpotrf_ dpotrs_ dgesdd_ dgesvd_ dgemm_ dgemv_ dsymv_ dsyrk_ dsyr2k_ dgesv_);
symbols!(f32: ssyevr_ spotrf_ spotrs_ sgesdd_ sgesvd_ sgemm_ sgemv_ ssymv_ ssyrk_ ssyr2k_ sgesv_);
