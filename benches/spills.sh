#!/usr/bin/env bash
# Of every function that the bench's program calls: operations, and for each processor instructions and how many of them load from and
# store to the stack (what found no register, and arguments), all counted in the assembly. Functions are kept apart from where they are
# called (`--cfg apart`), with everything that is inlined in them and their parts if they have several; behind `in lanes` they are those of
# a register full of states. The last row is the sum. Needs objdump; compiles for each processor what runs on the robot and the bench alone.
#   benches/spills.sh ROBOT [CPU...]       CPU as in -C target-cpu, native by default
# BIPEDC names the command if it is built already.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD robot=$1
shift
cpus=("$@")
[ ${#cpus[@]} -gt 0 ] || cpus=(native)
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")/spills
command=${BIPEDC:-cargo run --quiet --}
# A crate of the bench alone: the derive macro is compiled once for all processors.
bench=$target/crate
mkdir -p "$bench"
ln -sfn "$root/benches" "$bench/benches"
cp Cargo.lock "$bench"
cat > "$bench/Cargo.toml" <<TOML
[package]
name = "spills"
version = "0.0.0"
edition = "2024"

[[bin]]
name = "spills"
path = "benches/speed.rs"

[dependencies]
bipedc-macros = { path = "$root/macros" }
bipedc-runtime = { path = "$root/runtime/core", features = ["std"] }

[profile.release.build-override]
opt-level = 1

[workspace]
resolver = "1"
TOML
# The same functions as the bench's, for their numbers of operations.
cp -r "benches/robots/$robot" "$folder/robot"
functions=$(sed -n "/robots\/$robot\"/,/^])\]/p" benches/speed.rs | grep '^ *"' | tr -d '\n ')
printf '\n[generate]\nfunctions = [%s]\n' "$functions" >> "$folder/robot/biped.toml"
$command generate "$folder/robot" --out "$folder/crate" --runtime "$root/runtime/core" --json |
  tr -d ' \n' | tr '{' '\n' | sed -n 's/.*"name":"\([^"]*\)".*"operations":\([0-9]*\).*/\1 \2/p' > "$folder/operations"
host=$(rustc -vV | sed -n 's/^host: //p')
for cpu in "${cpus[@]}"; do
  RUSTFLAGS="-C target-cpu=$cpu -C symbol-mangling-version=v0 --cfg apart --cap-lints allow" \
    cargo build --quiet --release --manifest-path "$bench/Cargo.toml" --target-dir "$target" --target "$host"
  objdump -d -C --no-show-raw-insn "$target/$host/release/spills" | awk -v robot="$robot" -v cpu="$cpu" '
    /^[0-9a-f]+ </ {
      name = ""
      # `apart::<spills::lower12_functions::bias_into, false, …>` and `spills::lower12::bias::bias_part_0::<f64>`.
      if (match($0, "apart::<[a-z0-9_]+::" robot "_functions::[a-z0-9_]+(::[a-z0-9_]+)?, [01truefals]+")) {
        split(substr($0, RSTART, RLENGTH), part, ", ")
        name = part[1]
        lanes = part[2] == "true"
        sub(/.*::/, "", name)
        sub(/_into$/, "", name)
      } else if (match($0, "::" robot "::[a-z0-9_:]*::[a-z0-9_]+_(program|part_[0-9]+)::<.*")) {
        name = substr($0, RSTART, RLENGTH)
        lanes = name !~ /::<f64/
        # What stores entries in the dense matrix is another function than what stores them alone.
        dense = name ~ /_program<[A-Za-z0-9_:]*>::\{closure/
        sub(/_(program|part_[0-9]+)::<.*/, "", name)
        sub(/.*::/, "", name)
        if (dense) sub(/_nonzeros$/, "", name)
      }
      if (name != "" && lanes) name = name ",in_lanes"
      next
    }
    name != "" && /^ / {
      split($0, part, "\t")
      if (part[2] ~ /^(int3|.*nop|data16|xchg +%ax,%ax)/) next
      n[name]++
      if (part[2] !~ /\(%rsp|\(%rbp/) next
      if (part[2] ~ /^v?mov/ && part[2] ~ /\(%r[sb]p[^)]*\) *$/) stores[name]++; else loads[name]++
    }
    END { for (name in n) print cpu, n[name], loads[name] + 0, stores[name] + 0, name }' >> "$folder/counts"
done
awk -v robot="$robot" -v list="$folder/operations" '
  BEGIN { while ((getline line < list) > 0) { split(line, part, " "); count[part[1]] = part[2] } }
  {
    name = $5
    if (!($1 in order)) { order[$1] = ++cpus; cpu[cpus] = $1 }
    if (!(name in seen)) { seen[name] = 1; names[++functions] = name }
    for (k = 2; k <= 4; k++) { of[name, order[$1], k] = $k; sum[order[$1], k] += $k }
  }
  function row(name, operations,    c, label) {
    label = name
    sub(/,in_lanes/, ", in lanes", label)
    printf "%-58s %10s", label, operations
    for (c = 1; c <= cpus; c++) printf "  %8d %7d %7d", of[name, c, 2], of[name, c, 3], of[name, c, 4]
    print ""
  }
  END {
    printf "%-58s %10s", "", ""
    for (c = 1; c <= cpus; c++) printf "  %-24s", cpu[c]
    printf "\n%-58s %10s", robot, "operations"
    for (c = 1; c <= cpus; c++) printf "  %8s %7s %7s", "instr.", "loads", "stores"
    print ""
    for (k = 1; k <= functions; k++) {
      # Entries that are not always zero belong to the function whose matrix they are of.
      whole = names[k]
      sub(/,.*/, "", whole)
      sub(/_nonzeros$/, "", whole)
      row(names[k], count[whole])
    }
    for (c = 1; c <= cpus; c++) for (k = 2; k <= 4; k++) of["all of these", c, k] = sum[c, k]
    row("all of these", "")
  }' <(LC_ALL=C sort -s -k5,5 "$folder/counts")
