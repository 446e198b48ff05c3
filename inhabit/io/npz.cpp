#include "inhabit/io/npz.h"

#include <zip.h>

#include <cstring>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/npy_format.h"

namespace inhabit {
namespace {

struct ArchiveCloser {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
using Archive = std::unique_ptr<zip_t, ArchiveCloser>;
struct EntryCloser {
  void operator()(zip_file_t* entry) const { zip_fclose(entry); }
};
using ZipEntry = std::unique_ptr<zip_file_t, EntryCloser>;

std::string message(zip_error_t& error) {
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

bool is_npy(std::string_view bytes) { return bytes.substr(0, 6) == "\x93NUMPY"; }

Npz read_archive(zip_t* archive, uint64_t archive_size, const std::string& subject,
                 const std::vector<std::string>& only, std::string* pickle) {
  Npz content;
  const zip_int64_t entries = zip_get_num_entries(archive, 0);
  uint64_t packed = 0;  // entries that share bytes are how small archives claim endless content
  for (zip_int64_t i = 0; i < entries; ++i) {
    zip_stat_t stat;
    zip_stat_init(&stat);
    const zip_uint64_t needed = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
    if (zip_stat_index(archive, static_cast<zip_uint64_t>(i), 0, &stat) != 0 || (stat.valid & needed) != needed)
      throw Error(subject, "its directory is damaged");
    std::string name = stat.name;
    if (name.size() > 4 && name.compare(name.size() - 4, 4, ".npy") == 0) {
      name.resize(name.size() - 4);
    } else {
      if (name.empty() || name.back() != '/') content.skipped[name] = "not an array";
      continue;
    }
    if (!only.empty() && std::find(only.begin(), only.end(), name) == only.end()) continue;
    std::string where = subject;
    where.append(": ").append(name);
    packed += stat.comp_size;
    if (stat.comp_size > archive_size || packed > archive_size) throw Error(where, "is larger than the file");
    // Deflate packs 1032 bytes into one at best.
    if (stat.size / 1032 > stat.comp_size + 64 || (stat.comp_method == ZIP_CM_STORE && stat.size != stat.comp_size))
      throw Error(where, "declares an absurd size");
    const ZipEntry entry(zip_fopen_index(archive, static_cast<zip_uint64_t>(i), 0));
    if (!entry) throw Error(where, std::string("cannot be unpacked: ") + zip_strerror(archive));
    const ByteSource source = [&](char* to, uint64_t size) -> uint64_t {
      const zip_int64_t n = zip_fread(entry.get(), to, size);
      if (n < 0) throw Error(where, std::string("is damaged: ") + zip_error_strerror(zip_file_get_error(entry.get())));
      return static_cast<uint64_t>(n);
    };
    read_npy(source, stat.size, name, where, content, pickle);
    char more = 0;
    if (content.skipped.count(name) == 0) source(&more, 1);  // at the end the checksum is compared
  }
  if (entries == 0) throw Error(subject, "the archive is empty");
  return content;
}

}  // namespace

const torch::Tensor& Npz::at(const std::string& name, const std::string& subject) const {
  if (const auto found = tensors.find(name); found != tensors.end()) return found->second;
  if (strings.count(name) != 0) throw Error(subject, "its array " + name + " holds text, not numbers");
  if (const auto found = skipped.find(name); found != skipped.end())
    throw Error(subject, "its array " + name + " cannot be read: it is " + found->second);
  std::string there;
  for (const auto& [key, value] : tensors) there += (there.empty() ? "" : ", ") + key;
  throw Error(subject, "has no array " + name + (there.empty() ? "" : " (it has " + there.substr(0, 200) + ")"));
}

namespace {

Npz parse_content(std::string_view bytes, const std::string& subject, const std::vector<std::string>& only,
                  std::string* pickle) {
  if (bytes.empty()) throw Error(subject, "is empty");
  if (is_npy(bytes)) {
    Npz content;
    size_t at = 0;
    const ByteSource source = [&](char* to, uint64_t size) {
      const size_t n = std::min<size_t>(size, bytes.size() - at);
      std::memcpy(to, bytes.data() + at, n);
      at += n;
      return static_cast<uint64_t>(n);
    };
    read_npy(source, bytes.size(), "arr_0", subject, content, pickle);
    return content;
  }
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  if (source == nullptr) throw Error(subject, message(error));
  const Archive archive(zip_open_from_source(source, ZIP_RDONLY, &error));
  if (!archive) {
    zip_source_free(source);
    throw Error(subject, "is not a NumPy archive, or is cut short (" + message(error) + ")");
  }
  return read_archive(archive.get(), bytes.size(), subject, only, pickle);
}

}  // namespace

Npz parse_npz(std::string_view bytes, const std::string& subject, const std::vector<std::string>& only) {
  return parse_content(bytes, subject, only, nullptr);
}

std::string npz_pickle(const std::string& path, const std::string& name) {
  std::string pickle;
  const Npz content = parse_content(read_whole_file(path), path, {name}, &pickle);
  if (content.skipped.count(name) == 0) content.at(name, path);  // says what is there instead
  if (pickle.empty()) throw Error(path, "its array " + name + " holds no Python objects");
  return pickle;
}

Npz read_npz(const std::string& path, const std::vector<std::string>& only) {
  return parse_npz(read_whole_file(path), path, only);
}

std::string npz_bytes(const Npz& content) {
  std::map<std::string, std::string> files;  // must outlive the archive
  for (const auto& [name, tensor] : content.tensors) files[name + ".npy"] = npy_bytes(tensor);
  for (const auto& [name, strings] : content.strings) files[name + ".npy"] = npy_bytes(strings);
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* buffer = zip_source_buffer_create(nullptr, 0, 0, &error);
  if (buffer == nullptr) throw Error("a NumPy archive cannot be made: " + message(error));
  zip_source_keep(buffer);  // the archive takes one reference, reading the bytes back needs another
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> kept(buffer, &zip_source_free);
  Archive archive(zip_open_from_source(buffer, ZIP_CREATE | ZIP_TRUNCATE, &error));
  if (!archive) {
    zip_source_free(buffer);
    throw Error("a NumPy archive cannot be made: " + message(error));
  }
  auto fail = [&]() { throw Error(std::string("a NumPy archive cannot be made: ") + zip_strerror(archive.get())); };
  for (const auto& [name, bytes] : files) {
    zip_source_t* source = zip_source_buffer(archive.get(), bytes.data(), bytes.size(), 0);
    if (source == nullptr) fail();
    const zip_int64_t index = zip_file_add(archive.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(source);
      fail();
    }
    const auto entry = static_cast<zip_uint64_t>(index);
    // Motion is noise to deflate: level 1 packs floats as well as level 9 and labels well enough. A fixed date keeps
    // the bytes the same.
    zip_set_file_compression(archive.get(), entry, ZIP_CM_DEFLATE, 1);
    zip_file_set_dostime(archive.get(), entry, 0, (1 << 5) | 1, 0);
  }
  if (zip_close(archive.get()) != 0) fail();
  (void)archive.release();
  if (files.empty()) throw Error("a NumPy archive needs an array");
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_source_stat(buffer, &stat) != 0 || zip_source_open(buffer) != 0)
    throw Error("a NumPy archive cannot be made");
  std::string out(stat.size, '\0');
  const zip_int64_t n = zip_source_read(buffer, out.data(), out.size());
  zip_source_close(buffer);
  if (n != static_cast<zip_int64_t>(out.size())) throw Error("a NumPy archive cannot be made");
  return out;
}

void write_npz(const std::string& path, const Npz& content) { write_atomically(path, npz_bytes(content)); }

void write_npy(const std::string& path, const torch::Tensor& tensor) { write_atomically(path, npy_bytes(tensor)); }

}  // namespace inhabit
