#include "inhabit/synth/chairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <map>
#include <set>

#include "cli/command.h"
#include "inhabit/body/capsules.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/math/heading.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"
#include "inhabit/synth/check.h"
#include "inhabit/synth/seated_legs.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

/// A data set of ten minutes, made once.
const Dataset& chairs() {
  static const TempFolder folder;
  static const Dataset made = [] {
    ChairsOptions options;
    options.minutes = 10;
    options.seed = 7;
    return generate_chairs(folder / "d", options);
  }();
  return made;
}

Interaction interaction_of(const DatasetClip& entry) { return parse_chair_source(entry.source).interaction; }

/// First frame whose action is `name`, or -1.
int64_t first_of(const Clip& clip, const std::string& name) {
  const auto action = clip.action.accessor<int64_t, 1>();
  for (int64_t t = 0; t < clip.frames(); ++t)
    if (clip.action_names[static_cast<size_t>(action[t])] == name) return t;
  return -1;
}

int64_t first_seated(const Clip& clip) {
  const auto contact = clip.contact.accessor<float, 2>();
  for (int64_t t = 0; t < clip.frames(); ++t)
    if (contact[t][0] > 0) return t;
  return -1;
}

/// `point` (3), world, in the chair's frame.
Eigen::Vector3d in_chair(const Clip& clip, const torch::Tensor& point) {
  const auto pose = clip.object_pose.accessor<float, 3>();
  const auto at = point.accessor<float, 1>();
  const Eigen::Vector3d rotation(pose[0][0][3], pose[0][0][4], pose[0][0][5]);
  Eigen::Vector3d away;
  for (int i = 0; i < 3; ++i) away[i] = at[i] - pose[0][0][i];
  return rotation.norm() < 1e-9 ? away
                                : Eigen::Vector3d(Eigen::AngleAxisd(-rotation.norm(), rotation.normalized()) * away);
}

/// The place of `frame`'s root in the chair's frame.
Eigen::Vector3d own_place(const Clip& clip, int64_t frame) { return in_chair(clip, clip.joints[frame][0]); }

// Table 4 of the COUCH paper, minutes of 209.7.
TEST(Chairs, MinutesAreDividedAsInTheCouchDataSet) {
  std::map<Interaction, double> frames;
  double all = 0;
  for (const DatasetClip& entry : chairs().clips) {
    frames[interaction_of(entry)] += static_cast<double>(entry.frames);
    all += static_cast<double>(entry.frames);
    EXPECT_GE(entry.frames, 12 * 30) << entry.file;
    EXPECT_LE(entry.frames, 24 * 30) << entry.file;
  }
  EXPECT_NEAR(all / 30 / 60, 10, 0.4);
  const double clip = 24.0 * 30 / all;  // what one clip more or less changes
  EXPECT_NEAR(frames[Interaction::right_hand] / all, 0.173, clip);
  EXPECT_NEAR(frames[Interaction::left_hand] / all, 0.140, clip);
  EXPECT_NEAR(frames[Interaction::both_hands] / all, 0.289, clip);
  EXPECT_NEAR(frames[Interaction::no_contact] / all, 0.174, clip);
  EXPECT_NEAR(frames[Interaction::free] / all, 0.152, clip);
  EXPECT_NEAR(frames[Interaction::locomotion] / all, 0.072, clip);
}

TEST(Chairs, EveryBarOfSynthCheckHolds) {
  for (const Bar& bar : check_motion(chairs()))
    EXPECT_TRUE(bar.pass()) << bar.name << " " << bar.value << " " << bar.unit << " in " << bar.worst_clip << " "
                            << bar.where;
}

TEST(Chairs, HandsOfTheTypeTouchTheChairAndNoOthers) {
  for (const DatasetClip& entry : chairs().clips) {
    const Clip clip = load_clip(chairs(), entry);
    const Interaction type = interaction_of(entry);
    const int64_t seated = first_seated(clip);
    ASSERT_EQ(seated < 0, type == Interaction::locomotion) << entry.file;
    const torch::Tensor touched = clip.hand_targets.select(2, 3) > 0;
    const bool left = touched.select(1, 0).any().item<bool>(), right = touched.select(1, 1).any().item<bool>();
    if (type == Interaction::free) continue;
    EXPECT_EQ(left, type == Interaction::left_hand || type == Interaction::both_hands) << entry.file;
    EXPECT_EQ(right, type == Interaction::right_hand || type == Interaction::both_hands) << entry.file;
    // When the pelvis comes down the hands are there, and they set out before.
    const int64_t down = first_of(clip, "sit_down");
    for (int side = 0; side < 2; ++side) {
      if (!(side == 0 ? left : right)) continue;
      EXPECT_TRUE(touched[seated][side].item<bool>()) << entry.file;
      const torch::Tensor point = clip.hand_targets[seated][side].slice(0, 0, 3);
      const auto distance = [&](int64_t t) { return (clip.joints[t][20 + side] - point).norm().item<double>(); };
      EXPECT_LT(distance(seated), 0.13) << entry.file;
      EXPECT_GT(distance(down), 0.2) << entry.file;
    }
  }
}

