#include "inhabit/scene/query.h"

#include <ATen/Parallel.h>

#include <nanoflann.hpp>

#include "inhabit/error.h"
#include "inhabit/scene/embree.h"
#include "inhabit/scene/triangle.h"

namespace inhabit {
namespace {

using Eigen::Vector3f;

constexpr int64_t kGrain = 256;                          // queries a thread takes at once
constexpr float kSlack = 1.0001F, kSlackMetres = 1e-5F;  // for rounding in bounds of distances

Vector3f row(const torch::Tensor& points, int64_t i) {
  return Eigen::Map<const Vector3f>(points.data_ptr<float>() + 3 * i);
}

void set_row(torch::Tensor& points, int64_t i, const Vector3f& p) {
  Eigen::Map<Vector3f>(points.data_ptr<float>() + 3 * i) = p;
}

torch::Tensor as_rows(const torch::Tensor& points, const char* what) {
  if (points.dim() != 2 || points.size(1) != 3) throw Error(std::string(what) + " must be (N, 3)");
  return points.detach().to(torch::kCPU, torch::kFloat32).contiguous();
}

/// Directions along which winding numbers are counted: three axes turned so that they are along nobody's walls, both
/// ways, then eighteen spread by the golden angle.
const std::vector<Vector3f>& winding_directions() {
  static const std::vector<Vector3f> all = [] {
    std::vector<Vector3f> out;
    const Eigen::Matrix3f axes =
        (Eigen::AngleAxisf(0.437F, Vector3f(0.36F, 0.48F, 0.8F)) * Eigen::AngleAxisf(0.291F, Vector3f::UnitX()))
            .toRotationMatrix();
    for (int axis = 0; axis < 3; ++axis) {
      out.push_back(axes.col(axis));
      out.push_back(-axes.col(axis));
    }
    for (int i = 0; i < 18; ++i) {
      const double y = 1 - (2 * i + 1) / 18.0, r = std::sqrt(1 - y * y), angle = 2.399963 * i + 0.1234;
      out.emplace_back(axes * Vector3f(static_cast<float>(r * std::cos(angle)), static_cast<float>(y),
                                       static_cast<float>(r * std::sin(angle))));
    }
    return out;
  }();
  return all;
}

/// Winding number of every body that rays have met so far, times the number of rays.
struct Windings {
  std::vector<std::pair<int32_t, int>> of_body;
  void add(int32_t body, int sign) {
    for (auto& [known, sum] : of_body) {
      if (known != body) continue;
      sum += sign;
      return;
    }
    of_body.emplace_back(body, sign);
  }
  int largest() const {
    int most = 0;
    for (const auto& [body, sum] : of_body) most = std::max(most, sum);
    return most;
  }
};

struct CrossingContext {
  RayContext context;  // first, for Embree hands back its address
  const Solid* solid;
  Windings* windings;
};

/// Counts every face a ray meets, and lets it go on.
void count_crossing(const RTCFilterFunctionNArguments* arguments) {
  const auto* c = reinterpret_cast<const CrossingContext*>(arguments->context);
  for (unsigned int i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != -1) continue;
    const unsigned int face = RTCHitN_primID(arguments->hit, arguments->N, i);
    const Vector3f direction(RTCRayN_dir_x(arguments->ray, arguments->N, i),
                             RTCRayN_dir_y(arguments->ray, arguments->N, i),
                             RTCRayN_dir_z(arguments->ray, arguments->N, i));
    const int out = direction.dot(c->solid->normal(face)) > 0 ? 1 : -1;
    c->windings->add(c->solid->body[face], out * c->solid->outward[face]);
    arguments->valid[i] = 0;
  }
}

struct NearestFace {
  const Solid* solid;
  Vector3f query, point = Vector3f::Zero();
  float distance = HUGE_VALF;
  unsigned int face = RTC_INVALID_GEOMETRY_ID;
};

bool look_at_face(RTCPointQueryFunctionArguments* arguments) {
  auto* nearest = static_cast<NearestFace*>(arguments->userPtr);
  const Solid& solid = *nearest->solid;
  const unsigned int face = arguments->primID;
  // In double: on a long sliver, floats are a tenth of a millimetre off.
  const auto corner = [&](size_t k) -> Eigen::Vector3d { return solid.corner(face, k).cast<double>(); };
  const Eigen::Vector3d from = nearest->query.cast<double>();
  const Eigen::Vector3d point = closest_on_triangle<double>(from, corner(0), corner(1), corner(2));
  const auto distance = static_cast<float>((point - from).norm());
  // Of faces equally near, the lowest number, so that the answer does not depend on the order of the search.
  if (distance > nearest->distance || (distance == nearest->distance && face > nearest->face)) return false;
  nearest->distance = distance;
  nearest->point = point.cast<float>();
  nearest->face = face;
  arguments->query->radius = distance;
  return true;
}

RTCRay make_ray(const Vector3f& origin, const Vector3f& direction, float far) {
  RTCRay ray{};
  ray.org_x = origin.x(), ray.org_y = origin.y(), ray.org_z = origin.z();
  ray.dir_x = direction.x(), ray.dir_y = direction.y(), ray.dir_z = direction.z();
  ray.tnear = 0;
  ray.tfar = far;
  ray.mask = UINT32_MAX;
  return ray;
}

/// What nanoflann wants to know of a cloud.
struct CloudPoints {
  const float* data = nullptr;
  size_t count = 0;
  size_t kdtree_get_point_count() const { return count; }
  float kdtree_get_pt(size_t i, size_t axis) const { return data[3 * i + axis]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, CloudPoints>, CloudPoints, 3, uint32_t>;

/// One for the process: each has threads of its own, and thousands of scenes may be open at once.
RTCDevice embree_device() {
  static const RTCDevice device = rtcNewDevice(nullptr);
  if (device == nullptr) throw Error("Embree cannot start");
  return device;
}

}  // namespace

struct CloudQuery::Impl {
  torch::Tensor cloud;
  CloudPoints points;
  Tree tree;

