#!/usr/bin/env bash
# Remakes the tables of docs/ from the recordings: data, then every evaluation, each in a file of its own. What is there
# already is not made again, so that an interrupted run goes on; how long each part took is in OUT/times.txt.
# usage: scripts/results.sh forecast|anticipate|inbetween|interact|all RECORDINGS OUT [SPLIT]
#   RECORDINGS  as scripts/fit_recordings.sh takes it (cmu/ is what anticipation needs; interact needs none). Where
#               trumans/ is there (the .glb of the release, its .npz in a folder test/), it is tested on, too
#   SPLIT       val (default) or test, of forecast and inbetween; the other two tables are of the test split
# INHABIT names the command (default build/release/cli/inhabit).
set -euo pipefail
cd "$(dirname "$0")/.."
usage() { sed -n '2,/^set/s/^# //p' "$0"; exit 2; }
[ $# -ge 3 ] || usage
system=$1 recordings=$(realpath "$2") split=${4:-val}
mkdir -p "$3"
out=$(realpath "$3")
export INHABIT=${INHABIT:-$PWD/build/release/cli/inhabit}

# step NAME COMMAND...: what COMMAND prints becomes NAME.txt, whole or not at all.
step() {
  local name=$1 begin=$SECONDS
  shift
  if [ -e "$out/$name.txt" ]; then return; fi
  echo "$name: $*" | sed "s#$INHABIT#inhabit#g; s#$out/##g; s#$recordings#RECORDINGS#g"
  "$@" >"$out/$name.txt.part" 2>"$out/$name.log" || { tail -3 "$out/$name.log" >&2; return 1; }
  mv "$out/$name.txt.part" "$out/$name.txt"
  echo "$name $((SECONDS - begin)) s" >>"$out/times.txt"
}

rooms() { step data_rooms "$INHABIT" synth rooms --clips 2000 --seed 61 --out "$out/rooms"; }
fitted() { step data_recordings scripts/fit_recordings.sh "$recordings" "$out"; }
trumans() {
  step data_trumans "$INHABIT" synth fit --mocap "$recordings"/trumans/test/*.npz --rooms-per-clip 3 --out "$out/trumans"
}
recorded=(cmu walk bvh hdm05 dance salsa)

forecast() {
  rooms
  fitted
  step forecast "$INHABIT" eval forecast --data "$out/rooms" "$out/bvh" "$out/hdm05" --split "$split" --stride 200 --intervals \
    --json "$out/forecast.json"
  step forecast_contacts "$INHABIT" eval contacts --data "$out/rooms" "$out/bvh" "$out/hdm05" --split "$split" --stride 400
  step forecast_recordings "$INHABIT" eval forecast --data "$out"/{cmu,walk,dance,salsa} --split "$split" --stride 200 --intervals
  if [ -d "$recordings/trumans" ]; then
    trumans
    step forecast_trumans "$INHABIT" eval forecast --data "$out/trumans" --split test --stride 30 --intervals
  fi
}

anticipate() {
  step anticipate "$INHABIT" eval anticipate --data "cmu:$recordings/cmu" --json "$out/anticipate.json"
  step anticipate_left_out "$INHABIT" eval anticipate --data "cmu:$recordings/cmu" --split left-out
  step anticipate_labels "$INHABIT" intentions "cmu:$recordings/cmu" -o "$out/intentions.html"
}

inbetween() {
  rooms
  fitted
  local searched='searched: detours=searched' straight='straight: detours=straight' varied='varied: temperature=1'
  step inbetween_rooms "$INHABIT" eval inbetween --data "$out/rooms" --split "$split" --windows 120 \
    --seeds 2 --row "$searched" --row "$straight" --row "$varied" --json "$out/inbetween_rooms.json"
  step inbetween_recordings "$INHABIT" eval inbetween --data "${recorded[@]/#/$out/}" --split "$split" --windows 120 \
    --seeds 2 --row "$searched" --row "$straight" --row "$varied" --json "$out/inbetween_recordings.json"
  local every set sets=(rooms "${recorded[@]}")
  if [ -d "$recordings/trumans" ] && [ "$split" = test ]; then
    trumans
    sets+=(trumans)
  fi
  for every in 15 60; do
    for set in "${sets[@]}"; do
      step "inbetween_${set}_every_$every" "$INHABIT" eval inbetween --data "$out/$set" --split "$split" --windows 100 --no-refine \
        --keyframes "every:$every"
    done
  done
  local counts=(1 2 3 4 8 16 64 250 1000) rows=() count
  for count in "${counts[@]}"; do rows+=(--row "$count steps: inference.steps=$count"); done
  step inbetween_steps "$INHABIT" eval inbetween --data "$out/rooms" --split val --windows 40 --no-refine "${rows[@]}"
  # The paper's Tables 2, 3, 4, 6 and 9; those above are Table 1.
  local noisy="$PWD/models/inbetween-noisy.safetensors"
  step inbetween_table_2 "$INHABIT" eval inbetween --data "$out/rooms" --split "$split" --windows 120 --no-refine --layout close \
    --row 'blind: inference.guidance=0 detours=straight'
  step inbetween_table_3 "$INHABIT" eval inbetween --data "$out/rooms" --split "$split" --windows 120 --no-refine --noise 1 \
    --keyframes every:3 --model "$noisy"
  step inbetween_table_6 "$INHABIT" eval inbetween --data "$out/rooms" --split "$split" --windows 120 --no-refine --noise 1 \
    --keyframes every:1 every:3 every:15 every:60 random:0.2 random:0.5 --layout keys --model "$noisy"
  step inbetween_table_9 "$INHABIT" eval inbetween --data "$out/rooms" --split "$split" --windows 60 --no-refine --seeds 20 --layout seeds
  if [ -d "$recordings/trumans" ]; then
    trumans
    step inbetween_table_4 "$INHABIT" eval inbetween --data "$out/trumans" --split test --windows 120 --no-refine --no-truth \
      --keyframes every:15 --model "$noisy"
  fi
  # How collisions depend on the tolerance: of skin that carries weight, then of all other skin, each by itself.
  local depth
  for depth in 0 0.005 0.01 0.02 0.04 0.06 0.1; do
    step "inbetween_supported_$depth" "$INHABIT" eval inbetween --data "$out/rooms" --split val --windows 120 --no-refine \
      --supported-tolerance "$depth" --tolerance 10 --json "$out/inbetween_supported_$depth.json"
    step "inbetween_other_$depth" "$INHABIT" eval inbetween --data "$out/rooms" --split val --windows 120 --no-refine \
      --supported-tolerance 10 --tolerance "$depth" --json "$out/inbetween_other_$depth.json"
  done
  step inbetween_tolerances node scripts/plot_tolerances.mjs "$out/tolerances.svg" "$out"
  step inbetween_detour "$INHABIT" eval detour --rooms 50 --seeds 10 --no-refine --row "$searched" --row "$straight" --row "$varied"
}

interact() {
  step data_chairs "$INHABIT" synth chairs --minutes 900 --subjects 6 --seed 2 --out "$out/chairs"
  step interact "$INHABIT" eval interact --data "$out/chairs" --json "$out/interact.json"
  step interact_behind "$INHABIT" eval interact --data "$out/chairs" --runs 100 --behind 100 --seed 2
  step interact_contacts "$INHABIT" eval interact --data "$out/chairs" --draws 10
  if [ -d "$recordings/trumans" ]; then
    step interact_furniture "$INHABIT" eval interact --scene "$recordings"/trumans/{kitchen_chair_1,kitchen_chair_2,office_chair,wc,sofa,bed}.glb \
      --runs 20
  fi
}

case $system in
  forecast | anticipate | inbetween | interact) $system ;;
  all) for each in forecast anticipate inbetween interact; do $each; done ;;
  *) usage ;;
esac
echo "tables in $3"
