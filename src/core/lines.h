// Lines and numbers of text files, as editors and programs of all systems write them.
#pragma once
#include <string_view>
#include <vector>

namespace glowworm {

/// The text without the byte order mark (UTF-8) that some editors write in front of it.
std::string_view without_byte_order_mark(std::string_view text);

/// Removes the first line from `text` and returns it without its end: LF, CR LF, or CR alone. The last line needs no
/// end.
std::string_view take_line(std::string_view& text);

/// What stands between words.
inline constexpr std::string_view kBlanks = " \t\r\n\v\f";

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = kBlanks);

/// Removes the first word of `text`, and the blanks before it, and returns the word. Empty if there is none.
std::string_view take_word(std::string_view& text);
/// All words.
std::vector<std::string_view> words_of(std::string_view text);

/// Removes the number at the beginning of `text` and writes it to `value`. Returns false, and changes nothing, if there
/// is none. A number may begin with '+'; the locale has no effect. Numbers beyond double are infinite, and numbers
/// below are 0. Understands what C libraries of Windows write for numbers that are not finite, such as 1.#INF or
/// -1.#QNAN.
bool take_number(std::string_view& text, double& value);

}  // namespace glowworm
