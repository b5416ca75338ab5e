#!/usr/bin/env bash
# Whether two builds of the command say the same to the last byte: for changes that are meant to move walls and nothing else.
#
#   tests/same_results.sh OLD NEW [FOLDER]
#
# OLD and NEW are `bipedc` programs built with the same profile; results stay in FOLDER (a temporary one by default). Compared are, for
# every robot of the repository, all functions with their operation counts and the generated sources; every scenario's log; for every
# example log comparison, diagnosis and identification as JSON. What one of the two refuses, both must refuse in the same words. How long
# something took does not count.
set -euo pipefail
if [ $# -lt 2 ]; then
    sed -n '2,9s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
programs=("$(realpath "$1")" "$(realpath "$2")")
cd "$(dirname "$0")/.."
results=${3:-$(mktemp -d)}

# What one program says about everything, into a folder of its own.
all_of() {
    local program=$1 out=$2
    mkdir -p "$out"
    say() {
        local name=$1
        shift
        # Refusals are results too; paths into the folder of results are the only difference there may be.
        "$program" "$@" >"$out/$name" 2>"$out/$name.err" || echo "exit code $?" >>"$out/$name"
        sed -i -E -e "s#$out#OUT#g" -e 's/[0-9]+ times as fast as real time/as fast as it is/; s/, [0-9.]+ s$/, some time/' \
            "$out/$name" "$out/$name.err"
    }
    for folder in robots/*/; do
        local robot
        robot=$(basename "$folder")
        say "$robot.inspect.json" inspect "robots/$robot" --json
        say "$robot.parameters" base-parameters "robots/$robot"
        say "$robot.generate" generate "robots/$robot" --out "$out/$robot" --runtime 0.1.0
        for scenario in robots/"$robot"/scenarios/*.toml; do
            [ -e "$scenario" ] || continue
            local name
            name=$robot.$(basename "$scenario" .toml)
            say "$name.simulate" simulate "robots/$robot" --scenario "$scenario" --out "$out/$name.csv"
        done
    done
    for folder in tests/data/examples/*/; do
        local example log
        example=$(basename "$folder")
        log=tests/data/examples/$example/train.csv.gz
        say "$example.compare.json" compare robots/tulip "$log" --base fixed --root torso --json
        say "$example.diagnose.json" diagnose robots/tulip "$log" --validate "tests/data/examples/$example/validation.csv.gz" \
            --base fixed --root torso --json
        say "$example.identify.json" identify robots/tulip "$log" --base fixed --root torso --json
    done
}

all_of "${programs[0]}" "$results/old" &
all_of "${programs[1]}" "$results/new" &
wait
diff -rq "$results/old" "$results/new"
echo "the same: $(find "$results/new" -type f | wc -l) files in $results"
