#!/bin/sh
# Builds the probe for a few processors, runs it, and fails when it contains panics, allocation or calls
# into a mathematical library, or when a controller asks the system for anything while it walks. Needs cargo and nm.
# $BIPEDC: the command that generates its robots, by default that of this repository.
set -eu
cd "$(dirname "$0")"

robot() { # NAME ARGUMENTS
    name="$1"
    shift
    ${BIPEDC:-cargo run --quiet --manifest-path ../../Cargo.toml --} generate "$@" --out "generated/$name" >/dev/null
    # Crates of one robot need names of their own.
    sed "s/^name = .*/name = \"$name\"/" "generated/$name/Cargo.toml" >generated/manifest
    mv generated/manifest "generated/$name/Cargo.toml"
}

robot floating ../../robots/three_link --base floating
robot effects ../data/effects/five_link
robot walker ../../robots/three_link --gait thesis
robot bent ../../robots/three_link --gait ../data/gaits/bent.toml
robot phases ../../robots/five_link --gait grounded

target="${CARGO_TARGET_DIR:-$PWD/target}/no_std"

# The linker drops the probe's own panic handler when nothing panics, so its name is forbidden too.
forbidden='panicking|rust_begin_unwind|unwrap_failed|slice_.*fail|__rust_(re)?alloc|__rdl_|malloc|calloc|(^|[^a-z0-9_])(fma|fmaf|sin|cos|sincos|sqrt|exp|expm1|tanh|expf|expm1f|tanhf|sinf|cosf|sqrtf)(@|$)|4libm'

check() { # CPU FEATURES
    flags="${1:+-C target-cpu=$1}"
    name="${1:-default}${2:+ with $2}"
    RUSTFLAGS="$flags" CARGO_TARGET_DIR="$target/${1:-default}" cargo build --quiet --locked --release --features "$2"
    program="$target/${1:-default}/release/no-std-probe"
    "$program" || { echo "$name: wrong numbers" >&2; exit 1; }
    # Asking the system for anything ends it (on Linux on x86-64), so that to have ended well says that nobody did.
    if [ "$(uname -sm)" = 'Linux x86_64' ] && "$program" asks 2>/dev/null; then
        echo "$name: the filter of system calls lets one through" >&2
        exit 1
    fi
    # Defined and undefined symbols alike.
    if nm "$program" | awk '{print $NF}' | grep -E "$forbidden" >&2; then
        echo "$name: the symbols above must not be in the no_std probe" >&2
        exit 1
    fi
    echo "$name: no panic, no allocation, no library function, no system call in 100 000 calls of a controller"
}

for cpu in "${@:-}"; do
    check "$cpu" ''
done
# All levels of x86-64 in one program, and how they are found without the standard library.
check '' dispatch
