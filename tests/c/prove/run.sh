#!/bin/sh
# Proves with Frama-C's value analysis, for int of 32 and of 16 bits, that the runtime and two
# exported joints meet any input without undefined behaviour; so do the estimators, fallbacks,
# checks and zeros of two joints whose sensors contradict each other, and their nodes, which obey
# commands, with their captures. Logs go beside the exported folders.
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
        if ! frama-c -machdep "$machine" -cpp-extra-args="-I$folder/src -I$folder/ports -I$drivers $names" \
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

# pose_names JOINT: what pose_any.c is told of a joint.
pose_names() {
    printf '%s' "-DPOSE_HEADER='\"$1_pose.h\"' -DPOSE_TIP=$1_integer_tip_pose"
    printf '%s' " -DPOSE_ANGLES=$1_angles_t -DPOSE_TYPE=$1_integer_pose_t"
}

# prove_capture JOINT FOLDER: the capture of a joint that obeys commands.
prove_capture() {
    names="-DCAN_SOURCE='\"$1_can.c\"' -DLAYOUT=$1_layout"
    # Loops over sensors and what becomes of each are followed apart; relations are not needed.
    prove "$1-capture" "$2" -eva-precision 0 -eva-slevel 100 -eva-min-loop-unroll 17 \
        -eva-split-return full "$drivers/capture.c" "$2/src/ccgen/capture.c"
}

# prove_node JOINT FOLDER NAMES: its node, which rests on estimator, capture and pose.
prove_node() {
    names="$(pose_names "$1") -DJOINT=$1 -DLAYOUT=$1_layout $3"
    # What a command asks for and what became of a capture are followed apart, to each step's end.
    prove "$1-node" "$2" -eva-interprocedural-splits -eva-min-loop-unroll 17 \
        -eva-split-return-function "ccgen_command_receive:0:1:2:3,ccgen_capture_take:1:2:4" \
        "$drivers/node.c" "$drivers/capture_any.c" "$drivers/joint_any.c" "$drivers/pose_any.c" \
        "$2/src/$1_can.c" "$2/src/ccgen/crc.c"
}

mkdir -p "$out"
names=
for pair in shoulder:ccgen_segments16 spine:ccgen_axis32_segments; do
    joint=${pair%:*}
    loop=${pair#*:}
    folder=$out/$joint
    "$ccgen" export "$examples/$joint.toml" -o "$folder" >/dev/null
    upper=$(printf '%s' "$joint" | tr a-z A-Z)
    one=$(sed -n 's/.*rotation\[k\] = .*INT32_C(\([0-9]*\)).*/\1/p' "$folder/src/${joint}_pose.c")
    : "${one:?${joint}_pose.c does not say what 1 is in a rotation}"
    names="$(pose_names "$joint") -DPOSE_SOURCE='\"${joint}_pose.c\"' -DPOSE_ANGLE=${joint}_angle_t"
    names="$names -DSEGMENTS=${upper}_POSE_SEGMENTS -DONE=$one"
    prove "$joint-pose" "$folder" "$drivers/pose.c"
    # The loop over segments is followed turn by turn, up to the most segments.
    sources=$(find "$folder/src" -maxdepth 1 -name '*.c' ! -name '*_pose.c')
    prove "$joint" "$folder" \
        -eva-slevel-function "ccgen_layout_begin:80,$loop:100,ccgen_layout_clear_from:80" \
        "$drivers/joint.c" "$drivers/pose_any.c" $sources "$folder"/src/ccgen/*.c
done
prove slcan "$out/shoulder" "$drivers/slcan.c" "$out/shoulder/src/ccgen/slcan.c"
prove watch "$out/shoulder" -eva-slevel 1000 -eva-split-return full "$drivers/watch.c"

# check FIELD: what the only check of the joint says of a field.
check() {
    sed -n "/^static const ccgen_check_t/,/^};/s|^ *\([0-9]*\), /\* $1 \*/.*|\1|p" "$source"
}

for pair in trunk:16 pairs:32; do
    joint=${pair%:*}
    precision=${pair#*:}
    folder=$out/$joint
    source=$folder/src/$joint.c
    "$ccgen" export "$drivers/joints/$joint.toml" -o "$folder" >/dev/null
    shift_=$(check shift)
    # Bits that values of twice the precision may lose more, until they fit 16.
    most=$((2 * precision - 16 - shift_))
    names="-DCHECK_HEADER='\"ccgen/check$precision.h\"' -DSHORTENED=ccgen_shortened$precision"
    names="$names -DPARITY=int$((2 * precision))_t -DSHORTENED_MOST=$most"
    names="$names -DCHECK_SENSORS=$(check sensors) -DCHECK_KEPT=$(check kept) -DCHECK_SHIFT=$shift_"
    names="$names -DJOINT_SOURCE='\"$joint.c\"' -DRESTORE_LAST=${joint}_restore_last"
    prove "$joint-shortened" "$folder" -eva-min-loop-unroll 17 "$drivers/shortened.c"
    # Loops over sensors are followed turn by turn.
    prove "$joint-estimator" "$folder" -eva-min-loop-unroll 17 \
        -eva-use-spec "ccgen_shortened$precision" "$drivers/estimator.c" "$drivers/checked.c" \
        "$folder/src/${joint}_kinematics.c" "$folder/src/${joint}_jacobian.c"
    prove_capture "$joint" "$folder"
    prove_node "$joint" "$folder" "-DCHECK_HEADER='\"ccgen/check$precision.h\"'"
done
