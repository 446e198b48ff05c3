#include "inhabit/synth/furniture.h"

#include <cmath>

#include "inhabit/math/random.h"
#include "inhabit/synth/furniture_builder.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;
using furniture::Builder;
using furniture::Color;
using furniture::kFabrics;
using furniture::kLinen;
using furniture::kSteel;
using furniture::kWoods;
using furniture::pick;

// Four legs under the corners of a rectangle of half sizes (x, z) around (0, center_z).
void corner_legs(Builder& b, const Color& color, double x, double z, double center_z, double top, double half,
                 bool round) {
  for (const double sx : {-1.0, 1.0})
    for (const double sz : {-1.0, 1.0}) b.leg(color, sx * (x - half), center_z + sz * (z - half), top, half, round);
}

// The seat of a light chair: a board or a thin cushion on a frame, legs below.
void light_seat(Builder& b, std::mt19937_64& random, const Color& wood, const Color& fabric, double w, double d,
                double height) {
  const bool cushion = chance(random, 0.5), round = chance(random, 0.4);
  const double thick = cushion ? uniform(random, 0.045, 0.065) : uniform(random, 0.02, 0.035);
  b.solid(cushion ? fabric : wood, {-w / 2, height - thick, -d / 2}, {w / 2, height, d / 2}, cushion ? 0.02 : 0.01, 2);
  if (cushion || chance(random, 0.5))
    b.solid(wood, {-w / 2 + 0.015, height - thick - 0.045, -d / 2 + 0.015},
            {w / 2 - 0.015, height - thick, d / 2 - 0.015});
  corner_legs(b, wood, w / 2 - 0.01, d / 2 - 0.01, 0, height - thick, uniform(random, 0.016, 0.022), round);
}

// The back of a light chair behind z: posts with rails, posts with bars, or one panel.
void light_back(Builder& b, std::mt19937_64& random, const Color& wood, const Color& fabric, double w, double seat,
                double top, double z0, double z) {
  const double post = 0.032;
  const int style = uniform_int(random, 0, 3);
  for (const double s : {-1.0, 1.0}) {
    const double x = s * (w / 2 - post / 2);
    b.solid(wood, {x - post / 2, seat, z0}, {x + post / 2, top, z});
  }
  const double x = w / 2 - post, height = top - seat;
  if (style == 0) {
    b.solid(fabric, {-x, seat + 0.35 * height, z0}, {x, top - 0.01, z}, 0.012, 2);
  } else if (style == 1) {
    const int rails = uniform_int(random, 2, 4);
    for (int i = 0; i < rails; ++i) {
      const double y = top - 0.06 - 0.7 * height * i / rails;
      b.solid(wood, {-x, y - 0.03, z0 + 0.006}, {x, y + 0.03, z});
    }
  } else {
    b.solid(wood, {-x, top - 0.07, z0 + 0.004}, {x, top - 0.01, z});
    if (style == 2) b.solid(wood, {-x, seat + 0.06, z0 + 0.004}, {x, seat + 0.10, z});
    const int bars = uniform_int(random, 3, 5);
    for (int i = 0; i < bars; ++i) {
      const double bar = -x + 2 * x * (i + 0.5) / bars, foot = style == 2 ? seat + 0.10 : seat;
      b.solid(wood, {bar - 0.011, foot, z0 + 0.006}, {bar + 0.011, top - 0.07, z}, 0.003);
    }
  }
}

