#!/usr/bin/env bash
# Installs what is missing, builds, forecasts the bundled motions in their rooms, lets somebody sit down with both hands on the arm rests, and ends with
# out/demo/index.html.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/dependencies.sh
cmake --preset release -DINHABIT_BUILD_TESTS=OFF -DINHABIT_BUILD_BENCHMARKS=OFF >/dev/null
cmake --build --preset release --target inhabit_command
inhabit=build/release/cli/inhabit
data=examples/data
out=out/demo
mkdir -p "$out"
for each in walk:30 sit:205; do
  name=${each%:*}
  $inhabit forecast $data/$name.npz --scene $data/${name}_room.glb --start "${each#*:}" \
    -o $out/$name.html -o $out/$name.npz -o $out/$name.bvh -o $out/$name.glb -o $out/$name.json
done
$inhabit interact --scene $data/sit_room.glb --chair armchair_0 --start=0,1,90 --left armrest --right armrest --hold end --seconds 12 \
  -o $out/armchair.html -o $out/armchair.npz -o $out/armchair.bvh -o $out/armchair.glb
node scripts/demo_index.mjs $out/index.html "inhabit: people who move through real rooms" \
  "Forecasts show the second that was observed (grey), the next two as predicted (blue) and what really happened (orange)." \
  walk.html "Walking" "A recorded walk from the CMU motion capture database, in a room furnished around it." \
  sit.html "Sitting down" "A person of a generated data set turns, sits down on a sofa and leans back." \
  armchair.html "Both hands on the arm rests" "A person is told where the hands go, walks up to the armchair, turns, reaches and sits down."
echo "open $out/index.html"
