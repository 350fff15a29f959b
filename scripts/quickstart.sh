#!/usr/bin/env bash
# From a fresh checkout to a mesh and its picture: installs what is missing, builds tetloom, generates two CAD models,
# meshes them, draws the meshes and says where everything is.
#
# usage: scripts/quickstart.sh [FOLDER]      default: out
source "$(dirname "$0")/common.sh"

out=${1:-out}
mkdir -p "$out"

say "1/4 Installing missing Debian packages"
./scripts/install-deps.sh build picture

say "2/4 Building (preset release; the first time takes some minutes)"
configure_and_build release tetloom tetloom-tetgen tetloom-demo-model
bin=build/release/bin

say "3/4 Generating two CAD models and meshing them"
"$bin/tetloom-demo-model" part "$out/machined_part.step"
"$bin/tetloom-demo-model" assembly "$out/assembly.step"
"$bin/tetloom" mesh "$out/machined_part.step" -o "$out/machined_part.vtu" --relative-size 0.018 --curvature 24 \
  --report "$out/machined_part.json"
echo
"$bin/tetloom" mesh "$out/assembly.step" -o "$out/assembly.vtu" --imprint --relative-size 0.02 --curvature 24 \
  --report "$out/assembly.json"
"$bin/tetloom" check "$out/machined_part.vtu" --quiet && "$bin/tetloom" check "$out/assembly.vtu" --quiet
echo
echo "tetloom check: both meshes are valid."

say "4/4 Drawing the meshes"
./scripts/draw_mesh.py "$out/machined_part.vtu" "$out/machined_part.png" --clip 0.35,-1,0,0.55
./scripts/draw_mesh.py "$out/assembly.vtu" "$out/assembly.png" --clip 0.4,-1,0,0.5 --view=-62,22

cat <<TEXT

Done. In $(realpath "$out"):
  machined_part.step   the CAD model: a bracket with fillets, holes, a pocket and a B-spline top face
  machined_part.vtu    its mesh; open it with ParaView, or: $bin/tetloom info $out/machined_part.vtu
  machined_part.png    the mesh, cut open: CAD faces in their own colours (the orange face is the B-spline top, the
                       green one the bore), and the tetrahedra inside
  machined_part.json   the report: counts, time per stage, quality, volume against the model's
  assembly.*           the same for a steel body in a rubber seal: two solids that share the faces where they touch,
                       so the mesh is conforming across the two materials

Next, a model of your own:   $bin/tetloom mesh part.step -o part.vtu
All options:                 $bin/tetloom mesh --help
TEXT
