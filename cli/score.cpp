#include "score.h"

#include <memory>

#include "outputs.h"
#include "verbs.h"
#include "word_kind.h"

namespace {

using namespace inhabit;

struct ScoreVerb {
  CLI::App* verb;
  std::shared_ptr<Score> given;
};

/// @param rate frames a second to score at unless told otherwise; 0: it is not to be chosen
ScoreVerb add(CLI::App& verb, const char* name, const char* what, double rate, void (*run)(Score&)) {
  auto given = std::make_shared<Score>();
  given->rate = rate;
  CLI::App* score = verb.add_subcommand(name, what);
  score->add_option("--motion", given->motion, "Motion files to score, folders of them or patterns")->required();
  add_reading(*score, given->reading, "--motion and --truth");
  if (rate > 0)
    score->add_option("--rate", given->rate, "Frames a second to score at")->check(frame_rate)->capture_default_str();
  score->add_option("--json", given->json, "Also write the numbers, of each file too, as JSON");
  score->callback([given, run] {
    const torch::NoGradGuard no_gradients;
    if (!given->json.empty()) require_writable(given->json);
    run(*given);
    end_of(given->files);
  });
  return {score, given};
}

CLI::Option* add_reference(const ScoreVerb& score, const char* what) {
  CLI::Option* option = score.verb->add_option("--reference", score.given->reference, what);
  add_reading_of(*score.verb, score.given->reading_reference, "reference");
  return option;
}

CLI::Option* add_truth(const ScoreVerb& score, const char* what) {
  return score.verb->add_option("--truth", score.given->truth, what)->required();
}

}  // namespace

void add_score(CLI::App& app) {
  CLI::App* verb = app.add_subcommand(
      "score", "Measure any motion: FID, foot skating, jerk, penetration, diversity, NDMS, NPSS, APD, joint error");
  verb->require_subcommand(1);
  const auto ndms = add(*verb, "ndms", "Normalised directional motion similarity with real motion of the same kind", 25,
                        score_ndms_of);
  add_reference(ndms, "Real motion files that words are looked up in")->required();
  ndms.verb
      ->add_option("--observed", ndms.given->ndms.observed,
                   "Frames (at --rate) at the start of each motion that were observed")
      ->check(CLI::Range(0, 1000000));
  ndms.verb->add_option("--kappa", ndms.given->ndms.kappa, "Frames of a motion word")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  add_word_kind(*ndms.verb, ndms.given->ndms.words);
  add_truth(add(*verb, "npss", "Normalised power spectrum similarity with what came true", 25, score_npss_of),
            "What came true, a file for each motion");
  add(*verb, "apd", "Average pairwise distance of several futures of one observation", 25, score_apd_of);
  add_truth(add(*verb, "error",
                "Error of futures: of joints and root in the world, and of poses without place and heading; mean and "
                "best",
                25, score_error_of),
            "The future that came true, from its first frame on");
  add_reference(add(*verb, "fid", "Frechet distance of motion features from those of real motion", 0, score_fid_of),
                "Real motion files")
      ->required();
  const auto skating = add(*verb, "skating", "Fraction of frames in which a foot slides", 30, score_skating_of);
  add_scene(*skating.verb, skating.given->scene, " whose floor counts (default: the floor that the feet stand on)");
  add_reference(add(*verb, "jerk", "Jerk and acceleration of the joints, speed of the root", 30, score_jerk_of),
                "Real motion files: the ratio of the jerk to theirs is printed too");
  const auto penetration =
      add(*verb, "penetration", "How much of the body is inside a scene, and how deep", 30, score_penetration_of);
  add_scene(*penetration.verb, penetration.given->scene);
  add_reference(add(*verb, "diversity", "How far motions are apart, over motion features", 0, score_diversity_of),
                "Real motion files: their diversity is printed too");
}
