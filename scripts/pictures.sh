#!/usr/bin/env bash
# Makes the pictures of the README and docs, docs/images, from the bundled motions. Needs the built command, chromium, img2webp (webp) and viewer's
# packages (npm ci).
# usage: scripts/pictures.sh [OUT]
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-docs/images}
inhabit=${INHABIT:-build/release/cli/inhabit}
data=examples/data
pages=$(mktemp -d)
trap 'rm -r "$pages"' EXIT
picture() { node scripts/screenshot.mjs "$pages/$1.html" "$out/$1.png" "${@:2}"; }

$inhabit forecast $data/sit.npz --scene $data/sit_room.glb --start 205 -o "$pages/forecast.html"
picture forecast --time 2.25 --size 1200x700
$inhabit anticipate $data/walk.npz --samples 20 --seconds 30 -o "$pages/anticipate.html"
picture anticipate --time 11 --size 960x640 --bare --overlaid --camera=4.6,3.0,6.0 --target=-1.3,0.9,11.2
$inhabit inbetween $data/sit.npz --scene $data/sit_room.glb --keyframes every:60 -o "$pages/inbetween.html"
picture inbetween --size 960x640 --bare --poses
$inhabit interact --scene $data/sit_room.glb --chair armchair_0 --start=0,1,90 --left armrest --right armrest --seconds 12 -o "$pages/interact.html"
node scripts/screenshot.mjs "$pages/interact.html" "$out/sit.webp" --film 1.5,9.5,10 --size 640x460 --bare --camera=0.12,2.25,-3.4 --target=0.8,0.9,-0.7
picture interact --time 8.6 --size 960x640 --bare --camera=-0.4,1.9,0.7 --target=1.35,0.72,-1.15
# What is refined: the end of a motion with noise of a degree and a centimetre, moved 15 cm into the sofa.
$inhabit convert $data/sit.npz "$pages/sit.json"
node - "$pages" <<'NOISE'
const { readFileSync, writeFileSync } = require('node:fs');
const folder = process.argv[2], clip = JSON.parse(readFileSync(`${folder}/sit.json`)), first = 150;
let state = 1;
const uniform = () => (state = (state * 48271) % 2147483647) / 2147483647;
const normal = () => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());
const { format, version, rate, skeleton } = clip;
const rotations = clip.rotations.slice(first).map((frame) => frame.map((joint) => joint.map((v) => v + normal() * Math.PI / 180)));
const trans = clip.trans.slice(first).map(([x, y, z]) => [x - 0.15 + 0.01 * normal(), y + 0.01 * normal(), z + 0.01 * normal()]);
writeFileSync(`${folder}/noisy.json`, JSON.stringify({ format, version, rate, skeleton, frames: trans.length, rotations, trans }));
NOISE
$inhabit refine "$pages/noisy.json" --scene $data/sit_room.glb -o "$pages/refine.html"
picture refine --time 4.5 --size 960x640 --bare --camera=-1.5,1.8,3.4 --target=-1.9,0.62,0.5
