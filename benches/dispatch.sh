#!/usr/bin/env bash
# What a native build takes as a part of what plain `cargo build --release` with run-time dispatch takes: the functions of `speed.rs`, in
# crates that are generated as users do, by both programs in turns; the least of the runs of each counts.
#   benches/dispatch.sh [RUNS]        3 runs without; BIPEDC: the command, if built; WORK: where to build, a temporary folder without
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
bipedc=${BIPEDC:-cargo run --quiet --release --manifest-path $here/Cargo.toml --bin bipedc --}
work=${WORK:-$(mktemp -d)}
[ -n "${WORK:-}" ] || trap 'rm -r "$work"' EXIT
unset RUSTFLAGS

mkdir -p "$work/program/src"
cp -r "$here/benches/harness" "$work/program/src/"
cp "$here/Cargo.lock" "$work/program/"
printf '[package]\nname = "program"\nversion = "0.1.0"\nedition = "2024"\n\n[workspace]\n\n[lints.rust]\nunexpected_cfgs = "allow"\n\n[dependencies]\nbipedc-runtime = { path = "%s", features = ["std"] }\n' \
  "$here/runtime/core" > "$work/program/Cargo.toml"
for robot in lower12 rabbit5 biped7; do
  # The functions that `speed.rs` asks the derive macro for.
  functions=$(awk -v robot="benches/robots/$robot\"" 'index($0, robot) { on = 1; next } on && /\]\)\]/ { exit } on' "$here/benches/speed.rs")
  rm -rf "${work:?}/$robot" "$work/robot"
  mkdir -p "$work/robot"
  cp -r "$here/benches/robots/$robot" "$work/robot/"
  printf '\n[generate]\nfunctions = [%s]\n' "$functions" >> "$work/robot/$robot/biped.toml"
  $bipedc generate "$work/robot/$robot" --out "$work/$robot" --runtime "$here/runtime/core" > "$work/said" 2>&1 || { cat "$work/said" >&2; exit 1; }
  printf '%s = { path = "../%s" }\n' "$robot" "$robot" >> "$work/program/Cargo.toml"
done
# The same program on crates instead of what the derive macro expands to.
awk '/^#\[derive\(Biped\)\]/ { skip = 1 }
     !skip && !/^use bipedc_macros|#\[cfg\(talos_reduced\)\]/
     skip && /^pub struct/ { sub("pub struct ", ""); sub(";", ""); if ($0 != "TalosReduced") print "use " tolower($0) "::" $0 ";"; skip = 0 }' \
  "$here/benches/speed.rs" | awk '/^fn talos_reduced_functions/ { skip = 1 } !skip && !/talos_reduced_functions/ { print } skip && /^}/ { skip = 0 }' \
  > "$work/program/src/main.rs"
build() { # NAME
  CARGO_TARGET_DIR=$work/target_$1 cargo build --quiet --release --manifest-path "$work/program/Cargo.toml"
}
build plain
RUSTFLAGS='-C target-cpu=native' build native
for _ in $(seq "${1:-3}"); do
  for kind in plain native; do
    BENCH_SINGLE=1 "$work/target_$kind/release/program" | sed "s/^/$kind /"
  done
done | awk '
  $3 == "ns" { robot = $2; next }
  $2 ~ /^AMD|^Intel/ || NF < 4 { if (!said && NF > 1) { $1 = ""; print; said = 1 } next }
  { key = robot " " $2; if (!(key in seen)) { seen[key] = ++n; name[n] = key }
    if (!(($1, key) in least) || $3 < least[$1, key]) least[$1, key] = $3 }
  END {
    printf "%-42s %10s %10s %8s\n", "least of all runs", "plain, ns", "native, ns", "ratio"
    for (k = 1; k <= n; k++) {
      ratio = least["native", name[k]] / least["plain", name[k]]
      missed += ratio < 0.8
      printf "%-42s %10.1f %10.1f %8.2f%s\n", name[k], least["plain", name[k]], least["native", name[k]], ratio, ratio < 0.8 ? " *" : ""
    }
    printf "%d of %d below 0.80\n", missed, n
  }'