TEST(Chairs, ContactsLieOnTheChair) {
  int64_t contacts = 0;
  for (const DatasetClip& entry : chairs().clips) {
    const Clip clip = load_clip(chairs(), entry);
    ASSERT_EQ(clip.object_names.size(), 1U);
    Scene chair = load_scene(chairs(), entry.scene);
    std::erase_if(chair.meshes, [&](const Mesh& m) { return object_of_mesh(m.name) != clip.object_names[0]; });
    ASSERT_FALSE(chair.meshes.empty()) << clip.object_names[0];
    const torch::Tensor all = clip.hand_targets.view({-1, 4});
    const torch::Tensor points = all.index_select(0, (all.select(1, 3) > 0).nonzero().flatten()).slice(1, 0, 3);
    if (points.size(0) == 0) continue;
    contacts += points.size(0);
    EXPECT_LT(SceneQuery(chair).closest(points.contiguous()).distances.max().item<double>(), 0.01) << entry.file;
  }
  EXPECT_GT(contacts, 1000);
}

TEST(Chairs, AHandSetsOutBeforeThePersonSitsDown) {
  int64_t reaches = 0, early = 0;
  for (const DatasetClip& entry : chairs().clips) {
    const Clip clip = load_clip(chairs(), entry);
    const int64_t seated = first_seated(clip), down = first_of(clip, "sit_down");
    if (interaction_of(entry) != Interaction::both_hands) continue;
    // What the hand does against the pelvis in the 0.2 s before sitting down begins; at rest it would stay.
    for (int side = 0; side < 2; ++side) {
      const torch::Tensor hand = clip.joints.select(1, 20 + side) - clip.joints.select(1, 0);
      const torch::Tensor to = clip.hand_targets[seated][side].slice(0, 0, 3) - clip.joints[down][0];
      const double before = (hand[down - 6] - to).norm().item<double>(), then = (hand[down] - to).norm().item<double>();
      ++reaches;
      if (then < before - 0.001) ++early;
    }
  }
  EXPECT_GE(reaches, 10);
  EXPECT_GT(static_cast<double>(early), 0.7 * static_cast<double>(reaches));
}

// Free interactions: legs are stretched until they are all but straight, crossed at ankles and knees, hands go behind
// the head, and the pelvis shifts; never through the other leg.
TEST(Chairs, WhoSitsFreelyMovesTheLegsTheHandsAndTheSeat) {
  int straight = 0, crossed = 0, behind_head = 0, shifted = 0;
  const BodyModel& body = builtin_body();
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 random(seed);
    Room room;
    room.size = {13, 13};
    room.furniture.push_back(make_chair(random, 0.44));
    const ChairSubject subject = draw_subject(body, random);
    const ChairTake take{Interaction::free, 20, 0.4, 1.5};
    const auto clip = sit_on_chair(room, free_space(room), body, subject, take, random);
    ASSERT_TRUE(clip) << seed;
    const auto p = clip->joints.accessor<float, 3>();
    const auto at = [&](int64_t t, int j) { return Eigen::Vector3d(p[t][j][0], p[t][j][1], p[t][j][2]); };
    const double leg = subject.figure->thigh + subject.figure->shank;
    bool is_straight = false, is_crossed = false, hands_up = false;
    Eigen::AlignedBox3d seat;
    for (int64_t t = 0; t < clip->frames(); ++t) {
      if (clip->contact[t][0].item<float>() < 0.5F) continue;
      seat.extend(at(t, 0));
      const Eigen::Vector3d left = (at(t, 1) - at(t, 2)).normalized();
      is_crossed = is_crossed || (at(t, 7) - at(t, 8)).dot(left) < -0.03;
      for (int side = 0; side < 2; ++side)
        is_straight = is_straight || (at(t, 1 + side) - at(t, 7 + side)).norm() > 0.86 * leg;
      hands_up = hands_up || (at(t, 20).y() > at(t, 12).y() && at(t, 21).y() > at(t, 12).y());
    }
    straight += is_straight;
    crossed += is_crossed;
    behind_head += hands_up;
    shifted += seat.sizes().head<3>().norm() > 0.02;
  }
  EXPECT_GE(straight, 3);
  EXPECT_GE(crossed, 1);
  EXPECT_GE(behind_head, 1);
  EXPECT_GE(shifted, 3);
}

