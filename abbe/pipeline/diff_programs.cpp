#include "abbe/pipeline/diff_programs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "abbe/core/file.h"
#include "abbe/program/block.h"
#include "abbe/program/named_block.h"

namespace abbe {
namespace {

// A piece of a split block ends where the original does when its numbers are this near, program units.
constexpr double kNear = 0.6;

bool is_coordinate(char letter) { return letter >= 'I' && letter <= 'K'; }
bool is_axis(char letter) { return letter >= 'X' && letter <= 'Z'; }
bool may_change(char letter) {
  return is_axis(letter) || is_coordinate(letter) || letter == 'R' || letter == 'F';
}

/// A line kept after the reader went on.
struct Line {
  std::string bytes;
  Block block;
  std::uint64_t number = 0;
  bool understood = false;
};

/// As the control reads it; false: not understood.
bool split_words(std::string_view line, const Profile* profile, Block& block) {
  const bool names = profile != nullptr && profile->text.names;
  return names ? !read_named_block(line, *profile, block) : !read_block(line, block, true);
}

bool is_header(const std::string& line) { return line.starts_with("(ABBE ") || line.starts_with(";ABBE "); }

class Lines {
 public:
  Lines(LineReader reader, const Profile* profile) : reader_(std::move(reader)), profile_(profile) {}

  /// The line after the ones taken, without taking it.
  const Line* peek() {
    if (!ready_) {
      const auto next = reader_.next();
      if (!next) return nullptr;
      line_.bytes.assign(*next);
      line_.number = reader_.line_number();
      std::string_view view = line_.bytes;
      if (line_.number == 1) view.remove_prefix(std::min(view.find_first_not_of('\0'), view.size()));
      line_.understood = split_words(view, profile_, line_.block);
      ready_ = true;
    }
    return &line_;
  }
  void take() { ready_ = false; }
  [[nodiscard]] std::uint64_t count() const { return reader_.line_number(); }