// Sofas and upholstered armchairs: base, seat cushions, arms and a thick back.
Furniture upholstered(std::mt19937_64& random, const std::string& kind, int seats, double cushion_width,
                      double seat_height) {
  Builder b(kind);
  const Color& fabric = pick(random, kFabrics);
  const Color& wood = pick(random, kWoods);
  const double arm = uniform(random, 0.10, 0.18), arm_height = seat_height + uniform(random, 0.15, 0.22);
  const double back = uniform(random, 0.16, 0.24), back_height = seat_height + uniform(random, 0.36, 0.48);
  const double seat_depth = uniform(random, 0.50, 0.57), depth = back + seat_depth;
  const double foot = uniform(random, 0.04, 0.14), inner = seats * cushion_width / 2, w = inner + arm;
  const double z0 = -depth / 2, zb = z0 + back, z1 = depth / 2, cushion = uniform(random, 0.12, 0.17);
  corner_legs(b, wood, w - 0.03, depth / 2 - 0.03, 0, foot, 0.022, chance(random, 0.6));
  b.solid(fabric, {-inner, foot, z0}, {inner, seat_height - cushion, z1 - 0.02}, 0.015, 2);
  b.solid(fabric, {-inner, seat_height - cushion, z0}, {inner, back_height - 0.04, z0 + 0.4 * back}, 0.03, 2);
  for (int i = 0; i < seats; ++i) {
    const double x0 = -inner + i * cushion_width, x1 = x0 + cushion_width;
    b.solid(fabric, {x0 + 0.003, seat_height - cushion, zb}, {x1 - 0.003, seat_height, z1}, 0.035, 3);
    b.solid(fabric, {x0 + 0.003, seat_height - cushion, z0 + 0.4 * back}, {x1 - 0.003, back_height, zb}, 0.04, 3);
    b.surface(Surface::Kind::seat, x0 + 0.02, x1 - 0.02, zb, z1, seat_height);
  }
  for (const double s : {1.0, -1.0}) {
    const double x0 = s > 0 ? inner : -w, x1 = x0 + arm;
    b.solid(fabric, {x0, foot, z0}, {x1, arm_height, z1 - 0.01}, 0.025, 2);
    b.surface(s > 0 ? Surface::Kind::arm_rest_left : Surface::Kind::arm_rest_right, x0 + 0.02, x1 - 0.02, zb, z1 - 0.04,
              arm_height);
  }
  b.back(back_height, zb);
  return b.finish();
}

}  // namespace

Eigen::AlignedBox3d Furniture::bounds() const {
  Eigen::AlignedBox3d out;
  for (const Box& box : boxes) {
    out.extend(Vector3d(box.center - box.half));
    out.extend(Vector3d(box.center + box.half));
  }
  return out;
}

void Furniture::place(double x, double z, double yaw) {
  pose = Eigen::Translation3d(x, 0, z) * Eigen::AngleAxisd(yaw, Vector3d::UnitY());
}

void Furniture::rescale(const Vector3d& factors) {
  for (Box& box : boxes) {
    box.center = box.center.cwiseProduct(factors);
    box.half = box.half.cwiseProduct(factors);
  }
  for (Surface& surface : surfaces) {
    surface.center = surface.center.cwiseProduct(factors);
    surface.half_width *= factors.x();
    surface.half_depth *= factors.z();
  }
  back_height *= factors.y();
  back_z *= factors.z();
  const torch::Tensor stretch = torch::tensor({factors.x(), factors.y(), factors.z()}).to(torch::kFloat);
  for (Mesh& mesh : meshes) mesh.vertices = mesh.vertices * stretch;
}

Furniture make_chair(std::mt19937_64& random, std::optional<double> seat_height) {
  Builder b("chair");
  const Color wood = chance(random, 0.15) ? kSteel : pick(random, kWoods);
  const Color& fabric = pick(random, kFabrics);
  const double height = seat_height.value_or(uniform(random, 0.42, 0.48));
  const double w = uniform(random, 0.40, 0.48), d = uniform(random, 0.41, 0.46);
  const double top = height + uniform(random, 0.36, 0.50), z = -d / 2 + 0.032;
  light_seat(b, random, wood, fabric, w, d, height);
  light_back(b, random, wood, fabric, w, height, top, -d / 2, z);
  b.surface(Surface::Kind::seat, -w / 2 + 0.02, w / 2 - 0.02, z, d / 2, height);
  b.back(top, z);
  return b.finish();
}