TEST(SeatedLegs, CrossedLegsGoAroundEachOther) {
  std::mt19937_64 random(5);
  const ChairSubject subject = draw_subject(builtin_body(), random);
  const std::vector<Capsule> capsules = shaped_capsules(builtin_body(), subject.betas);
  const Figure& figure = *subject.figure;
  SeatStay stay;
  stay.root = {0.3, 0.44 + figure.seat_depth, -0.2};
  const SeatedLegs legs{figure, stay, 0.7, 0, 4};
  Controls c;
  c.root = stay.root;
  c.yaw = 0.7;
  c.tilt = -0.13;
  for (int side = 0; side < 2; ++side) {  // feet below the knees
    FootControl& foot = c.foot[static_cast<size_t>(side)];
    foot.yaw = 0.7;
    const Eigen::Vector3d ahead = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()) * Eigen::Vector3d(0, 0, 1);
    foot.ball = hip_position(figure, side, c) + ahead * (figure.thigh + figure.bones.offsets[10 + side].z());
    foot.ball.y() = figure.ball_height;
  }
  EXPECT_EQ(legs_in_each_other(capsules, pose_figure(figure, c)), 0);
  for (int over = 0; over < 2; ++over)
    for (const auto& moves : {legs.ankles_crossed(over, random), legs.legs_crossed(over, random)})
      for (double t = 0; t < 4; t += 1.0 / 30) {
        Controls now = c;
        for (const LegMove& move : moves)
          if (const double w = move.when.at(t); w > 0)
            move_leg(figure, move, w, now.foot[static_cast<size_t>(move.side)]);
        const Posed pose = pose_figure(figure, now);
        EXPECT_LT(legs_in_each_other(capsules, pose), 0.045) << over << " " << moves.size() << " " << t;
        if (t < 1.9 || t > 2.1) continue;
        // There: the feet have changed sides.
        const Eigen::Vector3d left = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()) * Eigen::Vector3d(1, 0, 0);
        EXPECT_LT((pose.position[7] - pose.position[8]).dot(left), -0.01) << over << " " << moves.size();
      }
}

TEST(Chairs, StartsLieAllAroundAndNobodyWalksThroughTheChair) {
  std::set<int> quarters;
  int behind = 0;
  for (const DatasetClip& entry : chairs().clips) {
    const Clip clip = load_clip(chairs(), entry);
    const Eigen::Vector3d start = own_place(clip, 0);
    const double distance = on_ground(start).norm(), direction = heading_of(on_ground(start));
    EXPECT_GT(distance, 0.8) << entry.file;
    EXPECT_LT(distance, 6.1) << entry.file;
    quarters.insert(static_cast<int>(std::floor(direction / (M_PI / 2))));
    const int64_t seated = first_seated(clip);
    if (seated < 0 || std::abs(direction) < 2.3) continue;
    // Who starts behind comes round a side: where the path crosses the chair's middle line, it does so beside the
    // chair.
    ++behind;
    double beside = 0;
    for (int64_t t = 0; t < seated; ++t) {
      const Eigen::Vector3d at = own_place(clip, t);
      if (std::abs(at.z()) < 0.15) beside = std::max(beside, std::abs(at.x()));
    }
    EXPECT_GT(beside, 0.4) << entry.file;
  }
  EXPECT_EQ(quarters.size(), 4U);
  EXPECT_GE(behind, 3);
}