 private:
  LineReader reader_;
  const Profile* profile_;
  Line line_;
  bool ready_ = false;
};

const Word* find(const Block& block, char letter) {
  for (int i = 0; i < block.count; ++i) {
    const Word& word = block.words[static_cast<std::size_t>(i)];
    if (word.letter == letter) return &word;
  }
  return nullptr;
}

std::string number_text(const Block& block, const Word& word) {
  return std::string(block.text.substr(word.number, static_cast<std::size_t>(word.end - word.number)));
}

bool has_centre(const Block& block) {
  return find(block, 'I') || find(block, 'J') || find(block, 'K') || find(block, 'R');
}
bool is_line_or_arc(const Word& word) {
  return word.letter == 'G' && (word.value == 1 || word.value == 2 || word.value == 3);
}

/// An arc whose block became the straight move that takes up lost motion before it.
bool takes_up(const Block& original, const Block& output) {
  if (!has_centre(original) || has_centre(output)) return false;
  for (int i = 0; i < output.count; ++i) {
    const Word& word = output.words[static_cast<std::size_t>(i)];
    if (word.letter == 'G' && word.value == 1) return true;
  }
  return false;
}

/// The text with numbers that may change, words that may be added and blanks taken out; without the motion
/// code if an arc became a straight move.
std::string skeleton(const Block& block, const Block& other) {
  const bool became_straight = takes_up(block, other) || takes_up(other, block);
  std::string text;
  std::size_t at = 0;
  const auto put = [&](std::string_view piece) {
    for (const char c : piece) {
      if (c != ' ' && c != '\t') text += c;
    }
  };
  for (int i = 0; i < block.count; ++i) {
    const Word& word = block.words[static_cast<std::size_t>(i)];
    const bool both = find(other, word.letter) != nullptr;
    // what a split moves to its last piece, and the turns of an arc that was unrolled
    const bool moved = (became_straight && is_line_or_arc(word)) ||
                       (word.letter == 'M' && (word.value <= 2 || word.value == 30 || word.value == 60)) ||
                       (word.letter == 'P' && !both);
    put(block.text.substr(at, word.begin - at));
    if (!moved && (!may_change(word.letter) || both)) {
      put(block.text.substr(word.begin, 1));
      if (!may_change(word.letter))
        put(block.text.substr(word.begin + 1u, static_cast<std::size_t>(word.end - word.begin - 1)));
    }
    at = word.end;
  }
  put(block.text.substr(at));
  return text;
}

bool only_coordinates(const Line& line) {
  if (!line.understood || line.block.count == 0 || line.block.has_comment) return false;
  for (int i = 0; i < line.block.count; ++i) {
    const Word& word = line.block.words[static_cast<std::size_t>(i)];
    if (!may_change(word.letter) && word.letter != 'M' && !is_line_or_arc(word)) return false;
  }
  return true;
}

}  // namespace

DiffReport diff_programs(const std::string& original, const std::string& output,
                         const std::function<void(const WordChange&)>& each, const Profile* profile) {
  DiffReport report;
  auto first = LineReader::open(original), second = LineReader::open(output);
  for (auto* opened : {&first, &second}) {
    if (const auto* error = std::get_if<FileError>(opened)) {
      Diagnostic d;
      d.code = "E-FILE";
      d.place.file = opened == &first ? original : output;
      d.message = error->message;
      report.diagnostics.push_back(std::move(d));
    }
  }
  if (!report.diagnostics.empty()) return report;
  report.readable = report.same_program = true;
  Lines in(std::move(std::get<LineReader>(first)), profile),
      out(std::move(std::get<LineReader>(second)), profile);
  bool incremental = false;
  std::array<double, 3> at{};  // of the output, program units
  const auto differs = [&](const Line* a, const Line* b, const char* what) {
    report.same_program = false;
    Diagnostic d;
    d.code = "D-TEXT";
    d.place.file = b ? output : original;
    d.place.line = b ? b->number : a ? a->number : 0;
    d.place.column = 1;
    if (b) d.place.source_line = std::string(without_eol(b->bytes));
    d.message = a ? fmt::format("{} (line {} of the original: {})", what, a->number, without_eol(a->bytes))
                  : std::string(what);
    report.diagnostics.push_back(std::move(d));
  };
  const auto note = [&](const Line& a, const Line& b) {
    for (int i = 0; i < b.block.count; ++i) {
      const Word& after = b.block.words[static_cast<std::size_t>(i)];
      if (!may_change(after.letter)) continue;
      const Word* before = find(a.block, after.letter);
      if (before && number_text(a.block, *before) == number_text(b.block, after)) continue;
      WordChange change{a.number,
                        b.number,
                        after.letter,
                        before == nullptr,
                        before ? before->value : 0.0,
                        after.value,
                        before ? number_text(a.block, *before) : "",
                        number_text(b.block, after)};
      ++(change.added ? report.added_words : report.changed_words);
      if (before && is_axis(after.letter) && !incremental) {
        const auto k = static_cast<std::size_t>(after.letter - 'X');
        if (std::abs(after.value - before->value) > report.max_change[k]) {
          report.max_change[k] = std::abs(after.value - before->value);
          report.max_line[k] = a.number;
        }
      }
      if (each) each(change);
    }
  };
  while (const Line* a = in.peek()) {
    const Line* b = out.peek();
    while (b && is_header(b->bytes) && !is_header(a->bytes)) {
      ++report.header_lines;
      out.take();
      b = out.peek();
    }
    if (!b) {
      differs(a, nullptr, "the output ends before the original");
      break;
    }
    if (!a->understood || !b->understood) {
      if (a->bytes != b->bytes) {
        differs(a, b, "the text differs");
        break;
      }
    } else if (skeleton(a->block, b->block) != skeleton(b->block, a->block)) {
      if (only_coordinates(*b)) {  // one more piece of the block before
        ++report.added_blocks;
        out.take();
        continue;
      }
      differs(a, b, "more than numbers and added words differ");
      break;
    }
    if (a->understood) {
      for (int i = 0; i < a->block.count; ++i) {
        const Word& word = a->block.words[static_cast<std::size_t>(i)];
        if (word.letter == 'G' && word.value == 91) incremental = true;
        if (word.letter == 'G' && word.value == 90) incremental = false;
      }
    }
    // A split block: pieces follow until they reach the original's end.
    const Line whole = *a;
    std::string_view whole_view = whole.bytes;
    Line kept = whole;
    static_cast<void>(split_words(whole_view, profile, kept.block));
    const std::array<double, 3> start = at;
    const bool closed =
        has_centre(kept.block) && !find(kept.block, 'X') && !find(kept.block, 'Y') && !find(kept.block, 'Z');
    const auto reached = [&](const Block& block) {
      bool near = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const char letter = "XYZ"[k];
        const Word* word = find(block, letter);
        if (word) at[k] = incremental ? at[k] + word->value : word->value;
        const Word* target = find(kept.block, letter);
        const double end = closed || !target ? start[k] : target->value + (incremental ? start[k] : 0.0);
        if ((closed || target) && std::abs(at[k] - end) > kNear) near = false;
      }
      return near && !takes_up(kept.block, block);
    };
    if (!kept.understood || !b->understood || kept.block.count == 0) {
      in.take();
      out.take();
      continue;
    }
    if (takes_up(kept.block, b->block)) ++report.taken_up;
    bool done = reached(b->block);
    if (done) note(kept, *b);
    in.take();
    out.take();
    while (!done) {
      const Line* more = out.peek();
      if (!more || !only_coordinates(*more)) break;
      done = reached(more->block);
      const Line* next = in.peek();
      if (!done && next && next->understood && next->bytes == more->bytes) break;
      ++report.added_blocks;
      if (done) note(kept, *more);
      out.take();
    }
  }
  if (report.same_program) {
    if (const Line* rest = out.peek()) differs(nullptr, rest, "the output goes on after the original's end");
  }
  while (in.peek()) in.take();
  while (out.peek()) out.take();
  report.lines_in = in.count();
  report.lines_out = out.count();
  return report;
}

}  // namespace abbe
