#pragma once
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/data/measured_parts.h"
#include "inhabit/interact/chair_interactor.h"
#include "inhabit/metrics/method.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/progress.h"

namespace inhabit::interact {

/// Somebody's start before a chair, where their hands went, and what they did.
struct Trial {
  std::string name;        ///< of the clip, in errors
  Scene scene;             ///< with the chair
  Chair chair;             ///< that is sat on
  Clip start;              ///< its first frame
  HandContacts contacts;   ///< the first of each hand while they get seated
  Clip truth;              ///< at most as long as what is generated, its Clip::action in the names of `run`'s
  double rest = 0;         ///< metres: the pelvis above the seat's surface in the recording
  std::string scene_file;  ///< the same for trials on the same chair
};

/// Trials of the clips of one split in which somebody sits down, at most `count`, evenly spread: where nobody sits in a
/// clip the next one takes its place.
std::vector<Trial> trials_of(const std::vector<std::string>& folders, const std::string& split, int64_t count,
                             double seconds);

/// What a method made of a trial. Its Clip::action is idle, walk or sit by name.
using InteractMethod = Method<Trial, Clip>;

/// How a model is used.
struct Use {
  bool raw = false;       ///< not fitted to contacts and scene (fit_contacts.h)
  bool straight = false;  ///< no route is planned around what stands in the way
};
/// A model as a method: from a trial's start and with its contacts, for `seconds`.
/// @param name in the table; "fitted" and "no route planned" are added as `use` has it
InteractMethod model_method(const std::string& name, std::shared_ptr<const ChairInteractor> interactor, double seconds,
                            const Use& use);

/// Everything in some model files that people can be moved by, in each use: "ours" and the baselines, of a second file
/// with the same one "ours (file)". @param files names, and what they hold. Throws Error where a file holds none.
std::vector<InteractMethod> methods_of(const std::vector<std::pair<std::string, Networks>>& files, double seconds,
                                       const std::vector<Use>& uses);

/// First frame from which the pelvis rests on the seat to the end, for a second or longer.
std::optional<int64_t> seated_from(const Clip& clip, const Trial& trial);

/// One method over all trials, lengths in metres.
struct Scores {
  std::string method;                 ///< its name, or "data"
  Estimate contact_error;             ///< mean of the palms' closest approach to their contacts (ACE)
  std::array<Estimate, 4> precision;  ///< fraction of contacts nearer than 3, 5, 7, 9 cm (AP at k)
  Estimate success;         ///< fraction of runs that end seated: the pelvis within 5 cm of the height, and 15 cm of
                            ///< the place over the seat, at which the recording's rests
  Estimate seconds_to_sit;  ///< of those
  double skating = 0;       ///< fraction of frames in which a foot slides
  double jerk = 0;          ///< m/s^3, mean over joints and frames
  Estimate penetration;     ///< the deepest vertex of the skin in the scene
  double apd_approach = 0;  ///< average pairwise distance of poses while walking (Eq. 5)
  double apd_sit = 0;       ///< the same while sitting
};

/// Scores of all methods.
struct Table {
  std::vector<Scores> rows;  ///< the data, then a method each
  int64_t trials = 0;        ///< runs of each
  int64_t contacts = 0;      ///< of hands, in all trials
};

/// The recordings themselves, then each method. Intervals are over trials. @param parts of the trials: a part measures
/// its own, and there are no rows where others are still to come
Table evaluate(const std::vector<Trial>& trials, const std::vector<InteractMethod>& methods, uint64_t seed,
               const Progress& progress = {}, const MeasuredParts& parts = {});

/// A row a method: contact error (cm), precision at 3 to 9 cm (%), seated (%), seconds until then, skating (%), jerk
/// (m/s^3), depth in the scene (cm), diversity while walking up and while seated.
ScoreTable score_table(const Table& table);
/// The table as text, with 95 % intervals over trials.
std::string table_text(const Table& table);
/// The table as JSON, with the numbers of runs and contacts.
nlohmann::ordered_json table_json(const Table& table);

}  // namespace inhabit::interact
