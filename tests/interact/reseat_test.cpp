#include "inhabit/interact/reseat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include "cli/command.h"
#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/interact/chair_pair.h"
#include "inhabit/interact/reseat_set.h"
#include "inhabit/interact/seated.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/math/rotation.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"
#include "inhabit/synth/chairs.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;

/// Somebody who sits down on a straight chair with both hands at it.
struct SitOnChair {
  Room room;
  Clip clip;
};
const SitOnChair& sit() {
  static const SitOnChair made = [] {
    std::mt19937_64 random(4);
    SitOnChair out;
    out.room.size = {13, 13};
    out.room.furniture.push_back(make_chair(random, 0.44));
    const ChairSubject subject = draw_subject(builtin_body(), random);
    const ChairTake take{Interaction::both_hands, 13, 0.4, 2};
    auto clip = sit_on_chair(out.room, free_space(out.room), builtin_body(), subject, take, random);
    if (!clip) throw Error("test", "no clip was made");
    out.clip = std::move(*clip);
    return out;
  }();
  return made;
}

/// The chair of sit(), stretched.
Scene stretched(double x, double y, double z) {
  Room room;
  room.furniture.push_back(sit().room.furniture.front());
  room.furniture.front().rescale({x, y, z});
  return room.scene();
}

TEST(Reseat, PlacesGoWhereTheyLieAlike) {
  const SeatExtent from{0.2, -0.2, 0.25, -0.25}, to{0.2, -0.3, 0.2, -0.2};
  const auto carried = [&](const Vector3d& p, const Correspondence& how) {
    return corresponding(p, from, 0.4, to, 0.5, how);
  };
  EXPECT_LT((carried({0.2, 0.4, 0.1}, {}) - Vector3d(0.2, 0.5, 0.1)).norm(), 1e-12);  // from the person
  // An arm rest, beside and above; a back rest; below, behind.
  EXPECT_LT((carried({-0.31, 0.6, 0}, {true, false}) - Vector3d(-0.26, 0.7, 0)).norm(), 1e-12);
  EXPECT_LT((carried({0.24, 0.7, -0.21}, {true, true}) - Vector3d(0.19, 0.8, -0.31)).norm(), 1e-12);
  EXPECT_LT((carried({0, 0.2, -0.3}, {false, true}) - Vector3d(0, 0.25, -0.4)).norm(), 1e-12);
}

TEST(Reseat, TheSeatIsMeasuredAndTheNewOneStandsInItsPlace) {
  const Scene scene = stretched(1, 1, 1);
  const SeatExtent extent = seat_extent(find_chair(scene, "chair_0"));
  const Surface& seat = sit().room.furniture.front().surfaces.front();
  EXPECT_NEAR(extent.front - extent.rear, 2 * seat.half_depth, 0.04);
  EXPECT_NEAR(extent.left - extent.right, 2 * seat.half_width + 0.04, 0.04);  // the level part leaves 2 cm at each side
  const Chair old = *chair_of(sit().clip, sit().room.scene());
  const ChairPair pair = pair_chairs(old, stretched(1.1, 1.12, 1.05), "chair_0");
  EXPECT_NEAR(pair.fresh_seat.front, pair.old_seat.front, 0.01);
  EXPECT_NEAR(pair.rise(), 0.12 * 0.44, 0.01);
  // At the same fraction of the width, which is a tenth more.
  EXPECT_NEAR(pair.fresh_seat.left, 1.1 * pair.old_seat.left, 0.01);
  EXPECT_NEAR(pair.fresh_seat.right, 1.1 * pair.old_seat.right, 0.01);
}

std::string figures(const ReseatFit& fit) {
  return fit.fault() + ": " + std::to_string(fit.hand_gap) + " " + std::to_string(fit.pelvis_gap) + " " +
         std::to_string(fit.depth) + " " + std::to_string(fit.elsewhere) + " " + std::to_string(fit.slide) + " " +
         std::to_string(fit.beyond);
}

/// The new chair alone, as it stands in a scene.
Scene chair_in(const Scene& scene) {
  Scene out = scene;
  std::erase_if(out.meshes, [](const Mesh& mesh) { return object_of_mesh(mesh.name) != "chair_0"; });
  return out;
}

