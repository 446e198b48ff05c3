#pragma once
#include "inhabit/forecast/config.h"
#include "inhabit/train/stages.h"

namespace inhabit::forecast {

/// Trains stage by stage (3.3): "contact", the contact network; "motion", the motion network with true contact points;
/// "no_contact", the same without contact points; "adapt", which the paper has not and which goes on with the motion
/// network on batches of which half have the contact points that the contact network predicts: trained on true ones
/// alone it trusts every mistake of the first network. These are the usual ones; "ltd" trains LTD, which is only
/// compared with. Returns false when it was interrupted.
bool train(const TrainRun& run, const Config& config);

}  // namespace inhabit::forecast
