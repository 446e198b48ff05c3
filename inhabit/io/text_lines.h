#pragma once
#include <string>
#include <string_view>

namespace inhabit {

/// Goes through a text line by line and through a line word by word, and knows where it is, for readers of text
/// formats. Nothing is copied; the text must outlive the reader.
class TextLines {
 public:
  /// @param name names the source in errors. Throws Error where the text holds NUL bytes (a binary file).
  TextLines(std::string_view text, std::string name);

  /// The next line without its line end and surrounding blanks; false at the end.
  bool next(std::string_view& line);
  /// The next line that is not blank; false at the end.
  bool next_filled(std::string_view& line);
  /// 1-based number of the line last returned.
  int number() const { return number_; }
  /// What is left after the line last returned.
  size_t bytes_left() const { return text_.size() - at_; }

  /// Throws Error(name, "line N: " + reason).
  [[noreturn]] void fail(const std::string& reason) const;

  /// A finite number. Throws with the line's number for anything else, and says so where a comma stands for the decimal
  /// point.
  double real(std::string_view word) const;
  /// The same for a whole number in [lowest, highest].
  long whole(std::string_view word, long lowest, long highest) const;

 private:
  std::string_view text_;
  std::string name_;
  size_t at_ = 0;
  int number_ = 0;
};

/// Takes the next word (ended by spaces or tabs) from the front of `rest`; empty where there is none.
std::string_view next_word(std::string_view& rest);

/// `word` in quotes, cut and with control characters replaced, to be shown in an error.
std::string in_quotes(std::string_view word);

}  // namespace inhabit
