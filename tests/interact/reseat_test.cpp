#include "inhabit/interact/reseat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include "cli/command.h"
#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/interact/reseat_set.h"
#include "inhabit/interact/seated.h"
#include "inhabit/io/atomic_file.h"
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
  const SeatExtent from{0.2, -0.2, 0.25, -0.25}, to{0.3, -0.2, 0.2, -0.2};
  const auto carried = [&](const Vector3d& p) { return corresponding(p, from, 0.4, to, 0.5); };
  EXPECT_LT((carried({0.25, 0.4, 0.2}) - Vector3d(0.2, 0.5, 0.3)).norm(), 1e-12);    // corner to corner
  EXPECT_LT((carried({0, 0.4, 0}) - Vector3d(0, 0.5, 0.05)).norm(), 1e-12);          // middle to middle
  EXPECT_LT((carried({-0.31, 0.6, 0}) - Vector3d(-0.26, 0.7, 0.05)).norm(), 1e-12);  // an arm rest, beside and above
  EXPECT_LT((carried({0, 0.2, -0.3}) - Vector3d(0, 0.25, -0.3)).norm(), 1e-12);      // below, behind
}

TEST(Reseat, TheSeatIsMeasured) {
  const Scene scene = stretched(1, 1, 1);
  const Chair chair = find_chair(scene, "chair_0");
  const SeatExtent extent = seat_extent(chair);
  const Surface& seat = sit().room.furniture.front().surfaces.front();
  EXPECT_NEAR(extent.front - extent.rear, 2 * seat.half_depth, 0.04);
  EXPECT_NEAR(extent.left - extent.right, 2 * seat.half_width + 0.04, 0.04);  // the level part leaves 2 cm at each side
}

TEST(Reseat, OnTheSameChairHardlyAnythingChanges) {
  const Reseated same = reseat(sit().clip, sit().room.scene(), stretched(1, 1, 1), "chair_0");
  EXPECT_TRUE(same.good()) << same.hand_gap << " " << same.pelvis_gap << " " << same.depth << " " << same.slide;
  EXPECT_EQ(same.lost, 0);
  EXPECT_LT((same.clip.joints - sit().clip.joints).norm(2, -1).mean().item<double>(), 0.006);
}

TEST(Reseat, HandsPelvisAndFeetMeetAHigherBroaderChair) {
  const Scene chair = stretched(1.1, 1.12, 1.05);
  const Reseated found = reseat(sit().clip, sit().room.scene(), chair, "chair_0");
  EXPECT_TRUE(found.good()) << found.hand_gap << " " << found.pelvis_gap << " " << found.depth << " " << found.slide;
  EXPECT_GE(found.contacts, 2);
  // The pelvis is as much higher as the seat.
  const Stay stay = stays_of(sit().clip).front();
  const auto height = [&](const Clip& clip) { return clip.joints[(stay.first + stay.last) / 2][0][1].item<double>(); };
  EXPECT_NEAR(height(found.clip) - height(sit().clip), 0.12 * 0.44, 0.008);
  // Touched points lie on the new chair.
  const Scene alone = [&] {
    Scene out = found.scene;
    std::erase_if(out.meshes, [](const Mesh& mesh) { return object_of_mesh(mesh.name) != "chair_0"; });
    return out;
  }();
  const torch::Tensor all = found.clip.hand_targets.view({-1, 4});
  const torch::Tensor points = all.index_select(0, (all.select(1, 3) > 0).nonzero().flatten()).slice(1, 0, 3);
  ASSERT_GT(points.size(0), 10);
  EXPECT_LT(SceneQuery(alone).closest(points.contiguous()).distances.max().item<double>(), 0.001);
  // Feet that stand stay; the way there is as it was, bit by bit.
  for (const int64_t joint : {7, 8, 10, 11}) {
    const torch::Tensor down = sit().clip.contact.select(1, joint) > 0;
    const torch::Tensor moved = (found.clip.joints - sit().clip.joints).select(1, joint).norm(2, -1);
    EXPECT_LT(moved.masked_select(down).max().item<double>(), 0.01);
  }
  const int64_t before = stay.down - 40;
  ASSERT_GT(before, 0);
  EXPECT_TRUE(torch::equal(found.clip.rotations.slice(0, 0, before), sit().clip.rotations.slice(0, 0, before)));
}

TEST(Reseat, ChairsAndClipsThatDoNotFitAreRefused) {
  EXPECT_THROW(reseat(sit().clip, sit().room.scene(), stretched(1, 1, 1), "sofa_0"), Error);
  EXPECT_THROW(reseat(sit().clip, sit().room.scene(), stretched(1, 2.5, 1), "chair_0"), Error);
  EXPECT_THROW(reseat(slice(sit().clip, 0, 30), sit().room.scene(), stretched(1, 1, 1), "chair_0"), Error);
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
