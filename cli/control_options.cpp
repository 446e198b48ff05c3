#include "control_options.h"

#include <algorithm>
#include <string>
#include <vector>

#include "inhabit/error.h"
#include "numbers.h"

namespace {

using namespace inhabit;

/// "left_hand,1.2,2.0,0.4,1.1,-0.3": joint, from, to, x, y, z.
inbetween::JointContact contact_of(const std::string& text) {
  const std::string option = "--contact " + text, name = text.substr(0, text.find(','));
  const std::vector<double> n = numbers(text.substr(std::min(text.size(), name.size() + 1)), 5, option);
  try {
    return inbetween::joint_contact(name, n[0], n[1], {n[2], n[3], n[4]});
  } catch (const Error& e) {
    throw Error(option, e.what());
  }
}

}  // namespace

void add_controls(CLI::App& verb, inbetween::Controls& controls) {
  verb.add_option("--key-weights", controls.key_weights,
                  "A weight for each key, 1 at the ends: 1 meets the pose, 0 leaves it out, 0.5 goes half of the way")
      ->delimiter(',');
  verb.add_option_function<std::vector<std::string>>(
      "--contact",
      [&controls](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) controls.contacts.push_back(contact_of(text));
      },
      "JOINT,FROM,TO,X,Y,Z: this joint, or the palm of left_hand or right_hand, is at this point between these "
      "seconds; "
      "may be repeated");
  verb.add_option_function<std::vector<std::string>>(
      "--root-path",
      [&controls](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) {
          const std::vector<double> n = numbers(text, 3, "--root-path " + text);
          controls.root_path.push_back({n[0], {n[1], n[2]}});
        }
      },
      "SECONDS,X,Z: the root's curve over the floor goes through these points, in order; may be repeated");
  verb.add_flag("--loop", controls.loop,
                "The last pose is the first again, where the last stands, and the motion can be repeated");
}
