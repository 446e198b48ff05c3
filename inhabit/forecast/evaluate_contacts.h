#pragma once

#include "inhabit/data/measured_parts.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/progress.h"

namespace inhabit::forecast {

/// The scene points that true contacts are looked for among: as many as are kept of a scene.
inline constexpr int kDensePoints = 20000;
/// A model's configuration with kDensePoints scene points.
Config dense_config(const Config& config);

/// How good contact points are, against those of the true motion among kDensePoints scene points: precision and recall
/// of "this joint touches in this frame", and the mean distance between contact points where both say so, in each
/// second of the future. Rows are true maps at the model's N points, the same cut to its L coefficients, the last
/// observed map kept, and what the contact network predicts (where there is one), each for feet (ankles and balls of
/// the feet) on the floor apart from all other contacts; then the predicted contacts of each joint; then, of several
/// data sets, the first rows of each. Intervals by bootstrap over windows.
/// @param data windows with config.inference.points scene points; @param dense the same windows as dense_config has
/// them.
/// @param progress told how many windows are done; may be empty. @param parts of the windows: a part measures its own,
/// and there are no rows where others are still to come.
/// Throws Error where the data have no window or the model is not of the standard joints.
ScoreTable evaluate_contacts(const Networks& networks, const Data& data, const Data& dense,
                             const Progress& progress = {}, const MeasuredParts& parts = {});

}  // namespace inhabit::forecast
