#!/bin/sh
# usage: mesh_ranks_test.sh TETLOOM DEMO_MODEL MPIEXEC NUMPROC_FLAG
# A model is meshed into the same files on any number of ranks, with one report, and fails on all ranks together.
# shellcheck source=tests/apps/ranks_test_head.sh
. "$(dirname "$0")/ranks_test_head.sh"

"$demo_model" assembly model.step
echo '{"walls": [{"faces": ["*"], "first_height": 0.2, "count": 5}]}' > walls.json
for way in "--tets-per-part 4000" "--tets-per-part 4000 --parts 5" "--tets-per-part inf" \
           "--tets-per-part 4000 --parts 5 --layers walls.json"; do
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
for way in "--tets-per-part 4000" "--tets-per-part inf" "--layers walls.json"; do
    for output in whole.vtu whole.msh; do
        # shellcheck disable=SC2086
        "$tetloom" mesh model.step -o "$output" --imprint --relative-size 0.03 --quiet $way
        mv "$output" "expected/$output"
        for ranks in 2 3; do
            # shellcheck disable=SC2086
            on_ranks "$ranks" mesh model.step -o "$output" --imprint --relative-size 0.03 --threads 1 --quiet $way
            cmp "$output" "expected/$output" || fail "another $output on $ranks ranks with $way"
        done
    done
done
# Nothing is put together for figures: what the first rank has more than another is less than a piece of the mesh, which
# is large beside what reading the model takes.
"$demo_model" spline-block block.step
on_ranks 3 mesh block.step -o parts.pvtu --relative-size 0.009 --parts 3 --threads 1 --quiet --report report.json
bytes_of_ranks() {
    tr -d ' \n' < report.json | grep -o '"ranks":[^]]*' | grep -o "\"$1\":[0-9]*" | cut -d: -f2
}
first=$(bytes_of_ranks peak_bytes | head -n 1) least=$(bytes_of_ranks peak_bytes | sort -n | head -n 1)
tets=$(bytes_of_ranks tets | head -n 1)
[ $((first - least)) -lt $((50 * tets)) ] || fail "the first rank has $((first - least)) bytes more than another"
for sent in $(bytes_of_ranks sent_bytes); do
    [ "$sent" -gt 1000 ] || fail "a rank has sent $sent bytes"
done
[ "$(bytes_of_ranks sent_bytes | grep -c .)" = 3 ] || fail "not all ranks tell what they have sent"
# Each rank holds shapes of the model, and the file that they come from is gone.
[ "$(bytes_of_ranks model_bytes | grep -c .)" = 3 ] || fail "not all ranks tell what they hold of the model"
mkdir temporary
coarse="mesh block.step -o parts.pvtu --relative-size 0.05 --parts 3 --quiet --report report.json"
# shellcheck disable=SC2086
TMPDIR=$PWD/temporary on_ranks 2 $coarse
digest=$(grep '"digest"' report.json)
# What a part needs of the model is told; parts inside of the solid need nothing.
on_ranks 2 mesh block.step -o inside.pvtu --relative-size 0.05 --parts 125 --quiet --report inside.json
bytes_of_parts() {
    tr -d ' \n' < inside.json | grep -o '"table":[^]]*' | grep -o '"model_bytes":[0-9]*' | cut -d: -f2
}
[ "$(bytes_of_parts | grep -c .)" = 125 ] || fail "not all parts tell what they need of the model"
bytes_of_parts | grep -q '^0$' || fail "parts inside of the solid need its shapes"
bytes_of_parts | grep -q '^[1-9]' || fail "no part needs a shape"
rm -rf inside*
[ -z "$(find temporary -name 'tetloom*')" ] || fail "the file of shapes is left behind"
# Without a folder for it each rank reads the model for itself.
# shellcheck disable=SC2086
run_on_ranks 2 env TMPDIR=/nowhere "$tetloom" $coarse
[ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest where no shapes are stored"
[ -z "$(bytes_of_ranks model_bytes)" ] || fail "shapes are held that were not stored"
on_ranks 2 mesh model.step -o surface.stl --imprint --quiet
"$tetloom" check surface.stl --quiet
# Models of facets: the first rank reads them, and each holds those of the faces that it needs.
"$demo_model" filleted-plate plate.step 4
"$tetloom" mesh plate.step -o facets.stl --curvature 12 --surface-only --quiet
"$tetloom" mesh facets.stl -o parts.pvtu --parts 5 --curvature 12 --quiet --report report.json
digest=$(grep '"digest"' report.json)
TMPDIR=$PWD/temporary on_ranks 3 mesh facets.stl -o parts.pvtu --parts 5 --curvature 12 --quiet --report report.json
[ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest of a model of facets on 3 ranks"
[ "$(bytes_of_ranks model_bytes | grep -c .)" = 3 ] || fail "not all ranks tell what they hold of the facets"
[ -z "$(find temporary -name 'tetloom*')" ] || fail "a file of facets or sizes is left behind"
run_on_ranks 3 env TMPDIR=/nowhere "$tetloom" mesh facets.stl -o parts.pvtu --parts 5 --curvature 12 --quiet \
    --report report.json
[ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest where no facets and sizes are stored"

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

# Said when both ranks listen to signals: "read".
check_signals read mesh model.step -o signal.pvtu --curvature 300 --proximity 9 --relative-size 0.01 --threads 1
