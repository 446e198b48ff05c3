#pragma once
#include "inhabit/forecast/config.h"
#include "inhabit/train/stages.h"

namespace inhabit::forecast {

/// Trains stage by stage (3.3):
/// - "contact", the contact network;
/// - "motion", the motion network. The paper's: with true contact points. The articulated one: half of the windows with
///   what the contact network predicts (of this run, of the model file, or of the one that weights start from), most
///   others with true contact points, the rest without any;
/// - "hypotheses", several ways to go on beside the articulated network's (hypotheses.h);
/// - "ltd", "hisrep", "dmgnn" and "slt", the baselines LTD, HisRep, DMGNN and SLT*, which must be asked for.
/// Of the paper's network alone:
/// - "no_contact", the same without contact points;
/// - "adapt" (not in the paper), which continues "motion" on batches of which half have predicted contact points. A
///   network trained on true ones alone trusts every mistake of the contact network.
/// Returns false when it was interrupted.
bool train(const TrainRun& run, const Config& config);

}  // namespace inhabit::forecast
