#include "inhabit/inbetween/control_text.h"

#include <algorithm>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/io/number_list.h"

namespace inhabit::inbetween {
namespace {

/// What holds `joint` at `place` between two times, `option` named in errors.
JointContact contact_of(const std::string& joint, double from, double to, const Eigen::Vector3d& place,
                        const Skeleton& file, const std::string& option) {
  try {
    return joint_contact(joint, from, to, place, file);
  } catch (const Error& e) {
    throw Error(option, e.what());
  }
}

}  // namespace

JointContact parse_contact(const std::string& text, const Skeleton& file) {
  const std::string option = "--contact " + text, name = text.substr(0, text.find(','));
  const std::vector<double> n = listed_numbers(text.substr(std::min(text.size(), name.size() + 1)), 5, option);
  return contact_of(name, n[0], n[1], {n[2], n[3], n[4]}, file, option);
}

JointContact parse_target(const std::string& text, const Skeleton& file) {
  const std::string option = "--target " + text;
  const size_t at = text.rfind('@'), equals = text.find('=', at == std::string::npos ? 0 : at);
  if (at == std::string::npos || equals == std::string::npos)
    throw Error(option, "is not JOINT@SECONDS=X,Y,Z, such as left_hand@1.5=0.3,0.9,-0.2");
  const double seconds = listed_numbers(text.substr(at + 1, equals - at - 1), 1, option).front();
  const std::vector<double> n = listed_numbers(text.substr(equals + 1), 3, option);
  return contact_of(text.substr(0, at), seconds, seconds, {n[0], n[1], n[2]}, file, option);
}

PathPoint parse_path_point(const std::string& text) {
  const std::vector<double> n = listed_numbers(text, 3, "--root-path " + text);
  return {n[0], {n[1], n[2]}};
}

}  // namespace inhabit::inbetween
