#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "inhabit/view/page.h"

// Pieces of a page's data, as viewer/src/data.ts reads them. For the sources of this folder.
namespace inhabit {

/// A tensor detached, on the CPU, contiguous and of this type.
torch::Tensor plain(const torch::Tensor& t, torch::ScalarType type = torch::kFloat32);

/// Throws Error(path, ...) that names `what` where a number is not finite.
void require_finite(const torch::Tensor& t, const std::string& path, const std::string& what);

/// The arrays of a page, one after the other, each described in the header by place, count, type and dequantisation
/// value = min + scale * stored (per axis where they are lists).
struct PageBlob {
  std::string bytes;  ///< the arrays, each from a multiple of four on

  /// Numbers as they are. @param type what the page calls theirs
  template <typename T>
  nlohmann::json add(const std::vector<T>& values, const char* type) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    const nlohmann::json ref = {{"at", bytes.size()}, {"count", values.size()}, {"type", type}};
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return ref;
  }
  /// As float32.
  nlohmann::json add_floats(const torch::Tensor& t);
  /// (..., 3) as 16-bit steps of the bounding box.
  nlohmann::json add_positions(const torch::Tensor& t);
  /// (T, J, 3) to a millimetre, within 4 km, for what must be small: changes from frame to frame, joints after the
  /// first as seen from it, as (J, 3, T) 24-bit numbers, first their low bytes, then the middle and the high ones.
  nlohmann::json add_motion(const torch::Tensor& joints);
  /// Numbers in [-1, 1] as signed 16-bit.
  nlohmann::json add_units(const torch::Tensor& t);
  /// Whole numbers from 0 to below `bound`, as uint16 or uint32.
  nlohmann::json add_indices(const torch::Tensor& t, int64_t bound);
};

/// Body meshes of the page; people of one shape share one.
struct PageBodies {
  nlohmann::json list = nlohmann::json::array();                  ///< of the meshes, as the header has them
  std::vector<std::pair<const BodyModel*, torch::Tensor>> known;  ///< model and betas of each

  /// Index of the mesh of `model` shaped by `betas` (may be undefined) with weights on the first `joints` joints only.
  int add(PageBlob& blob, const BodyModel& model, const torch::Tensor& betas, int joints);
};

/// Stretches of one label (T) int64: [first frame, label].
nlohmann::json label_spans(const torch::Tensor& labels);
/// Stretches of one intention, as label_spans has them. Throws Error(path, ...) where there are no labels or one is
/// negative.
nlohmann::json intention_spans(const torch::Tensor& labels, const std::string& path);

/// A person's motion, body, labels and keys in the header; arrays go to the blob, the shaped mesh to `bodies`. Throws
/// Error(path, ...) for a clip that is not valid and for labels, tracks or keys that do not fit its frames.
nlohmann::json describe_person(PageBlob& blob, PageBodies& bodies, const PagePerson& person, const std::string& path);

/// @param triangles, points beyond which meshes and clouds are thinned.
nlohmann::json describe_scene(PageBlob& blob, const Scene& scene, const std::string& path, int64_t triangles,
                              int64_t points);

/// Contact maps (T, J, N) of scene points at 15 maps a second, without the pairs of joint and point that hardly touch.
/// Throws Error(path, ...) where maps, names and points do not agree or a number is not finite.
nlohmann::json describe_contacts(PageBlob& blob, const PageContacts& contacts, const std::string& path);

/// The page: a header and its arrays in a template of viewer/, whose marks are replaced by title and data.
std::string page_document(const std::string& title, nlohmann::json header, const PageBlob& blob,
                          std::string_view page_template);

}  // namespace inhabit
