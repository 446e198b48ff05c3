#pragma once
#include "inhabit/forecast/config.h"
#include "inhabit/train/stages.h"

namespace inhabit::forecast {

/// Trains stage by stage (3.3):
/// - "contact", the contact network;
/// - "motion", the motion network with true contact points;
/// - "no_contact", the same without contact points;
/// - "adapt" (not in the paper), which continues "motion" on batches of which half have predicted contact points. A
///   network trained on true ones alone trusts every mistake of the contact network;
/// - "ltd", LTD, a baseline; the only stage that must be asked for.
/// Returns false when it was interrupted.
bool train(const TrainRun& run, const Config& config);

}  // namespace inhabit::forecast
