#!/usr/bin/env bash
# The ablations of intention-driven anticipation (paper, Figs. 4 and 5) and the number of intention labels: trains one
# model for each configuration, evaluates it, and draws the NDMS curves: of the parts that the paper has, without a
# memory and the loss that came with it. A model that is there already is not trained again.
# usage: scripts/ablations.sh DATA OUT [STEPS]     DATA as `inhabit train anticipate --data` takes it
# INHABIT names the command (default build/release/cli/inhabit).
set -euo pipefail
cd "$(dirname "$0")/.."
data=$1 out=$2 steps=${3:-320}
inhabit=${INHABIT:-build/release/cli/inhabit}
mkdir -p "$out"
without_memory=(memory=false training.plausibility_weight=0 training.pose_discriminator_weight=0.03
  training.learning_rate=5e-4 training.label_frames=250)
configurations=(
  "full"
  "no_intention intention=false"
  "no_label_discriminator training.label_discriminator=false"
  "no_pose_discriminator training.pose_discriminator=false"
  "rec_30 training.rec_frames=30"
  "rec_always training.rec_frames=0"
  "naive_clusters naive_clusters=true"
  "gamma_1 gamma=1"
  "gamma_5 gamma=5"
  "gamma_20 gamma=20"
  "labels_2 labels=2"
  "labels_4 labels=4"
  "labels_16 labels=16"
)
for configuration in "${configurations[@]}"; do
  read -r name setting <<<"$configuration"
  model=$out/$name.safetensors
  if [ ! -e "$out/$name.json" ]; then
    resume=""
    [ -e "$model.checkpoint.safetensors" ] && resume=--resume
    $inhabit train anticipate --data "$data" --stage intention --out "$model" $resume \
      --set "training.steps=$steps" training.batch=32 "${without_memory[@]}" ${setting:+"$setting"}
    $inhabit eval anticipate --data "$data" --model "$model" --seconds 10 --json "$out/$name.json"
  fi
done
node scripts/plot_ndms.mjs "$out/ablation-losses.svg" "Loss terms (Fig. 4)" "$out"/{full,no_intention,no_label_discriminator,no_pose_discriminator}.json
node scripts/plot_ndms.mjs "$out/ablation-rec.svg" "tau_rec (Fig. 5a)" "$out"/{full,rec_30,rec_always}.json
node scripts/plot_ndms.mjs "$out/ablation-clusters.svg" "Clustering (Fig. 5b)" "$out"/{full,naive_clusters}.json
node scripts/plot_ndms.mjs "$out/ablation-gamma.svg" "gamma (Fig. 5c)" "$out"/{gamma_1,gamma_5,full,gamma_20}.json
node scripts/plot_ndms.mjs "$out/ablation-labels.svg" "Intention labels" "$out"/{labels_2,labels_4,full,labels_16}.json