  explicit Impl(const torch::Tensor& given)
      : cloud(as_rows(given, "a point cloud").clone()),
        points{cloud.data_ptr<float>(), static_cast<size_t>(cloud.size(0))},
        tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(12)) {}
};

CloudQuery::CloudQuery(const torch::Tensor& cloud) {
  if (cloud.size(0) == 0) throw Error("a point cloud without points has no neighbours");
  impl_ = std::make_unique<Impl>(cloud);
}

CloudQuery::~CloudQuery() = default;
CloudQuery::CloudQuery(CloudQuery&&) noexcept = default;
CloudQuery& CloudQuery::operator=(CloudQuery&&) noexcept = default;

Neighbours CloudQuery::nearest(const torch::Tensor& points, int64_t count) const {
  const torch::Tensor from = as_rows(points, "points");
  const int64_t n = from.size(0);
  if (count < 1 || count > impl_->cloud.size(0)) {
    throw Error(std::to_string(count) + " neighbours are asked for of a cloud of " +
                std::to_string(impl_->cloud.size(0)) + " points");
  }
  Neighbours out{torch::empty({n, count}, torch::kInt64), torch::empty({n, count})};
  int64_t* indices = out.indices.data_ptr<int64_t>();
  float* distances = out.distances.data_ptr<float>();
  at::parallel_for(0, n, kGrain, [&](int64_t begin, int64_t end) {
    std::vector<uint32_t> found(static_cast<size_t>(count));
    for (int64_t i = begin; i < end; ++i) {
      float* to = distances + i * count;
      if (!row(from, i).allFinite()) {
        std::fill_n(to, count, NAN);
        std::fill_n(indices + i * count, count, -1);
        continue;
      }
      impl_->tree.knnSearch(from.data_ptr<float>() + 3 * i, found.size(), found.data(), to);
      for (int64_t k = 0; k < count; ++k) {
        indices[i * count + k] = static_cast<int64_t>(found[static_cast<size_t>(k)]);
        to[k] = std::sqrt(to[k]);
      }
    }
  });
  return out;
}

struct SceneQuery::Impl {
  Solid solid;
  RTCScene scene = nullptr;
  Vector3f lower = Vector3f::Constant(HUGE_VALF), upper = Vector3f::Constant(-HUGE_VALF);
  std::unique_ptr<CloudQuery> cloud;