Furniture make_armchair(std::mt19937_64& random, std::optional<double> seat_height) {
  const bool thick = chance(random, 0.4);
  if (thick) {
    const double cushion = uniform(random, 0.54, 0.62), seat = seat_height.value_or(uniform(random, 0.40, 0.46));
    return upholstered(random, "armchair", 1, cushion, seat);
  }
  Builder b("armchair");
  const Color& wood = pick(random, kWoods);
  const Color& fabric = pick(random, kFabrics);
  const double height = seat_height.value_or(uniform(random, 0.42, 0.47));
  const double w = uniform(random, 0.48, 0.54), d = uniform(random, 0.43, 0.48);
  const double top = height + uniform(random, 0.38, 0.50), z = -d / 2 + 0.032;
  const double arm_height = height + uniform(random, 0.19, 0.25), arm = uniform(random, 0.045, 0.065);
  const double arm_end = d / 2 - uniform(random, 0.03, 0.10);
  light_seat(b, random, wood, fabric, w, d, height);
  light_back(b, random, wood, fabric, w, height, top, -d / 2, z);
  b.surface(Surface::Kind::seat, -w / 2 + 0.03, w / 2 - 0.03, z, d / 2, height);
  for (const double s : {1.0, -1.0}) {
    const double x = s * (w / 2 + arm / 2 - 0.01);
    b.solid(wood, {x - arm / 2, arm_height - 0.028, -d / 2}, {x + arm / 2, arm_height, arm_end}, 0.007, 2);
    b.solid(wood, {x - 0.014, 0.6 * height, arm_end - 0.07}, {x + 0.014, arm_height - 0.028, arm_end - 0.03});
    b.surface(s > 0 ? Surface::Kind::arm_rest_left : Surface::Kind::arm_rest_right, x - arm / 2 + 0.01,
              x + arm / 2 - 0.01, z + 0.05, arm_end - 0.01, arm_height);
  }
  b.back(top, z);
  return b.finish();
}

Furniture make_stool(std::mt19937_64& random, std::optional<double> seat_height) {
  Builder b("stool");
  const Color& wood = pick(random, kWoods);
  const double height = seat_height.value_or(uniform(random, 0.42, 0.50));
  const double w = uniform(random, 0.32, 0.42), d = chance(random, 0.6) ? w : uniform(random, 0.30, 0.40);
  light_seat(b, random, wood, pick(random, kFabrics), w, d, height);
  if (chance(random, 0.5)) {
    const double y = 0.3 * height;
    for (const double s : {-1.0, 1.0})
      b.solid(wood, {s * (w / 2 - 0.028) - 0.01, y, -d / 2 + 0.03},
              {s * (w / 2 - 0.028) + 0.01, y + 0.025, d / 2 - 0.03});
  }
  b.surface(Surface::Kind::seat, -w / 2 + 0.01, w / 2 - 0.01, -d / 2, d / 2, height);
  return b.finish();
}

Furniture make_sofa(std::mt19937_64& random, int seats, std::optional<double> seat_height) {
  const double cushion = uniform(random, 0.58, 0.70), seat = seat_height.value_or(uniform(random, 0.40, 0.45));
  return upholstered(random, "sofa", seats, cushion, seat);
}

Furniture make_table(std::mt19937_64& random, double width, double depth, double height) {
  Builder b("table");
  const Color& top = pick(random, kWoods);
  const Color& legs = chance(random, 0.7) ? top : pick(random, kWoods);
  const double thick = uniform(random, 0.022, 0.04), x = width / 2, z = depth / 2;
  b.solid(top, {-x, height - thick, -z}, {x, height, z}, 0.006);
  b.surface(Surface::Kind::table, -x, x, -z, z, height);
  const int style = uniform_int(random, 0, 3);
  if (style == 0 && height > 0.6 && width > 0.8) {  // two panels with a stretcher
    const double inset = uniform(random, 0.06, 0.16);
    for (const double s : {-1.0, 1.0})
      b.solid(legs, {s * (x - inset) - 0.02, 0, -z + 0.10}, {s * (x - inset) + 0.02, height - thick, z - 0.10});
    b.solid(legs, {-x + inset, 0.45 * height, -0.015}, {x - inset, 0.45 * height + 0.08, 0.015});
  } else {
    corner_legs(b, legs, x - 0.03, z - 0.03, 0, height - thick, uniform(random, 0.022, 0.034), style == 1);
    if (style >= 2)
      for (const double s : {-1.0, 1.0})
        b.solid(legs, {-x + 0.06, height - thick - 0.07, s * (z - 0.06) - 0.012},
                {x - 0.06, height - thick, s * (z - 0.06) + 0.012});
    if (height < 0.6 && chance(random, 0.5)) b.solid(legs, {-x + 0.05, 0.12, -z + 0.05}, {x - 0.05, 0.14, z - 0.05});
  }
  return b.finish();
}

