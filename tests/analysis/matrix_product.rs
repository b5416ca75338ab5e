//! The routines of linear algebra that the solver of semidefinite programs calls by their Fortran names.
use bipedc_lapack::dgemm_;
use std::ffi::c_char;

#[test]
fn a_product_with_strides_and_transposition() {
    // A is 2 × 3 with leading dimension 4, B is the identity: C = 2 Aᵀ + C.
    let a = [1.0, 2.0, 9.0, 9.0, 3.0, 4.0, 9.0, 9.0, 5.0, 6.0];
    let b = [1.0, 0.0, 0.0, 1.0];
    let mut c = [1.0; 6];
    let t = |letter: &u8| std::ptr::from_ref(letter).cast::<c_char>();
    // SAFETY: sizes agree with the arrays above.
    unsafe {
        dgemm_(
            t(&b'T'),
            t(&b'n'),
            &3,
            &2,
            &2,
            &2.0,
            a.as_ptr(),
            &4,
            b.as_ptr(),
            &2,
            &1.0,
            c.as_mut_ptr(),
            &3,
        );
    }
    assert_eq!(c, [3.0, 7.0, 11.0, 5.0, 9.0, 13.0]);
}
