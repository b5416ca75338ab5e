#!/usr/bin/env bash
# Of every emitted function in the bench's program: operations, instructions, bytes of code, and how many instructions load from and
# store to the stack (what found no register). Needs objdump. Functions are generic: only what the bench calls is there, those that are
# inlined where they are called not by themselves, and once for one state and once for a register full of states; the last column
# tells them apart by the registers that most instructions use.
#   benches/spills.sh ROBOT [CPU]        CPU as in -C target-cpu, native by default
set -euo pipefail
cd "$(dirname "$0")/.."
robot=$1 cpu=${2:-native}
operations=$(mktemp -d)
trap 'rm -r "$operations"' EXIT
cargo run --quiet -- generate "benches/robots/$robot" --out "$operations/crate" --runtime "$PWD/runtime/core" --json > "$operations/json"
export RUSTFLAGS="-C target-cpu=$cpu"
program=$(cargo bench --bench speed --no-run 2>&1 | sed -n 's/.*(\(.*\)).*/\1/p' | tail -1)
tr -d ' \n' < "$operations/json" | tr '{' '\n' |
  sed -n 's/.*"name":"\([^"]*\)".*"operations":\([0-9]*\).*/\1 \2/p' > "$operations/list"
printf '%-52s %10s %12s %8s %8s %8s  %s\n' "$robot, $cpu" operations instructions bytes loads stores registers
objdump -d -C --no-show-raw-insn "$program" | awk -v robot="$robot" -v list="$operations/list" '
  function flush(    wide) {
    if (name == "") return
    wide = z > y && z > x ? "zmm" : y > x ? "ymm" : "xmm"
    printf "%-52s %10s %12d %8d %8d %8d  %s\n", name, count[name], n, last - first, loads, stores, wide
  }
  function hex(digits,    i, value) {
    for (i = 1; i <= length(digits); i++) value = 16 * value + index("0123456789abcdef", substr(digits, i, 1)) - 1
    return value
  }
  BEGIN { while ((getline line < list) > 0) { split(line, part, " "); count[part[1]] = part[2] } }
  /^[0-9a-f]+ </ {
    flush()
    name = ""
    if (match($0, "::" robot "::") && match($0, /[a-z_0-9]+_(program|part_[0-9]+)>/)) {
      name = substr($0, RSTART, RLENGTH - 1)
      sub(/_program$/, "", name)
      # The entries that are not always zero belong to the function whose matrix they are of.
      if (!(name in count)) { whole = name; sub(/_nonzeros$/, "", whole); count[name] = count[whole] }
      first = hex($1)
      n = loads = stores = x = y = z = 0
    }
    next
  }
  name != "" && /^ / {
    split($0, part, "\t")
    if (part[2] ~ /^(int3|nop)/) next
    sub(/^ +/, "", part[1])
    last = hex(substr(part[1], 1, index(part[1], ":") - 1))
    n++
    if (part[2] ~ /\(%rsp|\(%rbp/) { if (part[2] ~ /\(%r[sb]p[^)]*\)$/ && part[2] ~ /^v?mov/) stores++; else loads++ }
    if (part[2] ~ /%zmm/) z++; else if (part[2] ~ /%ymm/) y++; else if (part[2] ~ /%xmm/) x++
  }
  END { flush() }' | sort
