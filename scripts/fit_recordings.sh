#!/usr/bin/env bash
# The data sets of rooms around recordings that docs/dataset.md describes, from unpacked archives, split by person.
# usage: scripts/fit_recordings.sh RECORDINGS OUT [SUFFIX] [OPTION...]
#   RECORDINGS  holds cmu/, walking_extra/, bvh_05_07/, bvh_dance_martial/, hdm05/, asf_amc_01_03/ (those that are missing
#               are left out)
#   OUT         gets a data set for each: cmu, walk, bvh, dance, salsa, hdm05, playground, with SUFFIX behind its name
#   OPTION      more options of `inhabit synth fit`, such as --only-on-chord
# INHABIT names the command (default build/release/cli/inhabit), ROOMS scales the number of rooms (default 1).
set -euo pipefail
shopt -s nullglob
in=$1 out=$2 suffix=${3:-}
shift $(($# < 3 ? $# : 3))
inhabit=${INHABIT:-$(dirname "$0")/../build/release/cli/inhabit}
extra=("$@")

# fit NAME ROOMS OPTION... : nothing where no recording is there.
fit() {
  local name=$1 rooms=$(($2 * ${ROOMS:-1}))
  shift 2
  [ -e "${2:-}" ] || { echo "$name: no recordings"; return; }
  # 1: recordings were skipped that make no clip (running has no floor to stand on for two seconds), which are named.
  "$inhabit" synth fit --out "$out/$name$suffix" --rooms-per-clip "$rooms" "$@" "${extra[@]}" || [ $? -eq 1 ]
}

# Who is who: the text files of cmu/ and walking_extra/ name no subjects. By frame counts and postures, who is in
# test/basketball, soccer, running and walking is also in train/basketball, soccer and running and in
# walking_extra/test; basketball is subject 6. The jumper's and the window washer's other recordings cannot be told; all
# jumps are kept for testing. Subject 7 is in train/walking 4 and 5 and in walking_extra 13 to 17.
# The root's orientation is broken where people turn in directing_traffic_1 and in walking_extra 22 to 26 and 48 to 50: most
# of their frames skate, or the body lies in the air.
c=$in/cmu w=$in/walking_extra
walk7=("$w"/train/*/walking_1[3-7].txt)
walks=() signals=()
for f in "$w"/train/*/walking_*.txt; do [[ $f =~ walking_(1[3-7]|2[2-6]|48|49|50)\.txt$ ]] || walks+=("$f"); done
for f in "$c"/train/{basketball_signal,directing_traffic}/*.txt; do [[ $f =~ traffic_1\.txt$ ]] || signals+=("$f"); done
fit cmu 12 --mocap "${signals[@]}" "$c"/train/walking/walking_[123].txt \
  --val "$c"/train/walking/walking_[45].txt \
  --test "$c"/train/{basketball,soccer,running,jumping}/*.txt "$c"/test/*/*.txt
fit walk 16 --mocap "${walks[@]}" --val "${walk7[@]}" --test "$w"/test/*/*.txt
fit bvh 12 --mocap "$in"/bvh_05_07/005_*.bvh --val "$in"/bvh_05_07/007_*.bvh --test "$in"/bvh_05_07/006_*.bvh
fit hdm05 10 --mocap "$in"/hdm05/HDM_{bd,bk,dg}_*.amc --val "$in"/hdm05/HDM_mm_*.amc \
  --test "$in"/hdm05/HDM_tr_*.amc
# Indian dance is one dancer (94 in the CMU database), martial arts one fighter (135). Of the couple that dances salsa one
# (recordings 01 to 15) is learned from; the other (16 to 30) dances the same dances.
d=$in/bvh_dance_martial
fit dance 8 --mocap "$d"/indian_*.bvh --val "$d"/martial_0[34].bvh --test "$d"/martial_{0[5-9],10}.bvh
fit salsa 6 --mocap "$d"/salsa_{0[1-9],1[0-5]}.bvh --val "$d"/salsa_{1[6-9],2[0-2]}.bvh \
  --test "$d"/salsa_{2[4-9],30}.bvh --input-rate 60
# Where subjects 1 and 3 climb and tread on what is no floor, their recordings are cut out.
p=$in/asf_amc_01_03
fit playground 8 --mocap "$p"/01_*.amc --val "$p"/03_0[12].amc --test "$p"/03_0[34].amc
