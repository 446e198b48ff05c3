#pragma once
#include <torch/types.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// Something about every frame of a clip, shown as a strip under the timeline: a curve, or stretches with names.
struct PageTrack {
  std::string name;                     ///< beside the strip
  torch::Tensor values = {};            ///< (T) in [0, 1]; or undefined, and then
  torch::Tensor labels = {};            ///< (T) int64 into `names`, negative where there is nothing
  std::vector<std::string> names = {};  ///< of labels
};

/// One person on a page. A clip with rotations on the standard 22 joints (more may follow them) is shown as a skinned
/// body, any other as its skeleton.
struct PagePerson {
  /// Colours: warm, grey, orange, blue. `future`: one of many, a small figure in a hue about blue; `intention`: a small
  /// figure in its label's colour that starts over at its end. `filled`: purple, and blue at its key frames.
  enum class Role { motion, past, truth, prediction, future, intention, filled };
  Clip clip;                        ///< the motion
  std::string name;                 ///< in the legend
  Role role = Role::motion;         ///< how the person looks
  double start_seconds = 0;         ///< when the clip's first frame is shown
  const BodyModel* body = nullptr;  ///< nullptr: the built-in body. Must outlive the page.
  torch::Tensor labels = {};        ///< (T) int64 intention of every frame, 0 or more; undefined where it is not known
  std::vector<int64_t> keys = {};   ///< frames that were given: shown blue, and all along as still blue copies
  std::optional<Clip> given = {};   ///< poses of the keys, a frame each, where they are not the clip's own
  std::vector<int64_t> given_joints = {};  ///< joints that keys between the first and the last give; empty: all
  torch::Tensor collides = {};             ///< (T) bool, shown red: the body is inside the scene; undefined: not known
  std::vector<std::string> collides_with = {};  ///< "66 mm in table", of each stretch of `collides`; empty: not known
  std::vector<PageTrack> tracks = {};           ///< shown of the first person that has any
  bool joints_alone = false;                    ///< no skin: what small figures need, `future` and `intention` anyway
};

/// Intention labels of recordings, one strip each on a time axis of their own.
struct PageRecordings {
  /// One recording.
  struct Row {
    std::string name;                                 ///< beside the strip
    std::string group;                                ///< rows of one group stand together
    torch::Tensor labels;                             ///< (T) int64, 0 or more
    std::vector<std::pair<int64_t, int64_t>> marked;  ///< outlined stretches, frames [first, last)
  };
  std::vector<Row> rows;  ///< from top to bottom
  double rate = 25;       ///< frames a second
};

/// Contact maps (Eq. 1) to be painted on the scene.
struct PageContacts {
  torch::Tensor points;            ///< (N, 3) metres
  torch::Tensor maps;              ///< (T, J, N) in [0, 1], 1 where the joint touches the point
  std::vector<std::string> names;  ///< J names; empty: the standard joints' names
  double rate = 30;                ///< frames a second
  double start_seconds = 0;        ///< time of the first map
};

/// What a page shows.
struct Page {
  std::string title;                         ///< plain text, as is `note`: a short caption below the title
  std::string note;                          ///< may be empty
  std::vector<PagePerson> people;            ///< may be empty where there is a scene
  const Scene* scene = nullptr;              ///< nullptr: an empty ground with a grid
  std::optional<PageContacts> contacts;      ///< painted on the scene
  std::optional<PageRecordings> recordings;  ///< strips of intention labels
};

/// Writes one HTML file that needs no other file and no network: a three.js view with orbit camera, timeline, bodies or
/// skeletons, the scene, root paths and footprints, and contact maps. Many futures (or motions of intentions) are small
/// figures side by side or in one place, with a strip of labels under the timeline. Objects that Clip::object_pose
/// moves go along, from where the scene has them, which is where they are in the first frame. Positions are kept to
/// 1/65535 of their extent, rotations to 1/32767; scenes beyond 200,000 triangles or 60,000 points are thinned. Throws
/// Error(path,
/// ...) where a clip, the scene or the contacts are inconsistent or not finite, or the file cannot be written; an older
/// file of that name then stays as it was.
void write_page(const std::string& path, const Page& page);

/// The same as text, in another template of viewer/: its marks are replaced by title and data. @param path named in
/// errors
std::string page_text(const Page& page, const std::string& path, std::string_view page_template);

}  // namespace inhabit
