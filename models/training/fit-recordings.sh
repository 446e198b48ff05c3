#!/bin/bash
# Rooms around the recordings: `fitted` (train, val) and `fitted-test` (test). Run in the folder that holds cmu, walking_extra, bvh_05_07,
# hdm05, asf_amc and asf_amc_01_03; INHABIT names the command.
set -e
inhabit=${INHABIT:-inhabit}
# Left out: recordings whose root orientation is broken (the body lies in the air while it turns), and what is kept for validation.
keep() {
  for f in "$@"; do
    case $f in
      */walking_2[2-6].txt | */walking_4[89].txt | */walking_50.txt | */directing_traffic_1.txt) ;;
      */walking_1[3-5].txt | */basketball_signal_5.txt | */soccer_5.txt) ;;
      *) echo "$f" ;;
    esac
  done
}
"$inhabit" synth fit --rooms-per-clip 15 --seed 5 --out fitted \
  --mocap $(keep cmu/train/*/*.txt walking_extra/train/*/*.txt) bvh_05_07/005_*.bvh bvh_05_07/006_{01,10,11,12,14,15}.bvh \
  hdm05/HDM_{bd,bk,dg}_{depositFloorR,lieDownFloor,throwBasketball}_*.amc \
  --test hdm05/HDM_mm_{depositFloorR,grabHighR,lieDownFloor,throwBasketball}_*.amc asf_amc/02_*.amc \
  walking_extra/train/walking_extra/walking_1[3-5].txt cmu/train/basketball_signal/basketball_signal_5.txt cmu/train/soccer/soccer_5.txt
sed -i 's/"split": *"val"/"split": "train"/; s/"split": *"test"/"split": "val"/' fitted/dataset.json
"$inhabit" synth fit --rooms-per-clip 3 --seed 5 --out fitted-test --mocap cmu/test/*/*.txt walking_extra/test/*/*.txt \
  --test asf_amc_01_03/03_*.amc hdm05/HDM_tr_{depositFloorR,grabHighR,lieDownFloor,throwBasketball}_*.amc