TEST(Chairs, ChairsDifferAndAreInOneSplitOnly) {
  std::map<std::string, int> splits;
  for (int64_t i = 0; i < 240; ++i) ++splits[split_of_chair(i)];
  EXPECT_EQ(splits["test"], 40);
  EXPECT_EQ(splits["val"], 20);
  std::set<std::string> kinds;
  std::set<double> heights;
  for (uint64_t i = 0; i < 60; ++i) {
    std::mt19937_64 random(i);
    const Room room = make_chair_room(random);
    const Furniture& chair = room.furniture.front();
    kinds.insert(chair.kind);
    const auto seat = std::find_if(chair.surfaces.begin(), chair.surfaces.end(), [](const Surface& s) {
      return s.kind == Surface::Kind::seat || s.kind == Surface::Kind::bed;
    });
    ASSERT_NE(seat, chair.surfaces.end());
    EXPECT_GE(seat->center.y(), chair.kind == "sofa" ? 0.33 : chair.kind == "bed" ? 0.36 : 0.38);
    EXPECT_LE(seat->center.y(), 0.55);
    heights.insert(seat->center.y());
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"chair", "armchair", "stool", "sofa", "bed", "office_chair", "solid_chair"}));
  EXPECT_EQ(heights.size(), 60U);
  std::map<std::string, std::string> split_of_scene;
  for (const DatasetClip& entry : chairs().clips) {
    EXPECT_EQ(split_of_scene.emplace(entry.scene, entry.split).first->second, entry.split);
    EXPECT_EQ(entry.split, split_of_chair(parse_chair_source(entry.source).chair));
  }
}

// Where somebody sits on a bed is an open choice; a network that has seen its middle alone misses other places.
TEST(Chairs, KindsMayBeChosenAndBedsAreSatOnAllAlongTheirSides) {
  const TempFolder folder;
  ChairsOptions options;
  options.minutes = 6;
  options.kinds = {"bed", "stool"};
  const Dataset made = generate_chairs(folder / "d", options);
  std::set<std::string> kinds;
  double least = 0, most = 0;
  for (const DatasetClip& entry : made.clips) {
    const Clip clip = load_clip(made, entry);
    const std::string kind = clip.object_names.front().substr(0, clip.object_names.front().rfind('_'));
    kinds.insert(kind);
    const int64_t seated = first_seated(clip);
    if (kind != "bed" || seated < 0) continue;
    // Beds stand along their z axis; the pillow is at its negative end.
    const double along = own_place(clip, seated).z();
    least = std::min(least, along);
    most = std::max(most, along);
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"bed", "stool"}));
  EXPECT_GT(most - least, 0.45);
  options.kinds = {"throne"};
  EXPECT_THAT([&] { generate_chairs(folder / "e", options); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("throne: is no kind of chair; there are chair, arm")));
}

// Both hands on the back rest is rare among people, and a network that has seldom seen it does not sit down.
TEST(Chairs, PartsThatHandsTakeHoldOfMayBeChosen) {
  const TempFolder folder;
  ChairsOptions options;
  options.minutes = 4;
  options.kinds = {"chair"};
  options.parts = {"back"};
  const Dataset made = generate_chairs(folder / "d", options);
  int64_t contacts = 0;
  for (const DatasetClip& entry : made.clips) {
    const Clip clip = load_clip(made, entry);
    const torch::Tensor all = clip.hand_targets.view({-1, 4});
    const torch::Tensor points = all.index_select(0, (all.select(1, 3) > 0).nonzero().flatten()).slice(1, 0, 3);
    contacts += points.size(0);
    // Who sits has arm rests, front and sides of the seat beside or before them, and the back rest behind.
    for (int64_t i = 0; i < points.size(0); ++i)
      EXPECT_LT(in_chair(clip, points[i]).z(), own_place(clip, first_seated(clip)).z()) << entry.file;
  }
  EXPECT_GT(contacts, 500);
  options.parts = {"wheel"};
  EXPECT_THAT(
      [&] { generate_chairs(folder / "e", options); },
      testing::ThrowsMessage<Error>(testing::HasSubstr("wheel: is no part of a seat; there are armrest, front")));
}

