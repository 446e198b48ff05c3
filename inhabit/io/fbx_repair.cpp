#include "inhabit/io/fbx_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string_view>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/io/number_text.h"

namespace inhabit {
namespace {

constexpr int kDeepestFbxNode = 100;
constexpr uint32_t kOldestFbx = 7000;
constexpr std::string_view kBinaryFbx{"Kaydara FBX Binary  \0", 21};

/// Where a number stands in the file.
struct FbxNumber {
  size_t at = 0, size = 0;
  char type = 'D';  ///< of binary files
  double value = 0;
};

/// A property of an object, a line "P".
struct FbxProperty {
  enum class Of { model, take, other };
  Of of = Of::other;
  int object = 0;
  std::string name;
  std::vector<FbxNumber> numbers;
};

/// The degrees about x, then y, then z, of a rotation that undoes that of such degrees.
std::array<double, 3> undone(const std::array<double, 3>& degrees) {
  const auto about = [&](int k, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(degrees[static_cast<size_t>(k)] * M_PI / 180, axis);
  };
  const Eigen::Matrix3d m =
      (about(2, Eigen::Vector3d::UnitZ()) * about(1, Eigen::Vector3d::UnitY()) * about(0, Eigen::Vector3d::UnitX()))
          .toRotationMatrix()
          .transpose();
  const double y = std::asin(std::clamp(-m(2, 0), -1.0, 1.0));
  const bool locked = std::abs(m(2, 0)) > 1 - 1e-9;
  const double x = locked ? 0 : std::atan2(m(2, 1), m(2, 2));
  const double z = locked ? std::atan2(-m(0, 1), m(1, 1)) : std::atan2(m(1, 0), m(0, 0));
  return {x * 180 / M_PI, y * 180 / M_PI, z * 180 / M_PI};
}

/// The numbers that are to be others, with their new values.
std::vector<FbxNumber> repairs_of(const std::vector<FbxProperty>& properties) {
  using Of = FbxProperty::Of;
  std::set<int> limits_only;
  for (const FbxProperty& p : properties)
    if (p.of == Of::model && p.name == "RotationSpaceForLimitOnly" && p.numbers.size() == 1 && p.numbers[0].value != 0)
      limits_only.insert(p.object);
  std::vector<FbxNumber> out;
  const auto set = [&](FbxNumber number, double value) {
    if (number.value == value) return;
    number.value = value;
    out.push_back(number);
  };
  for (const FbxProperty& p : properties) {
    const bool rotation = p.of == Of::model && p.numbers.size() == 3;
    const bool limits = limits_only.count(p.object) != 0;
    if (p.of == Of::take && (p.name == "LocalStart" || p.name == "LocalStop") && p.numbers.size() == 1)
      set(p.numbers[0], 0);
    if (p.of == Of::model && p.name == "RotationOrder" && p.numbers.size() == 1 && (limits || p.numbers[0].value == 6))
      set(p.numbers[0], 0);
    if (rotation && limits && (p.name == "PreRotation" || p.name == "PostRotation"))
      for (const FbxNumber& number : p.numbers) set(number, 0);
    const auto finite = [](const FbxNumber& number) { return std::isfinite(number.value); };
    if (!rotation || limits || p.name != "PostRotation" || !std::all_of(p.numbers.begin(), p.numbers.end(), finite))
      continue;
    const std::array<double, 3> inverse = undone({p.numbers[0].value, p.numbers[1].value, p.numbers[2].value});
    for (size_t k = 0; k < 3; ++k) set(p.numbers[k], inverse[k]);
  }
  return out;
}

/// The properties of a binary file's models and takes, as far as it can be followed.
class BinaryFbx {
 public:
  explicit BinaryFbx(const std::string& bytes) : bytes_(bytes) {
    wide_ = bytes.size() >= 27 && number<uint32_t>(23) >= 7500;
    for (size_t at = 27; readable_ && at > 0 && at < bytes.size();) at = node(at, bytes.size(), 0, "", nullptr);
  }
  std::vector<FbxProperty> properties;

 private:
  template <typename T>
  T number(size_t at) {
    T out{};
    if (at > bytes_.size() || bytes_.size() - at < sizeof out)
      readable_ = false;
    else
      std::memcpy(&out, bytes_.data() + at, sizeof out);
    return out;
  }

  /// @param object its properties are those of the object they lie in. @return where the next node begins, 0: nowhere
  size_t node(size_t at, size_t limit, int depth, std::string_view above, const FbxProperty* object) {
    const size_t word = wide_ ? 8 : 4;
    const uint64_t end = wide_ ? number<uint64_t>(at) : number<uint32_t>(at);
    const uint64_t count = wide_ ? number<uint64_t>(at + 8) : number<uint32_t>(at + 4);
    const uint64_t length = wide_ ? number<uint64_t>(at + 16) : number<uint32_t>(at + 8);
    size_t from = at + 3 * word;
    const auto letters = number<uint8_t>(from++);
    if (!readable_ || end == 0) return 0;  // the empty node that ends a list
    if (depth > kDeepestFbxNode || end > limit || end < from + letters || length > end - from - letters) {
      readable_ = false;
      return 0;
    }
    const std::string_view name(bytes_.data() + from, letters);
    from += letters;
    FbxProperty own;
    if (depth == 1 && above == "Objects") {
      own.object = ++objects_;
      own.of = name == "Model"            ? FbxProperty::Of::model
               : name == "AnimationStack" ? FbxProperty::Of::take
                                          : FbxProperty::Of::other;
      object = &own;
    }
    if (name == "P" && object != nullptr && object->of != FbxProperty::Of::other)
      property(from, from + length, count, *object);
    for (size_t next = from + length; readable_ && next > 0 && next < end;)
      next = node(next, end, depth + 1, name, object);
    return end;
  }

