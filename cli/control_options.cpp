#include "control_options.h"

#include <algorithm>
#include <string>
#include <vector>

#include "inhabit/error.h"
#include "numbers.h"

namespace {

using namespace inhabit;

/// What holds `joint` at `place` between two times, `option` named in errors.
inbetween::JointContact contact_of(const std::string& joint, double from, double to, const Eigen::Vector3d& place,
                                   const Skeleton& file, const std::string& option) {
  try {
    return inbetween::joint_contact(joint, from, to, place, file);
  } catch (const Error& e) {
    throw Error(option, e.what());
  }
}

}  // namespace

void set_contacts(inbetween::Controls& controls, const ControlTexts& texts, const Skeleton& file) {
  for (const std::string& text : texts.contacts) {  // left_hand,1.2,2.0,0.4,1.1,-0.3
    const std::string option = "--contact " + text, name = text.substr(0, text.find(','));
    const std::vector<double> n = numbers(text.substr(std::min(text.size(), name.size() + 1)), 5, option);
    controls.contacts.push_back(contact_of(name, n[0], n[1], {n[2], n[3], n[4]}, file, option));
  }
  for (const std::string& text : texts.targets) {  // left_hand@1.5=0.3,0.9,-0.2
    const std::string option = "--target " + text;
    const size_t at = text.rfind('@'), equals = text.find('=', at == std::string::npos ? 0 : at);
    if (at == std::string::npos || equals == std::string::npos)
      throw Error(option, "is not JOINT@SECONDS=X,Y,Z, such as left_hand@1.5=0.3,0.9,-0.2");
    const double seconds = numbers(text.substr(at + 1, equals - at - 1), 1, option).front();
    const std::vector<double> n = numbers(text.substr(equals + 1), 3, option);
    controls.contacts.push_back(contact_of(text.substr(0, at), seconds, seconds, {n[0], n[1], n[2]}, file, option));
  }
}

void add_controls(CLI::App& verb, inbetween::Controls& controls, ControlTexts& texts) {
  verb.add_option("--key-weights", controls.key_weights,
                  "A weight for each key, 1 at the ends: 1 meets the pose, 0 leaves it out, 0.5 lies half between")
      ->delimiter(',');
  verb.add_option("--contact", texts.contacts,
                  "JOINT,FROM,TO,X,Y,Z: this joint, by its standard name or the file's, or the palm of left_hand or "
                  "right_hand, is at this point, metres, between these seconds; may be repeated");
  verb.add_option(
      "--target", texts.targets,
      "JOINT@SECONDS=X,Y,Z: the joint, named likewise, goes through this point, metres, then; may be repeated");
  verb.add_option_function<std::vector<std::string>>(
      "--root-path",
      [&controls](const std::vector<std::string>& points) {
        for (const std::string& text : points) {
          const std::vector<double> n = numbers(text, 3, "--root-path " + text);
          controls.root_path.push_back({n[0], {n[1], n[2]}});
        }
      },
      "SECONDS,X,Z: the root's curve over the floor goes through these points, in order; may be repeated");
  verb.add_flag("--loop", controls.loop,
                "The last pose is the first again, where the last stands, and the motion can be repeated");
}
