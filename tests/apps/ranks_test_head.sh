# shellcheck shell=sh
# What the tests of commands on ranks begin with: to be sourced with their arguments TETLOOM DEMO_MODEL MPIEXEC
# NUMPROC_FLAG. They run in a folder of their own, which is removed in the end.
set -eu
tetloom=$1 demo_model=$2 mpiexec=$3 numproc=$4
test_name=$(basename "$0" .sh)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

fail() {
    echo "$test_name: $1" >&2
    exit 1
}

limit=  # of a run's time
# run_on_ranks RANKS PROGRAM ARGUMENTS...
run_on_ranks() {
    ranks=$1
    shift
    # shellcheck disable=SC2086
    $limit "$mpiexec" --oversubscribe --allow-run-as-root --mca btl_vader_single_copy_mechanism none \
        "$numproc" "$ranks" "$@"
}

# on_ranks RANKS ARGUMENTS...: of tetloom.
on_ranks() {
    count=$1
    shift
    run_on_ranks "$count" "$tetloom" "$@"
}

# signal_one_rank SIGNAL RANK STAGE ARGUMENTS...: begins a long run of tetloom on two ranks, waits until it says that it
# is at a stage, and sends a signal to one of them. Sets status and left, the files named after "signal" that are left
# behind; what was said is in the file errors. Ranks speak into files of their own: on a busy machine mpiexec hands on
# what they say long after.
signal_one_rank() {
    signal=$1 rank=$2 stage=$3
    shift 3
    rm -f pid.* said.* errors
    touch said.0
    limit="timeout 100"
    # shellcheck disable=SC2016
    run_on_ranks 2 sh -c 'rank=${OMPI_COMM_WORLD_RANK:-$PMI_RANK}; echo $$ > "pid.$rank"; exec "$@" 2> "said.$rank"' \
        sh "$tetloom" "$@" 2> said.mpiexec &
    launcher=$! limit=
    tries=0
    until grep -q "^$stage" said.0; do
        tries=$((tries + 1))
        [ "$tries" -lt 600 ] || fail "the ranks do not start"
        sleep 0.1
    done
    sleep 1
    kill "-$signal" "$(cat "pid.$rank")" || fail "the run was over before signal $signal"
    status=0
    wait "$launcher" || status=$?
    cat said.* > errors
    left=$(find . -name '*signal*')
}

# check_signals STAGE ARGUMENTS...: a rank that is killed or asked to stop ends the run on both, soon, with an error
# and with nothing left behind.
check_signals() {
    for rank in 0 1; do
        signal_one_rank KILL "$rank" "$@"
        [ "$status" != 0 ] && [ "$status" != 124 ] || fail "status $status after rank $rank was killed"
        [ -z "$left" ] || fail "a run of which rank $rank was killed left $left"
        signal_one_rank TERM "$rank" "$@"
        [ "$status" = 5 ] || fail "status $status after rank $rank was asked to stop"
        [ -z "$left" ] || fail "a run of which rank $rank was asked to stop left $left"
        grep -q '^tetloom: cancelled' errors || fail "nobody says that the run was cancelled"
    done
}
