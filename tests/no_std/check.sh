#!/bin/sh
# Builds the probe for a few processors, runs it, and fails when it contains panics, allocation or calls
# into a mathematical library. Needs cargo and nm.
set -eu
cd "$(dirname "$0")"
target="${CARGO_TARGET_DIR:-$PWD/target}/no_std"

# The linker drops the probe's own panic handler when nothing panics, so its name is forbidden too.
forbidden='panicking|rust_begin_unwind|unwrap_failed|slice_.*fail|__rust_(re)?alloc|__rdl_|malloc|calloc|(^|[^a-z0-9_])(fma|fmaf|sin|cos|sincos|sqrt|exp|expm1|tanh|expf|expm1f|tanhf|sinf|cosf|sqrtf)(@|$)|4libm'

check() { # CPU FEATURES
    flags="${1:+-C target-cpu=$1}"
    name="${1:-default}${2:+ with $2}"
    RUSTFLAGS="$flags" CARGO_TARGET_DIR="$target/$name" cargo build --quiet --locked --release --features "$2"
    program="$target/$name/release/no-std-probe"
    "$program" || { echo "$name: wrong numbers" >&2; exit 1; }
    # Defined and undefined symbols alike.
    if nm "$program" | awk '{print $NF}' | grep -E "$forbidden" >&2; then
        echo "$name: the symbols above must not be in the no_std probe" >&2
        exit 1
    fi
    echo "$name: no panic, no allocation, no library function"
}

for cpu in "${@:-}"; do
    check "$cpu" ''
done
# All levels of x86-64 in one program, and how they are found without the standard library.
check '' dispatch
