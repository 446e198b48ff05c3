#include "inhabit/io/gzip.h"
#include "inhabit/view/page_parts.h"

namespace inhabit {
namespace {

using nlohmann::json;

/// The skeleton that motion opened on the page is put on.
json standard_skeleton() {
  const Skeleton& skeleton = builtin_body().skeleton;
  const torch::Tensor offsets = plain(skeleton.offsets);
  return {{"names", standard_joint_names()},
          {"parents", standard_parents()},
          {"offsets", std::vector<float>(offsets.data_ptr<float>(), offsets.data_ptr<float>() + 3 * kStandardJoints)}};
}

std::string base64(const std::string& bytes) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t v = 0;
    for (size_t k = 0; k < 3; ++k) v = v << 8U | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0U);
    for (size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[v >> (18 - 6 * k) & 63U];
  }
  return out;
}

std::string escaped_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// JSON that cannot end the script element it stands in; bytes that are not UTF-8 become U+FFFD.
std::string script_json(const json& value) {
  std::string out;
  for (const char c : value.dump(-1, ' ', false, json::error_handler_t::replace)) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string page_document(const std::string& page_title, json header, const PageBlob& blob,
                          std::string_view page_template) {
  header["standard"] = standard_skeleton();
  const std::string title = escaped_html(page_title.empty() ? "inhabit" : page_title);
  const std::string data = "<script id=\"header\" type=\"application/json\">" + script_json(header) +
                           "</script>\n<script id=\"blob\" type=\"text/plain\">" + base64(gzipped(blob.bytes)) +
                           "</script>";
  // One pass over the template, so that marks inside a title or the data mean nothing.
  std::string out;
  std::string_view rest = page_template;
  static constexpr std::string_view kTitle = "<!--inhabit:title-->", kData = "<!--inhabit:data-->";
  while (!rest.empty()) {
    const size_t at_title = rest.find(kTitle), at_data = rest.find(kData), at = std::min(at_title, at_data);
    out += rest.substr(0, at);
    if (at == std::string_view::npos) break;
    out += at == at_title ? title : data;
    rest.remove_prefix(at + (at == at_title ? kTitle.size() : kData.size()));
  }
  return out;
}

}  // namespace inhabit