/// The bars, measured here from the skin and the surface alone.
void expect_fits(const Reseated& found) {
  EXPECT_EQ(found.fit.fault(), "") << figures(found.fit);
  const SceneQuery surface(chair_in(found.scene));
  const Clip& clip = found.clip;
  for (int64_t t = 0; t < clip.frames(); t += 3) {
    const torch::Tensor places =
        skin(builtin_body(), clip.betas, axis_angle_to_matrix(clip.rotations[t]), clip.trans[t]);
    const double least = surface.signed_distance(places.contiguous()).min().item<double>();
    EXPECT_GT(least, -0.02) << t;
    const bool seated = clip.contact[t][0].item<float>() > 0.5F;
    EXPECT_LT(least, seated ? 0.01 : 1e9) << t;
  }
  const HandContact hands = hand_contact(clip, builtin_body(), found.scene);
  EXPECT_GT(hands.contacts, 10);
  EXPECT_LT(hands.target_gap, 0.001);
  EXPECT_LT(hands.hand_gap, 0.01);
  for (const int64_t joint : {7, 8, 10, 11}) {
    const torch::Tensor down = sit().clip.contact.select(1, joint) > 0;
    const torch::Tensor moved = (clip.joints - sit().clip.joints).select(1, joint).norm(2, -1);
    EXPECT_LT(moved.masked_select(down).max().item<double>(), 0.01);
  }
}

TEST(Reseat, OnTheSameChairHardlyAnythingChanges) {
  const Reseated same = reseat(sit().clip, sit().room.scene(), stretched(1, 1, 1), "chair_0");
  expect_fits(same);
  EXPECT_EQ(same.lost, 0);
  EXPECT_LT((same.clip.joints - sit().clip.joints).norm(2, -1).mean().item<double>(), 0.008);
}

TEST(Reseat, HandsPelvisAndFeetMeetAHigherBroaderChair) {
  const Reseated found = reseat(sit().clip, sit().room.scene(), stretched(1.1, 1.12, 1.05), "chair_0");
  expect_fits(found);
  EXPECT_EQ(found.lost, 0);
  EXPECT_GE(found.contacts, 2);
  // The pelvis is as much higher than on a chair like the old one as the seat is.
  const Reseated same = reseat(sit().clip, sit().room.scene(), stretched(1, 1, 1), "chair_0");
  const Stay stay = stays_of(sit().clip).front();
  const auto height = [&](const Clip& clip) { return clip.joints[(stay.first + stay.last) / 2][0][1].item<double>(); };
  EXPECT_NEAR(height(found.clip) - height(same.clip), 0.12 * 0.44, 0.008);
  // The path there is as it was, bit by bit.
  const int64_t before = stay.down - 60;
  ASSERT_GT(before, 0);
  EXPECT_TRUE(torch::equal(found.clip.rotations.slice(0, 0, before), sit().clip.rotations.slice(0, 0, before)));
}

TEST(Reseat, ALowerNarrowerChairAndFramesEachOnTheirOwn) {
  const Scene chair = stretched(0.94, 0.92, 0.95);
  expect_fits(reseat(sit().clip, sit().room.scene(), chair, "chair_0"));
  const Reseated alone = reseat(sit().clip, sit().room.scene(), chair, "chair_0", {true, true});
  EXPECT_LT(alone.fit.hand_gap, 0.01);
  // A frame alone gives what it gives among others.
  const int64_t t = stays_of(sit().clip).front().first + 20;
  const Reseated cut =
      reseat(slice(sit().clip, t - 30, sit().clip.frames()), sit().room.scene(), chair, "chair_0", {true, true});
  EXPECT_LT((cut.clip.joints[30 + 20] - alone.clip.joints[t + 20]).norm(2, -1).max().item<double>(), 0.02);
}

TEST(Reseat, ChairsAndClipsThatDoNotFitAreRefused) {
  EXPECT_THROW(reseat(sit().clip, sit().room.scene(), stretched(1, 1, 1), "sofa_0"), Error);
  EXPECT_THROW(reseat(sit().clip, sit().room.scene(), stretched(1, 2.5, 1), "chair_0"), Error);
  EXPECT_THROW(reseat(slice(sit().clip, 0, 30), sit().room.scene(), stretched(1, 1, 1), "chair_0"), Error);
  // A chair so high that feet do not reach the floor is no fit, and said to be none.
  EXPECT_NE(reseat(sit().clip, sit().room.scene(), stretched(1, 1.6, 1), "chair_0").fit.fault(), "");
}

TEST(ReseatCommand, MakesADataSetWhoseBytesDependOnTheSeedAlone) {
  const TempFolder folder;
  ChairsOptions chairs;
  chairs.minutes = 0.7;
  generate_chairs(folder / "chairs", chairs);
  ReseatOptions options;
  options.split = "all";
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const ReseatResult one = reseat_dataset(folder / "chairs", folder / "one", options);
  omp_set_num_threads(2);
  reseat_dataset(folder / "chairs", folder / "two", options);
  omp_set_num_threads(threads);
  ASSERT_FALSE(one.dataset.clips.empty());
  for (const DatasetClip& entry : one.dataset.clips)
    for (const std::string& file : {entry.file, entry.scene})
      EXPECT_TRUE(read_whole_file(folder / "one/" + file) == read_whole_file(folder / "two/" + file)) << file;
  const CommandResult refused =
      run_command("synth reseat --data " + (folder / "chairs") + " --chairs /nowhere.glb --out " + (folder / "e"));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
}

}  // namespace
}  // namespace inhabit::interact
