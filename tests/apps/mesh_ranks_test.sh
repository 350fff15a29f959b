#!/bin/sh
# usage: mesh_ranks_test.sh TETLOOM DEMO_MODEL MPIEXEC NUMPROC_FLAG
# A model is meshed into the same files on any number of ranks, with one report, and fails on all ranks together.
set -eu
tetloom=$1 demo_model=$2 mpiexec=$3 numproc=$4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

fail() {
    echo "mesh_ranks_test: $1" >&2
    exit 1
}
on_ranks() {
    ranks=$1
    shift
    "$mpiexec" --oversubscribe --allow-run-as-root --mca btl_vader_single_copy_mechanism none "$numproc" "$ranks" \
        "$tetloom" "$@"
}

"$demo_model" assembly model.step
for way in "--tets-per-part 4000" "--tets-per-part 4000 --parts 5" "--tets-per-part inf"; do
    options="--imprint --relative-size 0.03 --quiet --report report.json $way"
    # shellcheck disable=SC2086
    "$tetloom" mesh model.step -o parts.pvtu $options
    rm -rf expected
    mkdir expected
    mv parts parts.pvtu expected/
    digest=$(grep '"digest"' report.json)
    for ranks in 1 2 3; do
        # shellcheck disable=SC2086
        on_ranks "$ranks" mesh model.step -o parts.pvtu --threads 1 $options
        diff -r parts expected/parts || fail "other pieces on $ranks ranks with $way"
        cmp parts.pvtu expected/parts.pvtu || fail "another list on $ranks ranks with $way"
        [ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest on $ranks ranks with $way"
    done
done
on_ranks 2 mesh model.step -o whole.vtu --imprint --relative-size 0.03 --report report.json > text
[ "$(grep -c 'tets in 2 regions' text)" = 1 ] || fail "the ranks do not speak with one voice"
"$tetloom" check whole.vtu --quiet --report check.json
[ "$(grep '"digest"' report.json)" = "$(grep '"digest"' check.json)" ] || fail "another digest in one piece"
on_ranks 2 mesh model.step -o surface.stl --imprint --quiet
"$tetloom" check surface.stl --quiet

rm -rf parts parts.pvtu
for output in parts.pvtu whole2.vtu; do
    status=0
    on_ranks 2 mesh missing.step -o "$output" 2> errors || status=$?
    [ "$status" = 3 ] || fail "status $status where the model is missing"
    status=0
    on_ranks 2 mesh model.step -o "nowhere/$output" 2> errors || status=$?
    [ "$status" = 6 ] || fail "status $status where nothing can be written"
done
[ ! -e parts ] && [ ! -e parts.pvtu ] && [ ! -e whole2.vtu ] || fail "a run that failed left something behind"

# Begins a long run and sends a signal to one of its two ranks. Sets status and left, the files that are left behind.
signal_one_rank() {
    signal=$1 rank=$2
    rm -f pid.* errors
    touch errors
    # shellcheck disable=SC2016
    timeout 100 "$mpiexec" --oversubscribe --allow-run-as-root --mca btl_vader_single_copy_mechanism none "$numproc" 2 \
        sh -c 'echo $$ > "pid.${OMPI_COMM_WORLD_RANK:-$PMI_RANK}"; exec "$@"' sh \
        "$tetloom" mesh model.step -o signal.pvtu --curvature 300 --proximity 9 --relative-size 0.01 --threads 1 \
        2> errors &
    launcher=$!
    tries=0
    until grep -q '^read' errors; do  # said when both ranks listen to signals
        tries=$((tries + 1))
        [ "$tries" -lt 600 ] || fail "the ranks do not start"
        sleep 0.1
    done
    sleep 1
    kill "-$signal" "$(cat "pid.$rank")" || fail "the run was over before signal $signal"
    status=0
    wait "$launcher" || status=$?
    left=$(find . -name '*signal*')
}

# A rank that is killed or stopped ends the run on all of them, soon, with an error and with nothing left behind.
for rank in 0 1; do
    signal_one_rank KILL "$rank"
    [ "$status" != 0 ] && [ "$status" != 124 ] || fail "status $status after rank $rank was killed"
    [ -z "$left" ] || fail "a run of which rank $rank was killed left $left"
    signal_one_rank TERM "$rank"
    [ "$status" = 5 ] || fail "status $status after rank $rank was asked to stop"
    [ -z "$left" ] || fail "a run of which rank $rank was asked to stop left $left"
    grep -q '^tetloom: cancelled' errors || fail "nobody says that the run was cancelled"
done
