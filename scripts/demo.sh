#!/usr/bin/env bash
# Installs what is missing, builds, forecasts the bundled motions in their rooms, and ends with out/demo/index.html.
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
node scripts/demo_index.mjs $out/index.html "inhabit: the next two seconds" \
  "Each page shows the second that was observed (grey), the next two as predicted (blue) and what really happened (orange)." \
  walk.html "Walking" "A recorded walk from the CMU motion capture database, in a room furnished around it." \
  sit.html "Sitting down" "A person of a generated data set turns, sits down on a sofa and leans back."
echo "open $out/index.html"
