#!/bin/sh
# usage: adapt_ranks_test.sh TETLOOM DEMO_MODEL MPIEXEC NUMPROC_FLAG
# A mesh is adapted into the same files on any number of ranks, with one report, and fails on all ranks together.
# shellcheck source=tests/apps/ranks_test_head.sh
. "$(dirname "$0")/ranks_test_head.sh"
# A size for each point of a .mesh file: small near one corner.
write_sizes() {
    awk -v small="$2" '
        /^ *Vertices/ { getline count; printf "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n%d\n1 1\n", count
            for (i = 0; i < count; ++i) { getline; d = sqrt($1 * $1 + $2 * $2 + $3 * $3); print small * (1 + d / 20) }
            print "End"; exit }' "$1"
}

# One process and 2 or 3 ranks make the same pieces of those of $1, with the options $2.
same_on_ranks() {
    rm -rf expected next*
    mkdir expected
    # shellcheck disable=SC2086
    "$tetloom" adapt "$1" -o next.pvtu $2
    mv next* expected/
    digest=$(grep '"digest"' report.json)
    for ranks in 2 3; do
        # shellcheck disable=SC2086
        on_ranks "$ranks" adapt "$1" -o next.pvtu --threads 1 $2
        diff -r next expected/next || fail "other pieces on $ranks ranks with $2"
        [ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest on $ranks ranks with $2"
        rm -rf next*
    done
}

"$demo_model" assembly model.step
"$tetloom" mesh model.step -o mesh.mesh --imprint --relative-size 0.06 --quiet
write_sizes mesh.mesh 2.5 > sizes.sol
for way in "-o out.mesh" "-o out.pvtu" "-o out.pvtu --parts 5" "-o out.msh --parts 3" \
    "-o out.meshb --model model.step --imprint"; do
    options="--metric sizes.sol --tets-per-part 1500 --quiet --report report.json $way"
    # shellcheck disable=SC2086
    "$tetloom" adapt mesh.mesh --threads 2 $options
    rm -rf expected
    mkdir expected
    mv out* expected/
    digest=$(grep '"digest"' report.json)
    [ "$(sed -n 's/.*"most_parts": \([0-9]*\).*/\1/p' report.json)" -gt 4 ] || fail "too few parts to say anything"
    for ranks in 1 2 3; do
        # shellcheck disable=SC2086
        on_ranks "$ranks" adapt mesh.mesh --threads 1 $options
        for file in out*; do
            diff -r "$file" "expected/$file" || fail "another $file on $ranks ranks with $way"
        done
        rm -rf out*
        [ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest on $ranks ranks with $way"
    done
done

on_ranks 2 adapt mesh.mesh -o parts.pvtu --parts 4 --metric sizes.sol --report report.json > text
[ "$(grep -c 'in the metric' text)" = 2 ] || fail "the ranks do not speak with one voice"
"$tetloom" check parts.pvtu --quiet --report check.json
[ "$(grep '"digest"' report.json)" = "$(grep '"digest"' check.json)" ] || fail "another digest of the parts"

# From pieces to pieces, also on more ranks than pieces; a field on points, and one on tets, are carried over.
sed '$d' sizes.sol > mesh.sol
awk '/^ *Tetrahedra/ { getline count; printf "SolAtTetrahedra\n%d\n1 1\n", count
    for (i = 0; i < count; ++i) print i % 7
    print "End"; exit }' mesh.mesh >> mesh.sol
field="--metric-field solution_1 --transfer solution_1 --quiet --report report.json"
# shellcheck disable=SC2086
"$tetloom" adapt mesh.mesh -o pieces.pvtu --parts 5 $field
# shellcheck disable=SC2086
"$tetloom" adapt pieces.pvtu -o next.pvtu --tets-per-part 1500 $field
rm -rf expected
mkdir expected
mv next* expected/
digest=$(grep '"digest"' report.json)
for ranks in 1 2 3 7; do
    # shellcheck disable=SC2086
    on_ranks "$ranks" adapt pieces.pvtu -o next.pvtu --tets-per-part 1500 --threads 1 $field
    diff -r next expected/next || fail "other pieces on $ranks ranks"
    [ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest of pieces on $ranks ranks"
    told=$(grep -c '"peak_bytes"' report.json)
    [ "$ranks" = 1 ] || [ "$told" = $((ranks + 1)) ] || fail "the memory of $ranks ranks is told $told times"
    rm -rf next*
done
# The metric of a file belongs to points in the order of their ids.
file="--metric sizes.sol --tets-per-part 1500 --quiet --report report.json"
"$tetloom" partition mesh.mesh -o given.pvtu --parts 5 --quiet
same_on_ranks given.pvtu "$file"
"$tetloom" mesh model.step -o other.mesh --imprint --relative-size 0.08 --quiet
write_sizes other.mesh 2.5 > other.sol
status=0
on_ranks 2 adapt given.pvtu -o next.pvtu --metric other.sol --quiet 2> errors || status=$?
[ "$status" = 3 ] || fail "status $status for the metric of another mesh"
# A run is stopped and goes on in many more parts, on another number of ranks. Some parts have no tets.
# shellcheck disable=SC2086
"$tetloom" adapt mesh.mesh -o before.pvtu --parts 64 $field
"$tetloom" partition before.pvtu --parts 16384 -o many.pvtu --quiet
# shellcheck disable=SC2086
"$tetloom" adapt many.pvtu -o next.pvtu --tets-per-part 1500 $field
rm -rf expected
mkdir expected
mv next* expected/
digest=$(grep '"digest"' report.json)
rm -rf many*
on_ranks 3 partition before.pvtu --parts 16384 -o many.pvtu --quiet
# shellcheck disable=SC2086
on_ranks 3 adapt many.pvtu -o next.pvtu --tets-per-part 1500 --threads 1 $field
diff -r next expected/next || fail "other pieces on 3 ranks after a restart"
[ "$digest" = "$(grep '"digest"' report.json)" ] || fail "another digest on 3 ranks after a restart"
rm -rf next* before* many*
# A metric of second derivatives, finer where the model is curved, is made where the pieces lie.
solution="--hessian solution_1 --complexity 400 --gradation 1.5 --model model.step --imprint --curvature 10"
solution="$solution --tets-per-part 1500 --quiet --report report.json"
same_on_ranks pieces.pvtu "$solution"
# One file is read by slices, with its fields; a metric in another file belongs to its points.
for given in given.vtu given.msh; do
    # shellcheck disable=SC2086
    "$tetloom" adapt mesh.mesh -o "$given" $field
done
same_on_ranks given.vtu "$solution"
same_on_ranks given.msh "--tets-per-part 1500 $field"
same_on_ranks mesh.mesh "$file"
# So are fields on points and on tets in a file beside it.
same_on_ranks mesh.mesh "$solution"
same_on_ranks mesh.mesh "--tets-per-part 1500 $field"
cp -r pieces pieces.whole
for wrong in missing foreign truncated; do
    rm pieces/pieces_2.vtu
    [ "$wrong" != foreign ] || cp pieces/pieces_1.vtu pieces/pieces_2.vtu
    [ "$wrong" != truncated ] || head -c 3000 pieces.whole/pieces_2.vtu > pieces/pieces_2.vtu
    status=0
    # shellcheck disable=SC2086
    on_ranks 2 adapt pieces.pvtu -o next.pvtu $field 2> errors || status=$?
    [ "$status" = 3 ] || fail "status $status where a piece is $wrong"
    [ ! -e next.pvtu ] || fail "a run with a $wrong piece left something behind"
    cp pieces.whole/pieces_2.vtu pieces/
done

rm -rf parts parts.pvtu
for output in parts.pvtu whole.vtu; do
    status=0
    on_ranks 2 adapt missing.mesh -o "$output" --metric sizes.sol 2> errors || status=$?
    [ "$status" = 3 ] || fail "status $status where the mesh is missing"
    status=0
    on_ranks 2 adapt mesh.mesh -o "$output" --metric missing.sol 2> errors || status=$?
    [ "$status" = 3 ] || fail "status $status where the metric is missing"
    status=0
    on_ranks 2 adapt mesh.mesh -o "nowhere/$output" --metric sizes.sol 2> errors || status=$?
    [ "$status" = 6 ] || fail "status $status where nothing can be written"
done
for left in parts parts.pvtu whole.vtu; do
    [ ! -e "$left" ] || fail "a run that failed left $left behind"
done

write_sizes mesh.mesh 0.4 > fine.sol
check_signals adapt adapt mesh.mesh -o signal.pvtu --metric fine.sol --threads 1
