#include "inhabit/io/torch_file.h"

#include <algorithm>

#include "inhabit/io/pickle_machine.h"

namespace inhabit {
namespace {

using namespace std::string_view_literals;

// The pickle of 0x1950a86a20f9469cfc6c, and that of the protocol, 1001.
constexpr std::string_view kTorchMagic = "\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19."sv;
constexpr std::string_view kTorchProtocol = "\x80\x02M\xe9\x03."sv;

}  // namespace

Pickle parse_torch(std::string_view bytes, const std::string& subject) {
  if (bytes.substr(0, 2) == "PK")
    throw Error(subject, "is of PyTorch 1.6 or newer; save it with _use_new_zipfile_serialization=False");
  if (bytes.substr(0, kTorchMagic.size()) != kTorchMagic ||
      bytes.substr(kTorchMagic.size(), kTorchProtocol.size()) != kTorchProtocol)
    throw Error(subject, "is no file of torch.save");
  size_t at = kTorchMagic.size() + kTorchProtocol.size();
  const auto next = [&](TorchStorages* storages) {
    PickleMachine machine(bytes.substr(at), subject, storages);
    Pickle out = machine.run();
    at += machine.used();
    return out;
  };
  const Pickle system = next(nullptr);
  const PickleValue* little = system.root->find("little_endian");
  if (little == nullptr || little->kind != PickleValue::Kind::boolean || !little->boolean)
    throw Error(subject, "does not say that its numbers are little-endian");
  TorchStorages storages;
  storages.most_bytes = bytes.size();
  Pickle out = next(&storages);
  const Pickle keys = next(nullptr);
  if (keys.root->kind != PickleValue::Kind::list || keys.root->items.size() != storages.by_key.size())
    throw Error(subject, "does not hold the numbers that its tensors need");
  for (const PickleValue* key : keys.root->items) {
    const auto found = storages.by_key.find(key->text);
    if (found == storages.by_key.end()) throw Error(subject, "does not hold the numbers that its tensors need");
    const torch::Tensor& storage = found->second;
    uint64_t count = 0;
    if (bytes.size() - at < 8) throw Error(subject, "ends early");
    for (size_t k = 8; k-- > 0;) count = (count << 8) | static_cast<unsigned char>(bytes[at + k]);
    at += 8;
    if (count != static_cast<uint64_t>(storage.numel()))
      throw Error(subject, "holds other numbers than its tensors need");
    if (bytes.size() - at < storage.nbytes()) throw Error(subject, "ends early");
    std::copy_n(bytes.data() + at, storage.nbytes(), static_cast<char*>(storage.data_ptr()));
    at += storage.nbytes();
    storages.by_key.erase(found);
  }
  return out;
}

}  // namespace inhabit
