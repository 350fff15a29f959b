#!/bin/sh
# usage: partition_ranks_test.sh TETLOOM DEMO_MODEL MPIEXEC NUMPROC_FLAG
# The command makes the same files on any number of ranks, also with more ranks than parts, and fails on all of them
# together.
# shellcheck source=tests/apps/ranks_test_head.sh
. "$(dirname "$0")/ranks_test_head.sh"

"$demo_model" assembly model.step
"$tetloom" mesh model.step -o mesh.vtu --imprint --relative-size 0.05 --quiet
"$tetloom" partition mesh.vtu --parts 5 -o parts.pvtu --quiet
mkdir expected
mv parts parts.pvtu expected/
for ranks in 1 2 3 7; do
    on_ranks "$ranks" partition mesh.vtu --parts 5 -o parts.pvtu --quiet --report report.json
    diff -r parts expected/parts || fail "other pieces on $ranks ranks"
    cmp parts.pvtu expected/parts.pvtu || fail "another list on $ranks ranks"
    on_ranks "$ranks" check parts.pvtu --report check.json > text
    [ "$(grep -c 'The mesh is valid' text)" = 1 ] || fail "$ranks ranks do not speak with one voice"
    [ "$(grep '"digest"' report.json)" = "$(grep '"digest"' check.json)" ] || fail "another digest on $ranks ranks"
    on_ranks "$ranks" partition parts.pvtu --parts 3 -o again.msh --quiet --report again.json
    [ "$(grep '"digest"' report.json)" = "$(grep '"digest"' again.json)" ] || fail "another digest in the MSH file"
done

sed 's/CutFaces="/CutFaces="9/' parts.pvtu > wrong.pvtu
for ranks in 1 2 3; do
    status=0
    on_ranks "$ranks" check wrong.pvtu --report check.json > text 2> errors || status=$?
    [ "$status" = 4 ] || fail "status $status on $ranks ranks where the pieces do not belong together"
    [ "$(grep -c 'NOT valid' text)" = 1 ] || fail "$ranks ranks do not speak with one voice of what does not fit"
done

rm parts/parts_3.vtu
for ranks in 2 3; do
    status=0
    on_ranks "$ranks" check parts.pvtu > text 2> errors || status=$?
    [ "$status" = 3 ] || fail "status $status where a piece is missing"
    grep -q 'parts_3.vtu' errors || fail "the missing piece is not named"
    status=0
    on_ranks "$ranks" partition mesh.vtu --parts 2 -o nowhere/a.pvtu 2> errors || status=$?
    [ "$status" = 6 ] || fail "status $status where nothing can be written"
done
