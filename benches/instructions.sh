#!/usr/bin/env bash
# Instructions per call under callgrind, which repeat exactly: the difference of two runs with different numbers of
# calls. Needs valgrind; built for x86-64-v3, because valgrind knows no AVX-512.
#   benches/instructions.sh MODELS_FOLDER ROBOT [FUNCTION...]
set -euo pipefail
cd "$(dirname "$0")/.."
models=$1 robot=$2
shift 2
functions=("$@")
[ ${#functions[@]} -gt 0 ] || functions=(rnea crba nle gravity aba com_jac centroidal regressor d_rnea d_aba)
export RUSTFLAGS='-C target-cpu=x86-64-v3'
program=$(cargo bench --bench speed --no-run 2>&1 | sed -n 's/.*(\(.*\)).*/\1/p' | tail -1)
count() { # FUNCTION CALLS
  BENCH_ONLY=$1 BENCH_CALLS=$2 valgrind --tool=callgrind --callgrind-out-file=/dev/null "$program" "$models" "$robot" 2>&1 |
    sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}
for function in "${functions[@]}"; do
  printf '%-12s %8d instructions per call\n' "$function" $((($(count "$function" 1100) - $(count "$function" 100)) / 1000))
done
