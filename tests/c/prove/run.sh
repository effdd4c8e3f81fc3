#!/bin/sh
# Proves with Frama-C's value analysis, for int of 32 and of 16 bits, that the runtime and two
# exported joints meet any input without undefined behaviour. Logs go beside the exported folders.
#
#     tests/c/prove/run.sh CCGEN OUT
set -eu
ccgen=$1
out=$2
drivers=$(dirname "$0")
examples=$drivers/../../../examples

# prove NAME FOLDER FILES...: no alarm, with negative values, casts and overflow looked at.
prove() {
    name=$1
    folder=$2
    shift 2
    for machine in x86_32 x86_16; do
        log=$out/$name-$machine.log
        printf '%s, %s: ' "$name" "$machine"
        if ! frama-c -machdep "$machine" -cpp-extra-args="-I$folder/src -I$folder/ports" \
            -eva -eva-precision 3 -eva-msg-key=-initial-state,-final-states \
            -eva-warn-key alarm=error -warn-signed-overflow -warn-signed-downcast \
            "$@" >"$log" 2>&1; then
            printf 'not proven; see %s\n' "$log"
            grep -A1 'eva:alarm\|Error' "$log"
            exit 1
        fi
        grep 'alarms generated' "$log"
    done
}

mkdir -p "$out"
for pair in shoulder:ccgen_segments16 spine:ccgen_axis32_segments; do
    joint=${pair%:*}
    loop=${pair#*:}
    folder=$out/$joint
    "$ccgen" export "$examples/$joint.toml" -o "$folder" >/dev/null
    # The loop over segments is followed turn by turn, up to the most segments.
    prove "$joint" "$folder" \
        -eva-slevel-function "ccgen_layout_begin:80,$loop:100" \
        "$drivers/joint.c" "$folder"/src/*.c "$folder"/src/ccgen/*.c
done
prove slcan "$out/shoulder" "$drivers/slcan.c" "$out/shoulder/src/ccgen/slcan.c"