Furniture make_bed(std::mt19937_64& random, std::optional<double> height) {
  Builder b("bed");
  const Color& wood = pick(random, kWoods);
  const Color& blanket = pick(random, kFabrics);
  const double w = chance(random, 0.5) ? uniform(random, 0.90, 1.05) : uniform(random, 1.40, 1.80);
  const double length = uniform(random, 1.98, 2.08), top = height.value_or(uniform(random, 0.42, 0.54));
  const double frame = top - uniform(random, 0.16, 0.22), head = uniform(random, 0.85, 1.15);
  const double z0 = -length / 2, z1 = length / 2, x = w / 2;
  corner_legs(b, wood, x - 0.02, length / 2 - 0.02, 0, frame - 0.12, 0.03, false);
  b.solid(wood, {-x, frame - 0.12, z0}, {x, frame, z1}, 0.01);
  b.solid(wood, {-x, 0, z0 - 0.05}, {x, head, z0}, 0.012);
  b.solid(kLinen, {-x + 0.02, frame, z0}, {x - 0.02, top - 0.012, z1 - 0.015}, 0.04, 3);
  const double fold = z0 + uniform(random, 0.55, 0.75);
  b.solid(blanket, {-x + 0.012, frame + 0.03, fold}, {x - 0.012, top, z1 - 0.01}, 0.035, 3);
  const int pillows = w > 1.3 ? 2 : 1;
  for (int i = 0; i < pillows; ++i) {
    const double px = pillows == 1 ? 0 : (i - 0.5) * w / 2, half = std::min(0.33, w / 2 / pillows - 0.05);
    b.solid(kLinen, {px - half, top - 0.02, z0 + 0.04}, {px + half, top + 0.10, z0 + 0.44}, 0.055, 3);
  }
  b.surface(Surface::Kind::bed, -x + 0.03, x - 0.03, fold, z1 - 0.03, top);
  return b.finish();
}

Furniture make_shelf(std::mt19937_64& random, std::optional<double> board_height) {
  Builder b("shelf");
  const Color& wood = pick(random, kWoods);
  const double w = uniform(random, 0.65, 1.20), d = uniform(random, 0.28, 0.38), side = 0.022;
  const double height = uniform(random, 0.95, 2.05), x = w / 2, z = d / 2;
  // Boards at even heights, moved so that one lies where it was asked for.
  double gap = uniform(random, 0.30, 0.42), lowest = uniform(random, 0.05, 0.12);
  if (board_height) {
    const int below = std::max(1, static_cast<int>(std::lround((*board_height - lowest) / gap)));
    gap = (*board_height - lowest) / below;
  }
  double top = std::max(height, board_height.value_or(0) + 0.01);
  if (board_height && top - *board_height > 0.02) top = std::max(top, *board_height + 0.35);
  b.solid(wood, {-x, 0, -z}, {-x + side, top, z}, 0.004);
  b.solid(wood, {x - side, 0, -z}, {x, top, z}, 0.004);
  b.solid(wood, {-x + side, lowest - 0.02, -z}, {x - side, top, -z + 0.01}, 0.002);
  std::vector<double> boards;
  for (double y = lowest; y < top - 0.22 || (board_height && y < *board_height + 0.01); y += gap) boards.push_back(y);
  boards.push_back(top);
  for (size_t i = 0; i < boards.size(); ++i) {
    const double y = boards[i];
    b.solid(wood, {-x + side, y - side, -z + 0.01}, {x - side, y, z}, 0.004);
    const bool wanted = board_height && std::abs(y - *board_height) < 0.02, last = i + 1 == boards.size();
    const double room = last ? 1.0 : boards[i + 1] - side - y;
    if (wanted || last || chance(random, 0.45)) {
      if (y > 0.3 && y < 1.7) b.surface(Surface::Kind::shelf, -x + 0.04, x - 0.04, -z + 0.03, z, y);
      continue;
    }
    double at = -x + side + 0.01;  // a row of books
    const double full = x - side - uniform(random, 0.02, 0.6 * w);
    while (at < full) {
      const double t = uniform(random, 0.018, 0.05), h = std::min(room - 0.03, uniform(random, 0.17, 0.29));
      const double front = z - uniform(random, 0.03, 0.09);
      b.solid(pick(random, kFabrics), {at, y, -z + 0.015}, {at + t, y + h, front}, 0.003);
      at += t + 0.002;
    }
  }
  return b.finish();
}

}  // namespace inhabit
