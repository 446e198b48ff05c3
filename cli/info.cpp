#include <cstdio>
#include <memory>

#include "inhabit/io/describe.h"
#include "inputs.h"
#include "verbs.h"

namespace {

/// One value to a line, indented by depth; short lists on one line.
void print(const nlohmann::ordered_json& object, int depth) {
  for (const auto& [key, value] : object.items()) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    std::printf("%*s%s:", 2 * depth, "", name.c_str());
    if (value.is_object()) {
      std::printf("\n");
      print(value, depth + 1);
    } else if (value.is_array()) {
      for (size_t i = 0; i < value.size(); ++i) {
        const auto& item = value[i];
        const std::string text = item.is_string() ? item.get<std::string>() : item.dump();
        std::printf("%s%s", i == 0 ? " " : key == "notes" ? "; " : ", ", text.c_str());
      }
      std::printf("\n");
    } else {
      std::printf(" %s\n", (value.is_string() ? value.get<std::string>() : value.dump()).c_str());
    }
  }
}

struct Info {
  std::string path;
  inhabit::ClipReadOptions reading;
  bool json = false;
};

}  // namespace

void add_info(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("info", "What a motion, scene, model or data set holds");
  auto given = std::make_shared<Info>();
  verb->add_option("FILE", given->path, "Any file inhabit reads, or a data set's folder")->required();
  verb->add_flag("--json", given->json, "As JSON");
  add_reading(*verb, given->reading, "the file");
  verb->callback([given] {
    const nlohmann::ordered_json facts = inhabit::describe_file(given->path, given->reading);
    if (given->json)
      std::printf("%s\n", facts.dump(1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    else
      print(facts, 0);
  });
}
