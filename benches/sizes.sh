#!/usr/bin/env bash
# Of every function in a folder's robot: bytes of machine code and rustc's processor time, each function in a crate of its own that is
# generated as users do (default features, release profile, Rust's default target) and called once by `Model` on `f64`. Both levels of
# `dispatch` count, and what calls them; the time is what a crate with this function takes longer than one that calls nothing.
#   benches/sizes.sh ROBOT_FOLDER [FUNCTION...]        all functions that the robot has without a list; BIPEDC: the command, if built
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
robot=$(cd "$1" && pwd)
shift
bipedc=${BIPEDC:-cargo run --quiet --release --manifest-path $here/Cargo.toml --bin bipedc --}
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
export CARGO_TARGET_DIR=$work/target
unset RUSTFLAGS

generate() { # FUNCTIONS, as a list in TOML
  rm -rf "$work/robot" "$work/crate"
  cp -r "$robot" "$work/robot"
  printf '\n[generate]\nfunctions = [%s]\n' "$1" >> "$work/robot/biped.toml"
  $bipedc generate "$work/robot" --out "$work/crate" --runtime "$here/runtime/core" --json 2> "$work/warnings"
}

list() { tr -d ' \n' | tr '{' '\n' | sed -n 's/.*"name":"\([^"]*\)".*"operations":\([0-9]*\).*/\1 \2/p'; }

crate_of() { sed -n 's/^name = "\(.*\)"/\1/p' "$work/crate/Cargo.toml"; }

probe() { # BODY; prints processor time in seconds, leaves the archive
  printf '%s\n' "$1" > "$work/probe/src/lib.rs"
  { TIMEFORMAT='%U %S'; time cargo build --quiet --offline --release --manifest-path "$work/probe/Cargo.toml" 2> "$work/errors"; } 2>&1 |
    awk '{ print $1 + $2 }'
}

bytes() { size -A "$work"/target/release/libprobe.rlib | awk '$1 ~ /^\.text/ { sum += $2 } END { print sum + 0 }'; }

all=$(generate "$(printf '"%s",' "$@")" | list)
name=$(crate_of)
mkdir -p "$work/probe/src"
printf '[package]\nname = "probe"\nversion = "0.1.0"\nedition = "2024"\n\n[dependencies]\n%s = { path = "../crate" }\nbipedc-runtime = { path = "%s" }\n\n[workspace]\n' \
  "$name" "$here/runtime/core" > "$work/probe/Cargo.toml"
cp "$here/Cargo.lock" "$work/probe/Cargo.lock"
first=$(printf '%s\n' "$all" | head -1 | cut -d' ' -f1)
# Dependencies once, and the command itself: what stays is not the function's.
generate "\"$first\"" > /dev/null
probe '' > /dev/null
generate "\"$first\"" > /dev/null
touch "$work/crate/src/lib.rs"
empty=$(probe '// again')
printf '%-44s %10s %10s %8s\n' "$(basename "$robot")" operations bytes "rustc, s"
printf '%s\n' "$all" | while read -r function operations; do
  generate "\"$function\"" > /dev/null
  robot_type=$(sed -n 's/^pub struct \([A-Za-z0-9]*\);/\1/p' "$work/crate/src/lib.rs")
  time=$(probe "use bipedc_runtime::{CallError, Model, State};
pub fn call(state: &State<'_, f64>, out: &mut [f64]) -> Result<(), CallError> {
    Model::<f64>::evaluate(&${name//-/_}::$robot_type, 0, state, out)
}")
  printf '%-44s %10d %10d %8.2f\n' "$function" "$operations" "$(bytes)" \
    "$(awk -v a="$time" -v b="$empty" 'BEGIN { print a - b }')"
done
