#include "inhabit/io/pickle.h"

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/npz.h"

namespace inhabit {
namespace {

using PickleKind = PickleValue::Kind;

constexpr int64_t kMostNumbers = 1 << 24;  ///< of a list that is read as an array

void collect(const PickleValue& value, std::vector<double>& numbers, const std::string& subject,
             const std::string& what) {
  if (static_cast<int64_t>(numbers.size()) > kMostNumbers) throw Error(subject, "its " + what + " is too long a list");
  switch (value.kind) {
    case PickleKind::boolean:
      return numbers.push_back(value.boolean ? 1 : 0);
    case PickleKind::whole:
      return numbers.push_back(static_cast<double>(value.whole));
    case PickleKind::real:
      return numbers.push_back(value.real);
    default:
      throw Error(subject, "its " + what + " is neither a NumPy array nor a list of numbers");
  }
}

}  // namespace

const PickleValue* PickleValue::find(std::string_view key) const {
  if (kind != Kind::dict) return nullptr;
  for (size_t i = 0; i + 1 < items.size(); i += 2)
    if ((items[i]->kind == Kind::text || items[i]->kind == Kind::bytes) && items[i]->text == key) return items[i + 1];
  return nullptr;
}

const PickleValue& Pickle::at(const PickleValue& dict, std::string_view key) const {
  if (dict.kind != PickleKind::dict) throw Error(subject, "holds no dictionary with \"" + std::string(key) + "\"");
  if (const PickleValue* found = dict.find(key)) return *found;
  std::string there;
  for (size_t i = 0; i + 1 < dict.items.size() && there.size() < 200; i += 2)
    if (dict.items[i]->kind == PickleKind::text) there += (there.empty() ? "" : ", ") + dict.items[i]->text;
  throw Error(subject, "has no \"" + std::string(key) + "\"" + (there.empty() ? "" : " (it has " + there + ")"));
}

torch::Tensor Pickle::numbers(const PickleValue& value, const std::string& what) const {
  if (value.kind == PickleKind::array) return value.array.to(torch::kFloat32);
  std::vector<double> numbers;
  std::vector<int64_t> shape;
  if (value.kind == PickleKind::list || value.kind == PickleKind::tuple) {
    shape = {static_cast<int64_t>(value.items.size())};
    const bool arrays = !value.items.empty() && value.items[0]->kind == PickleKind::array;
    if (arrays) {  // a list of arrays of one shape
      std::vector<torch::Tensor> rows;
      for (const PickleValue* item : value.items) {
        if (item->kind != PickleKind::array || item->array.sizes() != value.items[0]->array.sizes())
          throw Error(subject, "its " + what + " is a list of arrays that differ in shape");
        rows.push_back(item->array.to(torch::kFloat32));
      }
      return torch::stack(rows);
    }
    for (const PickleValue* item : value.items) collect(*item, numbers, subject, what);
  } else {
    collect(value, numbers, subject, what);
  }
  return torch::tensor(numbers, torch::kFloat64).to(torch::kFloat32).view(shape);
}

torch::Tensor Pickle::numbers_at(const PickleValue& dict, const std::string& key) const {
  return numbers(at(dict, key), key);
}

double Pickle::number_at(const PickleValue& dict, const std::string& key) const {
  const torch::Tensor all = numbers_at(dict, key);
  const double number = all.numel() == 1 ? all.item<double>() : std::nan("");
  if (!std::isfinite(number)) throw Error(subject, "its " + key + " is no number");
  return number;
}

const std::string& Pickle::text(const PickleValue& value, const std::string& what) const {
  if (value.kind != PickleKind::text) throw Error(subject, "its " + what + " is no text");
  return value.text;
}

Pickle read_pickle(const std::string& path) { return parse_pickle(read_whole_file(path), path); }

Pickle read_npz_objects(const std::string& path, const std::string& name) {
  Pickle out = parse_pickle(npz_pickle(path, name), path);
  // np.savez(name=object) makes an array of one object of it.
  if (out.root->kind == PickleKind::list && out.root->items.size() == 1) out.root = out.root->items[0];
  return out;
}

}  // namespace inhabit
