#pragma once
#include <torch/types.h>

#include <map>
#include <string>
#include <vector>

// Bytes of Python's pickles and of PyTorch's files, as their programs write them.

namespace inhabit {

inline std::string little_endian(uint64_t n, int bytes) {
  std::string out;
  for (int k = 0; k < bytes; ++k) out += static_cast<char>((n >> (8 * k)) & 0xFF);
  return out;
}
inline std::string pickled_text(const std::string& t) { return "X" + little_endian(t.size(), 4) + t; }

/// A pickle of a dictionary of NumPy arrays, as Python 3 writes it in protocol 2, but for the data, which it would
/// write as text.
inline std::string pickled(const std::map<std::string, torch::Tensor>& arrays, const std::string& more = "") {
  std::string out = "\x80\x03}(";
  for (const auto& [name, given] : arrays) {
    const torch::Tensor t = given.to(torch::kFloat32).contiguous();
    out += pickled_text(name) + "cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK" + std::string(1, '\0') +
           "\x85" + "C\x01" + "b\x87R(K\x01(";
    for (const int64_t n : t.sizes()) out += "J" + little_endian(static_cast<uint64_t>(n), 4);
    out += "tcnumpy\ndtype\n" + pickled_text("f4") + "\x89\x88\x87R(K\x03" + pickled_text("<") +
           "NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xff" + "K" + std::string(1, '\0') + "tb\x89" + "B" +
           little_endian(t.nbytes(), 4) + std::string(static_cast<const char*>(t.data_ptr()), t.nbytes()) + "tb";
  }
  return out + more + "u.";
}
/// What torch.save wrote before PyTorch 1.6: a pickle that names numbers by keys ("0", "1", ...), and those after it.
inline std::string torch_saved(const std::string& pickle, const std::vector<torch::Tensor>& storages) {
  std::string keys, numbers;
  for (size_t k = 0; k < storages.size(); ++k) {
    keys += pickled_text(std::to_string(k));
    numbers += little_endian(static_cast<uint64_t>(storages[k].numel()), 8) +
               std::string(static_cast<const char*>(storages[k].data_ptr()), storages[k].nbytes());
  }
  using namespace std::string_literals;
  return "\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.\x80\x02M\xe9\x03."s + "\x80\x02}(" +
         pickled_text("protocol_version") + "M\xe9\x03" + pickled_text("little_endian") + "\x88u.\x80\x02" + pickle +
         ".\x80\x02](" + keys + "e." + numbers;
}
inline std::string torch_storage_key(size_t key, int64_t count) {
  return "(" + pickled_text("storage") + "ctorch\nFloatStorage\n" + pickled_text(std::to_string(key)) +
         pickled_text("cuda:0") + "J" + little_endian(static_cast<uint64_t>(count), 4) + "NtQ";
}
inline std::string torch_view(const std::string& storage, const torch::Tensor& t) {
  std::string size = "(", stride = "(";
  for (int64_t d = 0; d < t.dim(); ++d) {
    size += "J" + little_endian(static_cast<uint64_t>(t.size(d)), 4);
    stride += "J" + little_endian(static_cast<uint64_t>(t.stride(d)), 4);
  }
  return "ctorch._utils\n_rebuild_tensor_v2\n(" + storage + "K" + std::string(1, '\0') + size + "t" + stride +
         "t\x89"
         "ccollections\nOrderedDict\n)RtR";
}

/// A state_dict of float32 tensors as a file.
inline std::string torch_file(const std::map<std::string, torch::Tensor>& tensors) {
  std::string items;
  std::vector<torch::Tensor> storages;
  for (const auto& [name, given] : tensors) {
    storages.push_back(given.to(torch::kFloat32).contiguous());
    items += pickled_text(name) + torch_view(torch_storage_key(storages.size() - 1, given.numel()), storages.back());
  }
  return torch_saved("ccollections\nOrderedDict\n)R(" + items + "u}(" + pickled_text("_metadata") + "}ub", storages);
}

/// A pickle of a dictionary of PyTorch's tensors: each is a file of torch.save in it.
inline std::string torch_pickle(const std::map<std::string, torch::Tensor>& tensors) {
  std::string out = "\x80\x03}(";
  for (const auto& [name, given] : tensors) {
    const torch::Tensor t = given.to(torch::kFloat32).contiguous();
    const std::string file = torch_saved(torch_storage_key(0, t.numel()), {t.flatten()});
    out += pickled_text(name) +
           torch_view("ctorch.storage\n_load_from_bytes\nB" + little_endian(file.size(), 4) + file + "\x85R", t);
  }
  return out + "u.";
}

}  // namespace inhabit
