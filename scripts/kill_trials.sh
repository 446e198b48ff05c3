#!/usr/bin/env bash
# Kills commands (kill -9) while they work and looks at what is left. Under a final name there may be nothing, the whole
# file, or the file that was there before; everything else must have the name of a temporary, .NAME.PID.N.part. Every
# second kill comes at a random moment of the run, the others when a temporary is there, at once or up to 10 ms later.
# Then two runs at once write one output, and a training is killed and resumed until it ends, with the weights of one
# that was never killed. Prints a table; fails where anything is broken.
# usage: scripts/kill_trials.sh [KILLS [TRAINING_KILLS]]     KILLS (default 12) of each command; INHABIT: the command
set -euo pipefail
shopt -s nullglob globstar dotglob
cd "$(dirname "$0")/.."
kills=${1:-12} training_kills=${2:-6} inhabit=${INHABIT:-build/release/cli/inhabit} data=$PWD/examples/data
export OMP_NUM_THREADS=1 INHABIT_MODELS=${INHABIT_MODELS:-$PWD/models}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
whole=$work/whole out=$work/out broken=0 total=0

now() { date +%s%3N; }
pause() { sleep "$(printf '%d.%03d' $(($1 / 1000)) $(($1 % 1000)))"; }
bad() { echo "BROKEN: $*" >&2; broken=$((broken + 1)); }
# Starts the command whose outputs go to folder $1: @ in its words. Its process is $pid.
start() { local to=$1; shift; (exec "$inhabit" "${@//@/$to}" >"$work/log" 2>&1) & pid=$!; }
# What it gives when nobody kills it, in $whole, and how long that takes, in $took (ms).
finish() {
  local before
  rm -rf "$whole" && mkdir "$whole"
  before=$(now)
  start "$whole" "$@"
  wait $pid || { cat "$work/log" >&2; exit 1; }
  took=$(($(now) - before))
}

kill_writing() {  # NAME COMMAND...
  local name=$1 path file hit=0 parts=0 finished=0 kept=0
  shift
  finish "$@"
  for ((k = 0; k < kills; ++k)); do
    rm -rf "$out" && mkdir "$out"
    # Half of the time files stand there already; a data set begins in an empty folder.
    if ((k / 2 % 2)) && [ ! -d "$whole/clips" ]; then for path in "$whole"/*; do echo before >"$out/${path##*/}"; done; fi
    start "$out" "$@"
    if ((k % 2)); then
      while kill -0 $pid 2>/dev/null; do  # no other process is started: a temporary lives for a millisecond
        file=("$out"/**/.*.part)
        [ ${#file[@]} -eq 0 ] || break
      done
      ((k % 4 == 1)) || pause $((RANDOM % 10))
    else
      pause $((RANDOM * took / 32768))
    fi
    kill -9 $pid 2>/dev/null || true
    wait $pid 2>/dev/null || hit=$((hit + 1))
    for path in "$out"/**; do
      [ -f "$path" ] || continue
      if [[ ${path##*/} =~ ^\..+\.[0-9]+\.[0-9]+\.part$ ]]; then parts=$((parts + 1))
      elif cmp -s "$path" "$whole/${path#"$out"/}"; then finished=$((finished + 1))
      elif cmp -s "$path" <(echo before); then kept=$((kept + 1))
      else bad "$name left ${path#"$out"/}"; fi
    done
  done
  total=$((total + hit))
  printf '%-14s %6d %6d %6d %6d\n' "$name" $hit $parts $finished $kept
}

lines_of() { { cat "$1" 2>/dev/null || true; } | wc -l; }
kill_training() {  # COMMAND...: --out is @/m.safetensors
  local log=$out/m.safetensors.log.jsonl last resume killed=0 resumed=0
  finish "$@"
  rm -rf "$out" && mkdir "$out"
  for (( ; ; )); do
    resume=()
    [ ! -e "$out/m.safetensors.checkpoint.safetensors" ] || resume=(--resume)
    resumed=$((resumed + ${#resume[@]}))
    [ ${#resume[@]} -gt 0 ] || rm -f "$log"
    last=$(($(lines_of "$log") + RANDOM % 30))  # a line every ten steps or so
    start "$out" "$@" "${resume[@]}"
    if ((killed < training_kills)); then
      while kill -0 $pid 2>/dev/null && (($(lines_of "$log") < last)); do pause 20; done
      kill -9 $pid 2>/dev/null || true
    fi
    wait $pid 2>/dev/null && break
    [ $? -eq 137 ] || { cat "$work/log" >&2; bad "a training could not be resumed"; break; }
    killed=$((killed + 1))
  done
  cmp -s "$whole/m.safetensors" "$out/m.safetensors" || bad "a training killed $killed times has other weights"
  echo "training: $killed kills, $resumed times resumed, the weights are those of a run that was not killed"
}

two_at_once() {  # NAME COMMAND...
  local name=$1 first
  shift
  finish "$@"
  rm -rf "$out" && mkdir "$out"
  start "$out" "$@"
  first=$pid
  start "$out" "$@"
  wait $first || bad "$name: the first of two failed"
  wait $pid || bad "$name: the second of two failed"
  diff -rq "$whole" "$out" >&2 || bad "$name: two at once wrote another file"
}

motion="$data/walk.npz --scene $data/walk_room.glb"
writers=(
  "convert convert $data/walk.npz @/w.glb"
  "view view $motion -o @/v.html"
  "refine refine $motion -o @/r.npz -o @/r.bvh -o @/r.html"
  "forecast forecast $motion -o @/f.npz -o @/f.glb -o @/f.html"
  "inbetween inbetween $motion -o @/i.npz -o @/i.json -o @/i.html"
  "anticipate anticipate $data/walk.npz --samples 10 --seconds 5 -o @/a.npz -o @/a.html"
  "average average models/forecast-compact.safetensors models/forecast-compact.safetensors -o @/m.safetensors"
  "score score ndms --motion $data/walk.npz --reference $data/sit.npz --json @/s.json"
  "synth_rooms synth rooms --clips 3 --seconds 4 --clips-per-room 1 --out @"
  "synth_fit synth fit --mocap $data/walk.npz --seconds 3 --rooms-per-clip 2 --out @"
)
printf '%-14s %6s %6s %6s %6s\n' command killed parts whole before
for writer in "${writers[@]}"; do kill_writing $writer; done
echo "$total commands killed"
for writer in "${writers[@]:0:8}"; do two_at_once $writer; done
echo "two at once: 8 commands"
"$inhabit" synth rooms --clips 3 --clips-per-room 1 --seconds 6 --seed 3 --out "$work/rooms" >/dev/null
kill_training train features --data "$work/rooms" --set training.steps=500 training.batch=2 --out @/m.safetensors
[ $broken -eq 0 ] || { echo "$broken broken" >&2; exit 1; }
