#include "abbe/verify/reader.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "abbe/verify/block.h"
#include "abbe/verify/control.h"
#include "abbe/verify/klartext_words.h"

namespace abbe::verifying {
namespace {

std::string_view without_eol(std::string_view line) {
  if (!line.empty() && line.back() == '\n') line.remove_suffix(1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

/// "(ABBE ...)": written by the rewriter at the top of its output.
bool is_header_comment(std::string_view comment) {
  comment.remove_prefix(1);
  return trimmed(comment).substr(0, 4) == "ABBE";
}

/// A subprogram: its lines without their ends, from "O2000" on.
struct Call {
  std::uint64_t first = 0;  ///< number of the line "O2000"
  std::vector<std::string> lines;
  std::size_t at = 0;  ///< the current one
};

/// What a line of a conversational program labels: "5" of "12 LBL 5 ;TEXT"; empty: nothing.
std::string_view label_in(std::string_view line) {
  long number = 0;
  std::string_view words = trimmed(behind_block_number(line, number));
  words = trimmed(words.substr(0, words.find(';')));
  const bool label = words.size() > 4 && words.substr(0, 3) == "LBL" && (words[3] == ' ' || words[3] == '\t');
  return label ? trimmed(words.substr(4)) : std::string_view();
}

/// From LBL to the next LBL 0. Empty if the label does not stand exactly once in the file.
Call lines_of_label(const std::string& path, FileGrowth* growth, std::string_view label) {
  constexpr std::size_t most = 200000;
  const std::string wanted(label);
  Call call;
  auto opened = LineReader::open(path, false, growth);
  if (std::holds_alternative<FileError>(opened)) return call;
  auto& lines = std::get<LineReader>(opened);
  bool taking = false;
  while (const auto next = lines.next()) {
    const std::string_view text = without_eol(*next), here = label_in(text);
    if (here == wanted) {
      if (!call.lines.empty()) return {};
      call.first = lines.line_number();
      taking = true;
    }
    if (!taking) continue;
    if (lines.too_long() || call.lines.size() == most) return {};
    call.lines.emplace_back(text);
    taking = here.empty() || here.find_first_not_of('0') != std::string_view::npos;
  }
  return call;
}

/// Empty if the number does not stand at the start of exactly one line.
Call lines_of_subprogram(const std::string& path, FileGrowth* growth, int number) {
  constexpr std::size_t most = 200000;
  Call call;
  auto opened = LineReader::open(path, false, growth);
  if (std::holds_alternative<FileError>(opened)) return call;
  auto& lines = std::get<LineReader>(opened);
  bool taking = false, in_program = false;
  while (const auto next = lines.next()) {
    const std::string_view text = without_eol(*next), words = trimmed(text);
    if (words == "%" && in_program) break;  // the end of what the control loads
    in_program = in_program || (!words.empty() && words[0] != '%' && words[0] != '(' && words[0] != '\0');
    const bool names = !words.empty() && (words[0] == 'O' || words[0] == 'o');
    if (names) {
      const auto digits = words.substr(1, words.find_first_not_of("0123456789", 1) - 1);
      taking = !digits.empty() && digits.size() < 9 && std::stoi(std::string(digits)) == number;
      if (taking && !call.lines.empty()) return {};
      if (taking) call.first = lines.line_number();
    }
    if (!taking) continue;
    if (lines.too_long() || call.lines.size() == most) return {};
    call.lines.emplace_back(text);
  }
  return call;
}

}  // namespace

struct ProgramReader::State {
  State(LineReader reader, const std::string& file, std::string file_name, const ControlSetup& setup,
        const Options& choice)
      : lines(std::move(reader)),
        path(file),
        name(std::move(file_name)),
        options(choice),
        control(setup, choice.rotary) {}

  Item next() {
    while (!refused) {
      if (has_single) {
        has_single = false;
        current = &single;
        return Item::event;
      }
      if (has_block) {
        const auto events = control.before();
        while (event_index < events.size()) {
          current = &events[event_index++];
          if (!at_top || current->kind != EventKind::comment || !is_header_comment(current->text))
            return Item::event;
        }
        if (!motion_given) {
          motion_given = true;
          given = control.motion();
          if (given != nullptr) return Item::motion;
        }
        if (!hole_given) {
          hole_given = true;
          given = control.hole();
          if (given != nullptr) return Item::motion;
        }
        if (const auto after = control.after(); after_index < after.size()) {
          current = &after[after_index++];
          return Item::event;
        }
        has_block = false;
        in_tail = control.ended();
        if (in_tail && !calls.empty()) {
          refuse_flow("the program ends inside a subprogram");
          continue;
        }
        if (control.flow() != 0) [[unlikely]] {
          follow_flow(control.flow());
          control.flow_followed();
          continue;
        }
      }
      if (at_end) return Item::end;
      read_line();
    }
    return Item::refused;
  }

  /// Enters the subprogram, or leaves the running one.
  void follow_flow(int flow) {
    if (flow == Control::kLabel) {
      for (const auto& [first, end] : ran)
        if (calls.empty() && line() == first) refuse_flow("a subprogram that was called comes again");
      return;
    }
    if (flow < 0) {
      if (calls.empty() && flow == Control::kEndLabel) return;  // the label of nothing
      if (calls.empty()) return refuse_flow("M99 where no subprogram runs");
      ran.emplace_back(calls.back().first, line() + 1);
      calls.pop_back();
      return;
    }
    constexpr std::size_t deepest = 4;
    if (calls.size() == deepest) return refuse_flow("too many subprograms inside each other");
    Call call = flow == Control::kCallLabel ? lines_of_label(path, options.growth, control.label())
                                            : lines_of_subprogram(path, options.growth, flow);
    if (call.lines.empty()) return refuse_flow("a subprogram that is not in this file once");
    if (conversational && !may_call(call)) return;
    calls.push_back(std::move(call));
    called_open = {};
    text = calls.back().lines.front();
    if (conversational) {
      long number = 0;
      text = behind_block_number(text, number);
    }
    report(EventKind::comment);
    single.text = text;
  }

  void refuse_flow(const char* message) {
    fault = {"E-OWORD",
             1,
             1,
             message,
             "what the control does then is not known",
             "call subprograms that stand behind the program in its file"};
    refuse();
  }

  /// A label is called once, from before it.
  bool may_call(const Call& call) {
    bool again = call.first <= main_line();
    for (const auto& [first, end] : ran) again = again || first == call.first;
    for (const Call& running : calls) again = again || running.first == call.first;
    if (again) refuse_flow("a label that runs a second time, or stands before its call");
    return !again;
  }
  /// Block numbers grow from block to block; they are no part of what the line says. False: refused.
  bool count_block() {
    if (continued[row].open) return true;
    long number = -1;
    const std::string_view words = behind_block_number(text, number);
    if (in_tail) text = words;
    if (number < 0) return true;
    if (number > last_number) {
      last_number = number;
      return true;
    }
    fault = {"E-BLOCK",
             1,
             1,
             "the number of the block is not above that of the block before",
             "the control refuses such a program",
             "let the control number it anew"};
    refuse();
    return false;
  }

  /// The next line of the running subprogram.
  void read_called_line() {
    Call& call = calls.back();
    deletable = false;
    if (++call.at == call.lines.size()) {
      fault = {"E-OWORD",        1, 1, "a subprogram without M99", "where the program goes on is not known",
               "end it with M99"};
      return refuse();
    }
    text = call.lines[call.at];
    now = called_open;
    if (conversational) called_open = continued_after(text, called_open);
    read_text();
  }

  void read_line() {
    if (!calls.empty()) [[unlikely]]
      return read_called_line();
    if (++row == rows && !read_rows()) return;
    text = texts[row];
    now = continued[row];
    deletable = false;
    if (conversational && !count_block()) return;
    if (in_tail) {
      for (const auto& [first, end] : ran)
        if (line() >= first && line() < end) return;  // it ran, and was looked at then
      return report(EventKind::after_end);
    }
    read_text();
  }

  void read_text() {
    if (at_start) {  // tape leader
      text.remove_prefix(std::min(text.find_first_not_of('\0'), text.size()));
      if (text.empty()) return;
      at_start = false;
    }
    const auto first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return;
    const bool may_delimit = first_line || delimited;
    first_line = false;
    if (text[first] == '%' && control.profile().text.percent && may_delimit && trimmed(text) == "%") {
      in_tail = delimited;
      delimited = true;
      return report(EventKind::delimiter);
    }
    if (text[first] == '/' && control.profile().text.skip != Profile::Skip::ignored) {
      deletable = saw_deletable = true;
      if (options.skip_deletable) {
        at_top = false;
        if (options.report_skipped) report(EventKind::skipped_line);
        return;
      }
    }
    read_words(first);
  }

  [[nodiscard]] std::span<const TcpCode> tcp_codes() const {
    return options.rotary != nullptr ? options.rotary->codes() : std::span<const TcpCode>{};
  }

  /// Some lines at once; most of them are blocks of words and nothing else, whatever comes before them.
  bool read_rows() {
    row = 0;
    rows = lines.next(texts);
    if (rows == 0) {
      at_end = true;
      if (lines.error()) refuse_file(*lines.error());
      return false;
    }
    for (std::size_t i = 0; i < rows; ++i) {
      texts[i] = without_eol(texts[i]);
      if (conversational) {
        continued[i] = open;
        open = continued_after(texts[i], open);
      }
      readable[i] =
          !in_tail && read_block(texts[i], control.profile(), blocks[i], fault, tcp_codes(), continued[i]);
    }
    plain_count = 0;
    // plain motions that turn axes are judged by poses, not by tips
    const bool turns = rows > 0 && readable[0] && (blocks[0].words & letters('A', 'B', 'C')) != 0;
    if (options.looks_ahead && !turns) look_ahead();
    return true;
  }

  /// Everything that the block says has been handed out, and nothing of it changes what comes next.
  [[nodiscard]] bool block_is_done() const {
    return event_index == control.before().size() && (motion_given || control.motion() == nullptr) &&
           (hole_given || control.hole() == nullptr) && after_index == control.after().size() &&
           control.flow() == 0 && !control.ended();
  }

  [[nodiscard]] bool between_blocks() const {
    return !has_single && !has_block && calls.empty() && !in_tail && !at_end && !refused && !conversational &&
           !first_block && !at_top && !at_start;
  }

  PlainRun plain() {
    if (has_block && block_is_done()) has_block = false;
    if (!between_blocks() || !control.goes_plainly()) return {};
    if (row + 1 == rows) {
      text = {};
      if (!read_rows()) return {};
      row = kNoRow;
    }
    const std::size_t next = row + 1;
    if (next >= plain_begin && next < plain_begin + plain_count)
      return {{plains.data(), plain_count}, next - plain_begin, plain_serial};
    plain_begin = next;
    plain_count = 0;
    ++plain_serial;
    const PlainMotion* from = &present;
    present = control.here();
    while (next + plain_count < rows && readable[next + plain_count] &&
           control.leads_plainly(blocks[next + plain_count], *from, plains[plain_count])) {
      from = &plains[plain_count++];
    }
    return {{plains.data(), plain_count}, 0, plain_serial};
  }

  void take(std::size_t count) {
    if (count == 0) return;
    row += count;
    control.take(plains[row - plain_begin]);
    text = texts[row];
    deletable = false;
    place_count = 0;
  }

  /// In the present state: what changes it leads elsewhere.
  void look_ahead() {
    place_count = 0;
    Position u = control.position();
    for (std::size_t i = 0; i < rows; ++i) {
      if (!readable[i] || named_axes(blocks[i]) == 0) continue;
      u = control.led(blocks[i], u);
      const Position m = machine_of(control.frames(), u);
      if (m.known == kAllAxes) places[place_count++] = m.at;
    }
  }

  void read_words(std::size_t first) {
    if (lines.too_long()) {
      fault = {"E-LINELEN",
               kMaxBlockLength + 1,
               1,
               "the line is far too long",
               "controls stop at longer lines",
               "shorten the line"};
      return refuse();
    }
    std::string_view words = text;
    const Profile::Text& rules = control.profile().text;
    const bool names = (rules.program_number && (text[first] == 'O' || text[first] == 'o')) ||
                       (rules.colon && text[first] == ':');
    const bool numbered = first_block && names && program_number(first, words);
    // The words start elsewhere behind a program number or a tape leader.
    const Block& block = blocks[row];
    const bool understood = (words.data() == texts[row].data() && readable[row]) ||
                            read_block(words, control.profile(), blocks[row], fault, tcp_codes(), now);
    const bool says_something = block.hole.cycle != 0 || block.flow != Block::Flow::none ||
                                block.words != 0 || block.pole != Block::Pole::none || block.g_groups != 0 ||
                                block.m_groups != 0 || block.extra_count != 0 || block.tcp_code >= 0;
    if (numbered && says_something) {
      fault = {"E-OWORD",
               first + 1,
               1,
               "program number together with other words",
               "only a program number alone at the start is known",
               "give it a line of its own"};
      return refuse();
    }
    if (!understood) {
      fault.column += text.size() - words.size();
      return refuse();
    }
    // conversational programs have their header behind BEGIN PGM
    if (says_something && !(conversational && first_block)) at_top = false;
    if (says_something || numbered) first_block = false;
    if (!control.execute(block, fault)) return refuse();
    has_block = true;
    motion_given = hole_given = false;
    event_index = after_index = 0;
  }

  /// Takes "O1234" from the front of the first block and reports it; what follows may be comments.
  bool program_number(std::size_t o, std::string_view& rest) {
    const auto digits = text.find_first_not_of(" \t", o + 1);
    if (digits == std::string_view::npos) return false;
    auto end = digits;
    double number = 0;
    while (end < text.size() && text[end] >= '0' && text[end] <= '9' && end - digits < 9)
      number = 10 * number + (text[end++] - '0');
    if (end == digits) return false;
    report(EventKind::program_number);
    single.words = letter_bit('O');
    single.values[0] = number;
    single.text = {};
    rest = text.substr(end);
    return true;
  }

  [[nodiscard]] std::uint64_t line() const {
    if (!calls.empty()) [[unlikely]]
      return calls.back().first + calls.back().at;
    return main_line();
  }
  /// The line to which the program itself has come.
  [[nodiscard]] std::uint64_t main_line() const {
    return lines.line_number() - (rows == 0 ? 0 : rows - 1 - row);
  }

  void report(EventKind kind) {
    single = Event{};
    single.kind = kind;
    single.text = kind == EventKind::delimiter ? std::string_view() : text;
    has_single = true;
  }

  void refuse() {
    refused = true;
    refusal = {Severity::error,
               fault.code,
               {name, static_cast<std::size_t>(line()), fault.column, fault.length,
                std::string(text.substr(0, kMaxBlockLength))},
               fault.message,
               fault.why,
               fault.fix};
  }

  void refuse_file(const FileError& error) {
    refused = true;
    refusal = {Severity::error,
               "E-FILE",
               {name, 0, 0, 0, {}},
               error.message,
               "the program could not be read to its end",
               "check the file"};
  }

  LineReader lines;
  std::string path, name;
  Options options;
  Control control;
  Fault fault;

  // The lines read last, without their ends of line, and as blocks where that is what they are.
  static constexpr std::size_t kRows = 16;
  std::array<std::string_view, kRows> texts;
  std::array<Block, kRows> blocks;
  std::array<bool, kRows> readable{};
  std::size_t rows = 1, row = 0;  ///< the current one
  /// Before the first row: ++row is 0.
  static constexpr std::size_t kNoRow = static_cast<std::size_t>(-1);
  std::array<PlainMotion, kRows> plains;  ///< of rows from plain_begin on
  PlainMotion present;
  std::size_t plain_begin = 0, plain_count = 0;
  std::uint64_t plain_serial = 0;
  std::array<Vec3, kRows> places;
  std::size_t place_count = 0;
  std::string_view text;  ///< of the current line
  bool conversational = control.profile().text.conversational;
  std::array<Continued, kRows> continued{};  ///< what was open before each of these lines
  Continued open;                            ///< behind the last one
  long last_number = -1;                     ///< of a block

  Event single;  ///< what the current line says besides its block
  bool has_single = false;
  bool has_block = false;  ///< the block in `control` is being handed out
  std::size_t event_index = 0, after_index = 0;
  bool motion_given = false, hole_given = false;
  Continued now, called_open;     ///< what the lines before the current one leave open, and in a subprogram
  const Motion* given = nullptr;  ///< the motion of the current item
  const Event* current = nullptr;

  std::vector<Call> calls;  ///< the subprograms now running, the innermost last
  std::vector<std::pair<std::uint64_t, std::uint64_t>>
      ran;  ///< lines of all that ran: first, behind the last

  bool at_start = true;     ///< only NUL bytes so far
  bool first_line = true;   ///< only blank lines so far
  bool first_block = true;  ///< no block with words so far
  bool at_top = true;       ///< header comments may still come
  bool delimited = false;   ///< began with %
  bool in_tail = false;     ///< behind the end of the program
  bool at_end = false, refused = false;
  bool deletable = false, saw_deletable = false;
  Diagnostic refusal;
};

ProgramReader::ProgramReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
ProgramReader::~ProgramReader() = default;
ProgramReader::ProgramReader(ProgramReader&&) noexcept = default;
ProgramReader& ProgramReader::operator=(ProgramReader&&) noexcept = default;

FileResult<ProgramReader> ProgramReader::open(const std::string& path, const std::string& name,
                                              const ControlSetup& setup, const Options& options) {
  auto lines = LineReader::open(path, options.hashed, options.growth);
  if (auto* error = std::get_if<FileError>(&lines)) return std::move(*error);
  return ProgramReader(
      std::make_unique<State>(std::move(std::get<LineReader>(lines)), path, name, setup, options));
}

ProgramReader::Item ProgramReader::next() { return state_->next(); }
PlainRun ProgramReader::plain() { return state_->plain(); }
PlainMotion ProgramReader::here() const { return state_->control.here(); }
void ProgramReader::take(std::size_t count) { state_->take(count); }
const Event& ProgramReader::event() const { return *state_->current; }
const Motion& ProgramReader::motion() const { return *state_->given; }
const Diagnostic& ProgramReader::refusal() const { return state_->refusal; }
std::span<const Vec3> ProgramReader::ahead() {
  return {state_->places.data(), std::exchange(state_->place_count, 0)};
}
std::uint64_t ProgramReader::line() const { return state_->line(); }
const std::string& ProgramReader::name() const { return state_->name; }
std::string ProgramReader::source_line() const {
  return std::string(state_->text.substr(0, kMaxBlockLength));
}
bool ProgramReader::deletable() const { return state_->deletable; }
bool ProgramReader::saw_deletable() const { return state_->saw_deletable; }
const Frames& ProgramReader::frames() const { return state_->control.frames(); }
std::optional<int> ProgramReader::tool() const { return state_->control.tool(); }
const Turns& ProgramReader::turns() const { return state_->control.turns(); }
bool ProgramReader::tcp() const { return state_->control.tcp(); }
bool ProgramReader::inch() const { return state_->control.inch(); }
const Profile& ProgramReader::profile() const { return state_->control.profile(); }
LineReader& ProgramReader::file() { return state_->lines; }

}  // namespace abbe::verifying