  explicit Impl(const Scene& source) : solid(make_solid(source)) {
    if (solid.faces.empty() && solid.points.empty())
      throw Error("scene '" + source.name + "' has neither faces nor points");
    if (!solid.points.empty()) cloud = std::make_unique<CloudQuery>(source.points);
    if (solid.faces.empty()) return;
    if (solid.faces.size() >= UINT32_MAX) throw Error("scene '" + source.name + "' has more than 4 billion faces");
    const RTCDevice device = embree_device();
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | kFilteredRays);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), solid.vertices.size()));
    auto* faces = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                 3 * sizeof(uint32_t), solid.faces.size()));
    if (vertices == nullptr || faces == nullptr) {
      free_embree();
      throw Error("scene '" + source.name + "' does not fit into memory");
    }
    for (const Vector3f& vertex : solid.vertices) {
      lower = lower.cwiseMin(vertex);
      upper = upper.cwiseMax(vertex);
      vertices = std::copy_n(vertex.data(), 3, vertices);
    }
    for (const auto& face : solid.faces) faces = std::copy_n(face.data(), 3, faces);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    const RTCError failed = rtcGetDeviceError(device);
    if (failed != RTC_ERROR_NONE) {
      free_embree();
      throw Error("scene '" + source.name + "': Embree error " + std::to_string(failed));
    }
  }
  ~Impl() { free_embree(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void free_embree() {
    if (scene != nullptr) rtcReleaseScene(scene);
    scene = nullptr;
  }

  /// @param within metres: faces farther away are not looked for
  NearestFace nearest_face(const Vector3f& at, float within) const {
    NearestFace nearest;
    nearest.solid = &solid;
    nearest.query = at;
    RTCPointQuery query{at.x(), at.y(), at.z(), 0, within};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &query, &context, look_at_face, &nearest);
    return nearest;
  }

  bool is_inside(const Vector3f& at, Windings& windings) const {
    if (!((at.array() >= lower.array()).all() && (at.array() <= upper.array()).all())) return false;
    windings.of_body.clear();
    const auto count = static_cast<int>(winding_directions().size());
    for (int k = 0; k < count; ++k) {
      CrossingContext context{};
      context.solid = &solid;
      context.windings = &windings;
      RTCRayHit ray{};
      ray.ray = make_ray(at, winding_directions()[static_cast<size_t>(k)], HUGE_VALF);
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      every_hit(scene, ray, context.context, count_crossing);
      if (k == 5 && windings.largest() == 0) return false;
      if (k == 5 && windings.largest() >= 6) return true;
    }
    return Solid::holds(windings.largest(), count);
  }

  /// Mesh and face within it.
  std::pair<int64_t, int64_t> place_of(unsigned int face) const {
    const auto next = std::upper_bound(solid.first_face.begin(), solid.first_face.end(), static_cast<int64_t>(face));
    const int64_t mesh = next - solid.first_face.begin() - 1;
    return {mesh, static_cast<int64_t>(face) - solid.first_face[static_cast<size_t>(mesh)]};
  }
};

