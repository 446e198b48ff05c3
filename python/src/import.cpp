#include "calls.h"
#include "inhabit/data/import_dataset.h"
#include "inhabit/io/smpl_model.h"

namespace inhabit::python {
namespace {

py::dict listed(const std::string& format, const Path& folder, const BodyModel* body) {
  const ImportSet set = released([&] { return open_import_set(format, folder.string(), body); });
  py::list recordings;
  for (const ImportRecording& r : set.recordings)
    recordings.append(py::dict("name"_a = r.name, "person"_a = r.person, "split"_a = r.split, "scene"_a = r.scene));
  return py::dict("recordings"_a = recordings, "missing"_a = set.missing, "broken"_a = set.broken,
                  "splits"_a = set.splits);
}

/// Dataset of Python, and why recordings were skipped.
std::pair<py::object, std::vector<std::string>> imported(const std::string& format, const Path& folder, const Path& out,
                                                         int jobs, const ShardArgument& shard, const BodyModel* body,
                                                         const py::object& progress) {
  ImportOptions options;
  options.jobs = jobs;
  options.shard = shard_of(shard);
  options.progress = progress_of(progress);
  const ImportResult made =
      released([&] { return import_dataset(open_import_set(format, folder.string(), body), out.string(), options); });
  // A shard that others are to follow has no index yet.
  const py::object dataset =
      made.dataset.whole ? py::module_::import("inhabit").attr("Dataset")(out) : py::object(py::none());
  return {dataset, made.skipped};
}

}  // namespace

void add_import(py::module_& m) {
  m.def(
      "import_formats", [] { return import_formats(); }, "The names of the data sets that import_dataset reads.");
  m.def(
      "import_list", &listed, "format"_a, "folder"_a, py::kw_only(), "body"_a = py::none(),
      "What a folder holds of a data set as its owners hand it out (docs/data.md): a dictionary of recordings (name,\n"
      "person, split, scene), missing, broken, and splits, which says where the splits come from.");
  m.def(
      "import_dataset", &imported, "format"_a, "folder"_a, "out"_a, py::kw_only(), "jobs"_a = 0, "shard"_a = py::none(),
      "body"_a = py::none(), "progress"_a = py::none(),
      "Makes a native data set of one that its owners hand out: on the standard joints, 30 frames a second, the floor "
      "at\n"
      "y = 0, contacts labelled from the scenes. Clips that are in `out` already are kept.\n\n"
      "jobs: recordings at once, 0: as many as there are cores; shard: (I, N) for part I of N; body: the Body of "
      "SMPL-family\n"
      "recordings, for their own bone lengths; progress: called with recordings done and all. Returns the Dataset "
      "(None\n"
      "where other shards are still to come) and why recordings were skipped, a list of lines.");
}

}  // namespace inhabit::python
