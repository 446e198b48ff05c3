#include "inhabit/io/convert_files.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/file_notes.h"

namespace inhabit {

const std::vector<std::string>& convert_formats() {
  static const std::vector<std::string> all = {"npz", "json", "bvh", "glb", "ply"};
  return all;
}

FileCount convert_files(const std::vector<std::string>& named, const std::string& out, const std::string& format,
                        const ConvertOptions& options,
                        const std::function<void(const std::string&, const std::string&)>& told, Notes* notes,
                        const Progress& progress) {
  namespace fs = std::filesystem;
  std::error_code none;
  const std::vector<std::string>& formats = convert_formats();
  const auto known = [&](const std::string& name) {
    return std::find(formats.begin(), formats.end(), name) != formats.end();
  };
  if (!known(format)) throw Error("format", "'" + format + "' is none of npz, json, bvh, glb, ply");
  if (known(extension_of(out)) && !fs::is_directory(out, none))
    throw Error(out, "is named like a file; many become files of a folder");
  std::vector<std::string> files, skipped;
  std::map<std::string, std::string> targets, made;
  for (const Conversion& each : conversions(named, out, format, &skipped, &made)) {
    files.push_back(each.in);
    targets[each.in] = each.out;
  }
  if (files.empty()) throw skipped.empty() ? Error("no file to convert") : Error(skipped.front());
  const bool new_folder = !fs::exists(out, none);
  FileCount count;
  try {
    count = each_file(
        files,
        [&](const std::string& file) {
          const std::string& target = targets[file];
          Notes own;
          std::error_code failed;  // where it cannot be made, the file cannot be written, which is said
          fs::create_directories(fs::path(target).parent_path(), failed);
          const std::string line = convert_file(file, target, options, &own, &made);
          if (notes != nullptr) add_notes(*notes, std::move(own), file);
          if (told) told(target, line);
        },
        progress);
  } catch (const Error&) {
    if (new_folder) fs::remove(out, none);  // where it is empty
    throw;
  }
  count.skipped.insert(count.skipped.end(), skipped.begin(), skipped.end());
  return count;
}

}  // namespace inhabit
