#!/usr/bin/env bash
# Runs the benches of whole volume meshes and of adaptation and draws their figures. For a machine that does nothing else: each figure
# names the machine, the date and the commit, and says so where the machine was busy.
#
# usage: scripts/render_plots.sh [--quick | --long] [FOLDER]      default: docs/images
#   (neither)  spline-block and filleted-plate with 5 million tets beside HXT; speed-up and scale with 1, 5 and 20
#              million tets of spline-block; adaptation of the cube to five metrics, up to a million tets; 3 runs of each
#   --long     up to 300 million tets for the scale, one run of each; files of that size go to $TMPDIR
#   --quick    small meshes once, only to see that it works
#
# volume_peers.svg        tetloom beside HXT: speed from file to file, speed of the 3D stage, memory
# volume_speedup.svg      measured speed-up by threads, per stage
# volume_prediction.svg   what the tasks of a run would give on up to 64 threads: a prediction
# volume_scale.svg        tets against time and memory
# adapt_peers.svg         adaptation beside MMG and refine, where they are installed: speed, fit, memory
# adapt_speedup.svg       adaptation: measured speed-up by threads, per stage
# adapt_prediction.svg    what the tasks of adaptation would give on up to 64 threads: a prediction
# The figures' numbers go to FOLDER/*.json when FOLDER is not docs/images, else to build/release/bench.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

peer_options=(--models spline-block,filleted-plate --tets 5e6 --threads 2)
speedup_options=(--model spline-block --tets 1e6,5e6,20e6)
scale_options=(--model spline-block --tets 1e6,5e6,20e6)
adapt_options=()
case "${1:-}" in
  --quick)
    peer_options=(--quick) speedup_options=(--quick) scale_options=(--quick) adapt_options=(--quick)
    shift ;;
  --long)
    scale_options=(--model spline-block --tets 1e6,5e6,20e6,100e6,300e6 --runs 1)
    shift ;;
  --*)
    sed -n '2,/^source/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" >&2
    exit 2 ;;
esac
images=${1:-docs/images}
mkdir -p "$images"
bench=build/release/bench
numbers=$images
[[ "$images" -ef docs/images ]] && numbers=$bench

# Waits, for five minutes at most, until nothing runs: the load is a mean of the last minute, with the bench before in it.
quiet=0.5 patience=60
[[ "$images" -ef docs/images ]] || patience=0
wait_until_quiet() {
  for ((i = 0; i < patience; ++i)); do
    awk -v most="$quiet" '{ exit !($1 < most) }' /proc/loadavg && break
    sleep 5
  done
  uptime
}

say "Building"
configure_and_build release tetloom volume_peers volume_speedup volume_scale adapt_peers adapt_speedup

say "Beside HXT"
wait_until_quiet
"$bench/volume_peers" "${peer_options[@]}" --svg "$images/volume_peers.svg" --json "$numbers/volume_peers.json"
say "Speed-up"
wait_until_quiet
"$bench/volume_speedup" "${speedup_options[@]}" --svg "$images/volume_speedup.svg" \
  --prediction "$images/volume_prediction.svg" --json "$numbers/volume_speedup.json"
say "Scale"
wait_until_quiet
"$bench/volume_scale" "${scale_options[@]}" --svg "$images/volume_scale.svg" --json "$numbers/volume_scale.json"
say "Adaptation"
wait_until_quiet
"$bench/adapt_peers" "${adapt_options[@]}" --svg "$images/adapt_peers.svg" --json "$numbers/adapt_peers.json"
wait_until_quiet
"$bench/adapt_speedup" "${adapt_options[@]}" --svg "$images/adapt_speedup.svg" \
  --prediction "$images/adapt_prediction.svg" --json "$numbers/adapt_speedup.json"

say "Done: $(realpath "$images")/{volume_{peers,speedup,prediction,scale},adapt_{peers,speedup,prediction}}.svg"
