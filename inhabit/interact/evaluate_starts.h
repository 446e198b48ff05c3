#pragma once
#include "inhabit/interact/evaluate.h"

namespace inhabit::interact {

/// What people do who start somewhere around a chair.
struct StartScores {
  std::string starts;  ///< which: "behind", or the chair
  std::string method;  ///< its name
  Estimate seated;     ///< fraction of runs that end seated, as in Scores::success
  Estimate through;    ///< fraction of runs whose approach leads through the chair
  Estimate around;     ///< fraction that end seated and never went through it
  Estimate depth;      ///< metres: the deepest vertex of the skin in the scene before sitting down
};

/// `runs` starts behind the chairs of trials, one after the other: 120 to 240 degrees from the chair's front, 1 to 3 m
/// from the middle of the seat, any heading.
std::vector<Trial> behind_chairs(const std::vector<Trial>& trials, int64_t runs, uint64_t seed);

/// `runs` starts 1 to 3 m from a chair that nobody was recorded on, from where the floor leads to it, any direction and
/// heading, hands free. Wide seats are sat on where it is nearest. Who is seated has the pelvis 15 cm over the seat's
/// surface.
std::vector<Trial> around_chair(const Scene& scene, const Chair& chair, int64_t runs, uint64_t seed);

/// Starts that make rows of their own: around one chair, or behind those of a data set.
struct StartSet {
  std::string name;           ///< in the table
  std::vector<Trial> starts;  ///< as many in every set
};

/// For each chair in a scene `runs` starts around it, named after the chair. Throws Error(path, ...) where nothing can
/// be sat on. @param path of the scene, named in errors
std::vector<StartSet> around_chairs(const Scene& scene, const std::string& path, int64_t runs, uint64_t seed);

/// The approach ends when the pelvis is at 92 % of the height that it has at first. Until then somebody went through
/// the chair whose skin was over 5 cm in the scene, or whose pelvis was over the chair as seen from above,
/// elsewhere than before its seat. @param parts of the starts of each set: a part measures its own, and nothing is
/// returned where others are still to come
std::vector<StartScores> evaluate_starts(const std::vector<StartSet>& sets, const std::vector<InteractMethod>& methods,
                                         uint64_t seed, const Progress& progress = {}, const MeasuredParts& parts = {});

/// Starts away from the seat as a table, a row for each set and method: seated, through and around (%), depth (cm).
ScoreTable score_table(const std::vector<StartScores>& rows);

}  // namespace inhabit::interact