  void property(size_t at, size_t end, uint64_t count, const FbxProperty& object) {
    FbxProperty out{object.of, object.object, {}, {}};
    for (uint64_t k = 0; k < count && at < end && readable_; ++k) {
      const char type = bytes_[at++];
      size_t size = type == 'S' || type == 'R' ? number<uint32_t>(at) : 0;
      if (type == 'S' || type == 'R') at += 4;
      if (type == 'I' || type == 'F') size = 4;
      if (type == 'L' || type == 'D') size = 8;
      if (type == 'Y') size = 2;
      if (type == 'C' || type == 'B') size = 1;
      if (at > end || size > end - at || (size == 0 && type != 'S' && type != 'R'))
        return;  // an array: not of interest
      if (k == 0) out.name = bytes_.substr(at, size);
      if (k >= 4 && type == 'I') out.numbers.push_back({at, size, type, static_cast<double>(number<int32_t>(at))});
      if (k >= 4 && type == 'L') out.numbers.push_back({at, size, type, static_cast<double>(number<int64_t>(at))});
      if (k >= 4 && type == 'D') out.numbers.push_back({at, size, type, number<double>(at)});
      at += size;
    }
    properties.push_back(std::move(out));
  }

  const std::string& bytes_;
  bool wide_ = false, readable_ = true;
  int objects_ = 0;
};

void repair_binary(std::string& bytes) {
  for (const FbxNumber& number : repairs_of(BinaryFbx(bytes).properties)) {
    char* to = bytes.data() + number.at;
    const auto whole = static_cast<int64_t>(number.value);
    const auto small = static_cast<int32_t>(number.value);
    std::memcpy(to,
                number.type == 'I'   ? static_cast<const void*>(&small)
                : number.type == 'L' ? static_cast<const void*>(&whole)
                                     : static_cast<const void*>(&number.value),
                number.size);
  }
}

/// The properties of a text file's models and takes.
std::vector<FbxProperty> text_properties(std::string_view text) {
  std::vector<FbxProperty> out;
  FbxProperty object;
  const char* first = text.data();
  while (!text.empty()) {
    std::string_view line = next_line(text);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    const size_t colon = line.find(": ");
    if (colon == std::string_view::npos) continue;
    const std::string_view name = line.substr(0, colon);
    if (line.back() == '{' && line.size() > colon + 2 && line.find_first_of("-0123456789", colon + 2) == colon + 2) {
      ++object.object;  // "Model: 1234, "Model::Hips", "LimbNode" {"
      object.of = name == "Model"            ? FbxProperty::Of::model
                  : name == "AnimationStack" ? FbxProperty::Of::take
                                             : FbxProperty::Of::other;
    }
    if (name != "P" || object.of == FbxProperty::Of::other) continue;
    FbxProperty p{object.of, object.object, {}, {}};
    size_t at = colon + 2;
    for (int k = 0; at <= line.size(); ++k) {
      const size_t end = std::min(line.find(',', at), line.size());
      std::string_view word = line.substr(at, end - at);
      while (!word.empty() && word.front() == ' ') word.remove_prefix(1);
      while (!word.empty() && word.back() == ' ') word.remove_suffix(1);
      if (k == 0 && word.size() >= 2) p.name = word.substr(1, word.size() - 2);
      double value = 0;
      if (k >= 4 && parse_number(word, value))
        p.numbers.push_back({static_cast<size_t>(word.data() - first), word.size(), 'D', value});
      at = end + 1;
    }
    out.push_back(std::move(p));
  }
  return out;
}

std::string repaired_text(const std::string& text) {
  std::string out;
  size_t copied = 0;
  for (const FbxNumber& number : repairs_of(text_properties(text))) {  // in the order of the file
    char value[32];
    std::snprintf(value, sizeof value, "%.15g", number.value);
    out.append(text, copied, number.at - copied).append(value);
    copied = number.at + number.size;
  }
  return out.append(text, copied);
}

}  // namespace

std::string repaired_fbx(std::string bytes, const std::string& subject) {
  if (bytes.empty()) throw Error(subject, "is empty");
  const bool binary = std::string_view(bytes).substr(0, kBinaryFbx.size()) == kBinaryFbx;
  uint32_t version = 0;
  if (binary && bytes.size() >= 27) {
    std::memcpy(&version, bytes.data() + 23, 4);
  } else if (const size_t at = bytes.find("FBXVersion:"); at != std::string::npos && at < 4096) {
    version = static_cast<uint32_t>(std::strtoul(bytes.c_str() + at + 11, nullptr, 10));
  }
  if (version > 0 && version < kOldestFbx)
    throw Error(subject, "is FBX " + std::to_string(version / 1000) + "." + std::to_string(version / 100 % 10) +
                             ", too old to be read; save it as FBX 2011 (7.1) or newer");
  if (!binary) return repaired_text(bytes);
  repair_binary(bytes);
  return bytes;
}

}  // namespace inhabit
