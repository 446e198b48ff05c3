#include "control_options.h"

#include <spdlog/fmt/fmt.h>

#include <string>
#include <utility>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/inbetween/control_text.h"

using namespace inhabit;

void set_contacts(inbetween::Controls& controls, const ControlTexts& texts, const Skeleton& file) {
  for (const std::string& text : texts.contacts) controls.contacts.push_back(inbetween::parse_contact(text, file));
  for (const std::string& text : texts.targets) controls.contacts.push_back(inbetween::parse_target(text, file));
}

// The library refuses these times too, but knows neither the option nor the input's clock.
void require_times(const inbetween::Controls& controls, const ControlTexts& texts, double first, double seconds) {
  const auto require = [&](const std::string& option, double from, double to) {
    if (from < 0 || from > to || to > seconds)
      throw Error(
          option,
          fmt::format("{} not within 0 to {:g} s, which count from the first key, at {:g} s of the input: on its "
                      "clock they are {:g} to {:g} s",
                      from == to ? fmt::format("{:g} s is", from) : fmt::format("{:g} to {:g} s are", from, to),
                      seconds, first, first, first + seconds));
  };
  size_t k = 0;  // contacts come first, then targets
  for (const auto& [name, all] : {std::pair("--contact ", &texts.contacts), std::pair("--target ", &texts.targets)})
    for (const std::string& text : *all) {
      const inbetween::JointContact& contact = controls.contacts.at(k++);
      require(name + text, contact.from, contact.to);
    }
  for (const inbetween::PathPoint& point : controls.root_path)
    require(fmt::format("--root-path {:g},{:g},{:g}", point.seconds, point.place[0], point.place[1]), point.seconds,
            point.seconds);
}

void add_controls(CLI::App& verb, inbetween::Controls& controls, ControlTexts& texts) {
  verb.add_option("--key-weights", controls.key_weights,
                  "A weight for each key, 1 at the ends: 1 meets the pose, 0 leaves it out, 0.5 lies half between")
      ->delimiter(',');
  verb.add_option(
      "--contact", texts.contacts,
      "JOINT,FROM,TO,X,Y,Z: this joint, by its standard name or the file's, or the palm of left_hand or "
      "right_hand, is at this point, metres, +Y up whatever the file's axes, between these seconds from the "
      "first key on; may be repeated");
  verb.add_option(
      "--target", texts.targets,
      "JOINT@SECONDS=X,Y,Z: the joint, named likewise, goes through this point, metres, +Y up, then, seconds from the "
      "first key on; may be repeated");
  verb.add_option_function<std::vector<std::string>>(
      "--root-path",
      [&controls](const std::vector<std::string>& points) {
        for (const std::string& text : points) controls.root_path.push_back(inbetween::parse_path_point(text));
      },
      "SECONDS,X,Z: the root's curve over the floor goes through these points (metres, +Y up; seconds from the first "
      "key on), in order; may be repeated");
  verb.add_flag("--loop", controls.loop,
                "The last pose is the first again, where the last stands, and the motion can be repeated");
}