// Networks learn how people stand from those who stand for more than a moment, and move meanwhile.
TEST(Chairs, HalfOfThePeopleLingerWhereThatIsAskedFor) {
  const TempFolder folder;
  ChairsOptions options;
  options.minutes = 4;
  options.linger = 6;
  const Dataset made = generate_chairs(folder / "d", options);
  int before = 0, after = 0;
  for (const DatasetClip& entry : made.clips) {
    const Clip clip = load_clip(made, entry);
    const std::set<std::string> standing = {"stand", "gesture"};
    const auto stands = [&](int64_t t) {
      return standing.contains(clip.action_names[static_cast<size_t>(clip.action.data_ptr<int64_t>()[t])]);
    };
    int64_t first = 0, last = clip.frames();
    while (first < clip.frames() && stands(first)) ++first;
    while (last > 0 && stands(last - 1)) --last;
    if (first > 1.7 * clip.rate) ++before;
    if (clip.frames() - last > 3 * clip.rate) ++after;
    const torch::Tensor head = clip.joints.select(1, 15).slice(0, 0, std::max<int64_t>(first, 1));
    if (first > 4 * clip.rate) {
      EXPECT_GT((head - head.mean(0)).norm(2, 1).max().item<double>(), 0.01) << entry.file << ": like a statue";
    }
  }
  const auto clips = static_cast<double>(made.clips.size());
  EXPECT_GT(before / clips, 0.25);
  EXPECT_LT(before / clips, 0.7);
  EXPECT_GT(after / clips, 0.1);
  options.linger = -1;
  EXPECT_THAT([&] { generate_chairs(folder / "e", options); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("linger")));
}

TEST(Chairs, SubjectsAreTheSamePeopleInAllTheirClips) {
  std::map<int, torch::Tensor> shape;
  for (const DatasetClip& entry : chairs().clips) {
    const Clip clip = load_clip(chairs(), entry);
    const auto& seen = shape.emplace(parse_chair_source(entry.source).subject, clip.betas).first->second;
    EXPECT_TRUE(torch::equal(seen, clip.betas)) << entry.file;
  }
  EXPECT_EQ(shape.size(), 6U);
  for (const auto& [a, betas] : shape)
    for (const auto& [b, others] : shape)
      if (a < b) {
        EXPECT_GT((betas - others).abs().max().item<double>(), 0.1);
      }
}

TEST(Chairs, BytesDependOnTheSeedAndNotOnThreadsOrShards) {
  const TempFolder folder;
  ChairsOptions options;
  options.minutes = 1;
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const Dataset one = generate_chairs(folder / "one", options);
  omp_set_num_threads(3);
  generate_chairs(folder / "three", options);
  for (const int64_t number : {2, 1}) {
    options.shard = {number, 2};
    EXPECT_EQ(generate_chairs(folder / "parts", options).whole, number == 1);
  }
  options.shard = {};
  options.seed = 2;
  generate_chairs(folder / "other", options);
  omp_set_num_threads(threads);
  std::vector<std::string> files = {"dataset.json"};
  for (const DatasetClip& entry : one.clips) files.insert(files.end(), {entry.file, entry.scene});
  for (const char* same : {"three/", "parts/"})
    for (const std::string& file : files)
      EXPECT_TRUE(read_whole_file(folder / "one/" + file) == read_whole_file(folder / same + file)) << same << file;
  EXPECT_FALSE(read_whole_file(folder / "one/clips/000000.npz") == read_whole_file(folder / "other/clips/000000.npz"));
}

TEST(Chairs, SourcesAreReadBack) {
  const ChairSource source{2, Interaction::both_hands, 17};
  EXPECT_EQ(source_text(source), "subject_2/both_hands/chair_000017");
  const ChairSource again = parse_chair_source(source_text(source));
  EXPECT_EQ(again.subject, 2);
  EXPECT_EQ(again.interaction, Interaction::both_hands);
  EXPECT_EQ(again.chair, 17);
  for (const char* text : {"", "subject_2", "subject_2/left_hand", "subject_x/left_hand/chair_1",
                           "subject_1/two_feet/chair_1", "subject_1/left_hand/table_1"})
    EXPECT_THROW(parse_chair_source(text), Error) << text;
}

TEST(SynthCommand, MakesChairsAndRefusesNonsense) {
  const TempFolder folder;
  const CommandResult made = run_command("synth chairs --out " + (folder / "d") + " --minutes 0.4 --seed 3");
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, ::testing::HasSubstr("2 clips"));
  for (const char* wrong : {"--minutes 0", "--minutes -3", "--minutes nan", "--subjects 0", "--chairs 0",
                            "--minutes much", "--linger 61"}) {
    const CommandResult refused = run_command("synth chairs --out " + (folder / "e") + " " + wrong);
    EXPECT_NE(refused.exit_code, 0) << wrong;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << wrong << ": " << refused.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "e"));
}

}  // namespace
}  // namespace inhabit