SceneQuery::SceneQuery(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
SceneQuery::~SceneQuery() = default;
SceneQuery::SceneQuery(SceneQuery&&) noexcept = default;
SceneQuery& SceneQuery::operator=(SceneQuery&&) noexcept = default;

const Solid& SceneQuery::solid() const { return impl_->solid; }

ClosestPoints SceneQuery::closest(const torch::Tensor& points) const {
  const torch::Tensor from = as_rows(points, "points");
  const int64_t n = from.size(0);
  ClosestPoints out{torch::full({n, 3}, NAN), torch::full({n}, NAN), torch::zeros({n, 3}),
                    torch::full({n}, -1, torch::kInt64), torch::full({n}, -1, torch::kInt64)};
  float* distances = out.distances.data_ptr<float>();
  int64_t *meshes = out.mesh.data_ptr<int64_t>(), *faces = out.face.data_ptr<int64_t>();
  if (impl_->scene != nullptr) {
    at::parallel_for(0, n, kGrain, [&](int64_t begin, int64_t end) {
      // What is nearest to a point cannot be farther from its neighbour than by the distance between them.
      Vector3f before = Vector3f::Zero();
      float known = HUGE_VALF;
      for (int64_t i = begin; i < end; ++i) {
        const Vector3f at = row(from, i);
        if (!at.allFinite()) continue;
        NearestFace nearest = impl_->nearest_face(at, kSlack * (known + (at - before).norm()) + kSlackMetres);
        if (nearest.face == RTC_INVALID_GEOMETRY_ID) nearest = impl_->nearest_face(at, HUGE_VALF);
        if (nearest.face == RTC_INVALID_GEOMETRY_ID) continue;
        before = at;
        known = nearest.distance;
        set_row(out.points, i, nearest.point);
        distances[i] = nearest.distance;
        set_row(out.normals, i, impl_->solid.normal(nearest.face).normalized());
        std::tie(meshes[i], faces[i]) = impl_->place_of(nearest.face);
      }
    });
  }
  if (impl_->cloud) {
    const Neighbours neighbours = impl_->cloud->nearest(from);
    const float* near = neighbours.distances.data_ptr<float>();
    const int64_t* indices = neighbours.indices.data_ptr<int64_t>();
    for (int64_t i = 0; i < n; ++i) {
      const int64_t index = indices[i];
      if (index < 0 || near[i] >= distances[i]) continue;
      set_row(out.points, i, impl_->solid.points[static_cast<size_t>(index)]);
      set_row(out.normals, i, Vector3f::Zero());
      distances[i] = near[i];
      meshes[i] = -1;
      faces[i] = index;
    }
  }
  return out;
}

torch::Tensor SceneQuery::inside(const torch::Tensor& points) const {
  const torch::Tensor from = as_rows(points, "points");
  torch::Tensor out = torch::zeros({from.size(0)}, torch::kBool);
  if (impl_->scene == nullptr) return out;
  bool* to = out.data_ptr<bool>();
  at::parallel_for(0, from.size(0), kGrain, [&](int64_t begin, int64_t end) {
    Windings windings;
    for (int64_t i = begin; i < end; ++i) to[i] = impl_->is_inside(row(from, i), windings);
  });
  return out;
}

torch::Tensor SceneQuery::signed_distance(const torch::Tensor& points) const {
  const torch::Tensor distances = closest(points).distances;
  return torch::where(inside(points), -distances, distances);
}

RayHits SceneQuery::cast(const torch::Tensor& origins, const torch::Tensor& directions, double max_distance) const {
  const torch::Tensor from = as_rows(origins, "ray origins"), along = as_rows(directions, "ray directions");
  const int64_t n = from.size(0);
  if (along.size(0) != n) throw Error("as many ray directions as origins are needed");
  RayHits out{torch::zeros({n}, torch::kBool),
              torch::full({n}, HUGE_VAL),
              torch::zeros({n, 3}),
              torch::zeros({n, 3}),
              torch::full({n}, -1, torch::kInt64),
              torch::full({n}, -1, torch::kInt64)};
  if (impl_->scene == nullptr) return out;
  bool* hit = out.hit.data_ptr<bool>();
  float* distances = out.distances.data_ptr<float>();
  int64_t *meshes = out.mesh.data_ptr<int64_t>(), *faces = out.face.data_ptr<int64_t>();
  at::parallel_for(0, n, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const Vector3f origin = row(from, i), direction = row(along, i).normalized();
      if (!origin.allFinite() || !direction.allFinite() || !(direction.squaredNorm() > 0)) continue;
      RTCRayHit ray{};
      ray.ray = make_ray(origin, direction, static_cast<float>(max_distance));
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      first_hit(impl_->scene, ray);
      if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      hit[i] = true;
      distances[i] = ray.ray.tfar;
      set_row(out.points, i, origin + ray.ray.tfar * direction);
      set_row(out.normals, i, impl_->solid.normal(ray.hit.primID).normalized());
      std::tie(meshes[i], faces[i]) = impl_->place_of(ray.hit.primID);
    }
  });
  return out;
}

}  // namespace inhabit
