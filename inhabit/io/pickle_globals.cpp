#include "inhabit/io/pickle_globals.h"

#include <algorithm>
#include <map>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/io/npy_format.h"
#include "inhabit/io/torch_file.h"

namespace inhabit {
namespace {

using Kind = PickleValue::Kind;

[[noreturn]] void not_understood(const std::string& subject, const std::string& what) {
  throw Error(subject, "holds " + what + " that cannot be understood");
}

bool is_bytes(const PickleValue& value) { return value.kind == Kind::bytes || value.kind == Kind::text; }

const PickleValue& argument(const PickleValue& tuple, size_t index, Kind kind, const std::string& subject) {
  if (index >= tuple.items.size() || tuple.items[index]->kind != kind) not_understood(subject, "a NumPy array");
  return *tuple.items[index];
}

std::vector<int64_t> shape_of_tuple(const PickleValue& tuple, const std::string& subject) {
  std::vector<int64_t> shape;
  const bool one = tuple.kind == Kind::whole;
  if (!one && tuple.kind != Kind::tuple) not_understood(subject, "the shape of a NumPy array");
  if (one) shape.push_back(tuple.whole);
  for (const PickleValue* item : tuple.items) {
    if (item->kind != Kind::whole) not_understood(subject, "the shape of a NumPy array");
    shape.push_back(item->whole);
  }
  const bool negative = std::any_of(shape.begin(), shape.end(), [](int64_t n) { return n < 0; });
  if (negative || shape.size() > 32) not_understood(subject, "the shape of a NumPy array");
  return shape;
}

/// An array of these bytes.
void fill(PickleValue& array, const std::string& descr, bool fortran, std::vector<int64_t> shape,
          const std::string& bytes, const std::string& subject) {
  size_t at = 0;
  const ByteSource source = [&](char* to, uint64_t size) {
    const size_t n = std::min<size_t>(size, bytes.size() - at);
    std::copy_n(bytes.data() + at, n, to);
    at += n;
    return static_cast<uint64_t>(n);
  };
  Npz read;
  read_npy_data(source, bytes.size(), {descr, fortran, std::move(shape)}, "array", subject, read);
  if (!read.skipped.empty()) throw Error(subject, "holds a NumPy array " + read.skipped.begin()->second);
  if (at != bytes.size()) throw Error(subject, "holds a NumPy array with more bytes than its shape needs");
  const bool texts = !read.strings.empty();
  array.kind = texts ? Kind::texts : Kind::array;
  if (texts)
    array.texts = std::move(read.strings.begin()->second);
  else
    array.array = std::move(read.tensors.begin()->second);
}

/// NumPy's scalar(dtype, bytes): one number or text.
PickleValue scalar_of(const PickleValue& arguments, const std::string& subject) {
  const PickleValue& dtype = argument(arguments, 0, Kind::dtype, subject);
  if (arguments.items.size() != 2 || !is_bytes(*arguments.items[1])) not_understood(subject, "a NumPy number");
  PickleValue array;
  fill(array, dtype.text, false, {}, arguments.items[1]->text, subject);
  PickleValue out;
  if (array.kind == Kind::texts) {
    out.kind = Kind::text;
    out.text = array.texts.values.empty() ? "" : array.texts.values[0];
  } else if (array.array.scalar_type() == torch::kBool) {
    out.kind = Kind::boolean;
    out.boolean = array.array.item<bool>();
  } else if (array.array.is_floating_point()) {
    out.kind = Kind::real;
    out.real = array.array.to(torch::kFloat64).item<double>();
  } else {
    out.kind = Kind::whole;
    out.whole = array.array.to(torch::kInt64).item<int64_t>();
  }
  return out;
}

/// Python 3 writes bytes of protocols up to 2 as text of code points below 256.
std::string latin1(const std::string& utf8, const std::string& subject) {
  std::string out;
  for (size_t i = 0; i < utf8.size(); ++i) {
    const auto lead = static_cast<unsigned char>(utf8[i]);
    if (lead < 0x80) {
      out += utf8[i];
    } else if ((lead == 0xC2 || lead == 0xC3) && i + 1 < utf8.size()) {
      out += static_cast<char>(((lead & 0x03) << 6) | (static_cast<unsigned char>(utf8[++i]) & 0x3F));
    } else {
      not_understood(subject, "bytes");
    }
  }
  return out;
}

/// The type of numbers that PyTorch calls so; none where it does not.
std::optional<torch::ScalarType> storage_type(const std::string& name) {
  static const std::map<std::string, torch::ScalarType> types = {
      {"DoubleStorage", torch::kFloat64}, {"FloatStorage", torch::kFloat32}, {"HalfStorage", torch::kFloat16},
      {"LongStorage", torch::kInt64},     {"IntStorage", torch::kInt32},     {"ShortStorage", torch::kInt16},
      {"CharStorage", torch::kInt8},      {"ByteStorage", torch::kUInt8}};
  const auto found = types.find(name);
  if (found == types.end()) return std::nullopt;
  return found->second;
}

/// (storage, offset, size, stride, ...): a tensor's numbers lie in its storage, and there are no more of them than it
/// has: a row that is said to be there a million times is refused.
PickleValue tensor_of(const PickleValue& arguments, const std::string& subject) {
  const std::vector<const PickleValue*>& given = arguments.items;
  if (given.size() < 4 || given[0]->kind != Kind::storage || given[1]->kind != Kind::whole)
    not_understood(subject, "a tensor");
  const torch::Tensor& storage = given[0]->array;
  const std::vector<int64_t> size = shape_of_tuple(*given[2], subject), stride = shape_of_tuple(*given[3], subject);
  if (size.size() != stride.size() || given[1]->whole < 0) not_understood(subject, "a tensor");
  const int64_t most = storage.numel();
  int64_t count = 1, last = given[1]->whole;
  for (size_t d = 0; d < size.size(); ++d) {
    if (size[d] > most || stride[d] > most || (size[d] > 0 && count > most / size[d]))
      throw Error(subject, "holds a tensor with more numbers than it has");
    count *= size[d];
    last += size[d] > 0 ? (size[d] - 1) * stride[d] : 0;
    if (last > most) throw Error(subject, "holds a tensor with more numbers than it has");
  }
  if (count > 0 && last >= most) throw Error(subject, "holds a tensor with more numbers than it has");
  PickleValue out;
  out.kind = Kind::array;
  out.array = count == 0 ? torch::empty(size, storage.options()) : storage.as_strided(size, stride, given[1]->whole);
  return out;
}

}  // namespace

torch::Tensor torch_storage(const PickleValue& told, TorchStorages& storages, const std::string& subject) {
  const std::vector<const PickleValue*>& given = told.items;
  const bool known = told.kind == Kind::tuple && given.size() >= 5 && given[0]->text == "storage" &&
                     given[1]->kind == Kind::name && given[2]->kind == Kind::text && given[4]->kind == Kind::whole &&
                     (given.size() == 5 || given[5]->kind == Kind::none);
  const std::optional<torch::ScalarType> type = known ? storage_type(given[1]->text) : std::nullopt;
  if (!type || given[4]->whole < 0) not_understood(subject, "a tensor");
  const auto count = static_cast<uint64_t>(given[4]->whole);
  const auto found = storages.by_key.find(given[2]->text);
  if (found != storages.by_key.end()) {
    if (found->second.scalar_type() != *type || static_cast<uint64_t>(found->second.numel()) != count)
      not_understood(subject, "a tensor");
    return found->second;
  }
  const uint64_t item = torch::elementSize(*type);
  if (count > (storages.most_bytes - storages.bytes) / item)
    throw Error(subject, "holds a tensor with more numbers than it has");
  storages.bytes += count * item;
  return storages.by_key[given[2]->text] = torch::zeros({given[4]->whole}, *type);
}

std::string allowed_global(const std::string& module, const std::string& name) {
  static const std::map<std::string, std::string> names = {
      {"numpy ndarray", "ndarray"},
      {"numpy dtype", "dtype"},
      {"numpy.core.multiarray _reconstruct", "reconstruct"},
      {"numpy._core.multiarray _reconstruct", "reconstruct"},
      {"numpy.core.multiarray scalar", "scalar"},
      {"numpy._core.multiarray scalar", "scalar"},
      {"numpy.core.numeric _frombuffer", "frombuffer"},
      {"numpy._core.numeric _frombuffer", "frombuffer"},
      {"_codecs encode", "encode"},
      {"builtins set", "set"},
      {"__builtin__ set", "set"},
      {"builtins frozenset", "set"},
      {"__builtin__ frozenset", "set"},
      {"builtins bytes", "bytes"},
      {"__builtin__ bytes", "bytes"},
      {"builtins bytearray", "bytes"},
      {"__builtin__ bytearray", "bytes"},
      {"collections OrderedDict", "dict"},
      {"torch.storage _load_from_bytes", "load_from_bytes"},
      {"torch._utils _rebuild_tensor", "tensor"},
      {"torch._utils _rebuild_tensor_v2", "tensor"},
      {"torch._utils _rebuild_parameter", "parameter"},
  };
  if (module == "torch" && storage_type(name)) return name;
  const auto found = names.find(module + " " + name);
  return found == names.end() ? "" : found->second;
}

PickleValue call_global(const std::string& global, const PickleValue& arguments, const std::string& subject) {
  const std::vector<const PickleValue*>& given = arguments.items;
  PickleValue out;
  if (global == "reconstruct") {
    out.kind = Kind::pending;
  } else if (global == "dtype") {
    if (given.empty() || !is_bytes(*given[0])) not_understood(subject, "NumPy's type of an array");
    out.kind = Kind::dtype;
    out.text = given[0]->text;
  } else if (global == "scalar") {
    return scalar_of(arguments, subject);
  } else if (global == "frombuffer") {
    if (given.size() != 4 || !is_bytes(*given[0])) not_understood(subject, "a NumPy array");
    const PickleValue& dtype = argument(arguments, 1, Kind::dtype, subject);
    const PickleValue& order = argument(arguments, 3, Kind::text, subject);
    fill(out, dtype.text, order.text == "F", shape_of_tuple(*given[2], subject), given[0]->text, subject);
  } else if (global == "encode") {
    if (given.size() != 2 || given[0]->kind != Kind::text) not_understood(subject, "bytes");
    out.kind = Kind::bytes;
    out.text = latin1(given[0]->text, subject);
  } else if (global == "bytes") {
    if (given.size() > 2 || (!given.empty() && !is_bytes(*given[0]))) not_understood(subject, "bytes");
    out.kind = Kind::bytes;
    if (!given.empty()) out.text = given.size() == 2 ? latin1(given[0]->text, subject) : given[0]->text;
  } else if (global == "load_from_bytes") {
    if (given.size() != 1 || !is_bytes(*given[0])) not_understood(subject, "a tensor");
    const Pickle inner = parse_torch(given[0]->text, subject);
    if (inner.root->kind != Kind::array || inner.root->array.dim() != 1) not_understood(subject, "a tensor");
    out.kind = Kind::storage;
    out.array = inner.root->array;
  } else if (global == "tensor") {
    return tensor_of(arguments, subject);
  } else if (global == "parameter") {
    if (given.empty() || given[0]->kind != Kind::array) not_understood(subject, "a tensor");
    return *given[0];
  } else if (global == "dict") {
    if (!given.empty()) not_understood(subject, "an ordered dictionary");
    out.kind = Kind::dict;
  } else if (global == "set") {
    if (given.size() > 1 || (given.size() == 1 && given[0]->kind != Kind::list)) not_understood(subject, "a set");
    out.kind = Kind::set;
    if (given.size() == 1) out.items = given[0]->items;
  } else {
    not_understood(subject, "a call of " + global);
  }
  return out;
}

void set_state(PickleValue& object, const PickleValue& state, const std::string& subject) {
  const size_t fields = state.items.size();
  if (object.kind == Kind::dtype) {  // (version, byte order, ...)
    if (state.kind != Kind::tuple || fields < 2 || !is_bytes(*state.items[1]))
      not_understood(subject, "NumPy's type of an array");
    const std::string& order = state.items[1]->text;
    if (order == "<" || order == ">") object.text.insert(0, order);
    // Fields of a structured type; nothing else has a name there.
    if (fields > 4 && state.items[3]->kind != Kind::none) throw Error(subject, "holds a NumPy array of records");
    return;
  }
  if (object.kind == Kind::dict && state.kind == Kind::dict) return;  // what else PyTorch notes of an ordered one
  // An array: (version, shape, dtype, whether in Fortran's order, data)
  if (object.kind != Kind::pending) throw Error(subject, "sets the state of an object that is no NumPy array");
  if (state.kind != Kind::tuple || fields != 5) not_understood(subject, "a NumPy array");
  std::vector<int64_t> shape = shape_of_tuple(*state.items[1], subject);
  const PickleValue& dtype = argument(state, 2, Kind::dtype, subject);
  const PickleValue& fortran = *state.items[3];
  const PickleValue& data = *state.items[4];
  if (fortran.kind != Kind::boolean && fortran.kind != Kind::whole) not_understood(subject, "a NumPy array");
  if (data.kind == Kind::list) {  // objects
    object.kind = Kind::list;
    object.items = data.items;
    return;
  }
  if (!is_bytes(data)) not_understood(subject, "a NumPy array");
  fill(object, dtype.text, fortran.boolean || fortran.whole != 0, std::move(shape), data.text, subject);
}

}  // namespace inhabit
