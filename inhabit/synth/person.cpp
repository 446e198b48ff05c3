#include "inhabit/synth/person.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/life.h"

namespace inhabit {
namespace {

constexpr int kTries = 48, kNextTries = 10;
constexpr double kChapter = 12;  // seconds
constexpr int kChapterFrames = static_cast<int>(kChapter * kSynthRate);

/// Draws lives in one room until one is without a fault.
class LifeSampler {
 public:
  LifeSampler(const Room& room, const BodyModel& body, std::mt19937_64& random)
      : room_(room), body_(body), floor_(free_space(room)), random_(random) {}

  /// The first chapter of a clip of `frames`. @param seconds of the clip.
  Life first_chapter(double seconds, int frames) {
    const auto draw = [&] {
      const torch::Tensor betas = draw_betas(body_, random_);
      const auto figure = std::make_shared<const Figure>(make_figure(body_, betas));
      const double from = uniform(random_, 0.0, 3.0);
      LifePlan plan = plan_life(room_, floor_, *figure, from + std::min(seconds, kChapter), random_);
      return Life{betas, figure, std::move(plan), from, random_};
    };
    return draw_faultless(kTries, draw, [&](const Life& life) {
      const int last = frames > kChapterFrames ? life.planned() : frames;
      const Performance performance = perform(*life.figure, life.plan, life.from, last, kSynthRate, random_);
      return faults_of(room_, body_, life, performance);
    });
  }

  /// A life with one chapter more than its first `done` frames. @param least its faults.
  Life next_chapter(const Life& before, int done, double& least) {
    const auto draw = [&] {
      Life life = before;
      extend_life(life.plan, room_, floor_, *life.figure, life.from + (done + kChapterFrames) / kSynthRate, random_);
      return life;
    };
    const auto faults = [&](const Life& life) {
      return faults_of(room_, body_, life, life.performed(done - kChapterFrames / 4, life.planned()));
    };
    return draw_faultless(kNextTries, draw, faults, &least);
  }

 private:
  const Room& room_;
  const BodyModel& body_;
  const FreeSpace floor_;
  std::mt19937_64& random_;
};

}  // namespace

Clip live(const Room& room, const BodyModel& body, std::mt19937_64& random, const LifeOptions& options) {
  if (!(options.seconds > 0) || options.seconds > 3600) throw Error("seconds", "a clip lasts between 0 and 3600 s");
  const torch::NoGradGuard no_gradient;
  const int frames = std::max(1, static_cast<int>(std::lround(options.seconds * kSynthRate)));
  LifeSampler lives(room, body, random);
  // A long life goes on chapter by chapter: the longer it is, the less likely is one without a fault at once. Where the
  // next cannot be without one (somebody stands too close to a shelf to walk away), the one before is drawn again.
  std::vector<Life> chapters{lives.first_chapter(options.seconds, frames)};
  for (int back = 0; static_cast<int>(chapters.size()) * kChapterFrames < frames;) {
    double least = 0;
    Life next = lives.next_chapter(chapters.back(), static_cast<int>(chapters.size()) * kChapterFrames, least);
    if (least == 0 || ++back > kTries) {
      chapters.push_back(std::move(next));
    } else {
      chapters.pop_back();
      if (chapters.empty()) chapters.push_back(lives.first_chapter(options.seconds, frames));
    }
  }
  const Life& life = chapters.back();
  return clip_of(room, body, life.betas, life.performed(0, frames), life.plan.used);
}

}  // namespace inhabit
