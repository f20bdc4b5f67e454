#include "abbe/verify/reader.h"

#include <algorithm>
#include <utility>

#include "abbe/verify/block.h"
#include "abbe/verify/control.h"

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

}  // namespace

struct ProgramReader::State {
  State(LineReader reader, std::string file_name, const ControlSetup& setup, const Options& choice)
      : lines(std::move(reader)), name(std::move(file_name)), options(choice), control(setup, choice.rotary) {}

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
          if (control.motion() != nullptr) return Item::motion;
        }
        has_block = false;
        in_tail = control.ended();
        if (control.after() != nullptr) {
          current = control.after();
          return Item::event;
        }
      }
      if (at_end) return Item::end;
      read_line();
    }
    return Item::refused;
  }

  void read_line() {
    const auto whole = lines.next();
    if (!whole) {
      at_end = true;
      if (lines.error()) refuse_file(*lines.error());
      return;
    }
    text = without_eol(*whole);
    deletable = false;
    if (in_tail) return report(EventKind::after_end);
    if (at_start) {  // tape leader
      text.remove_prefix(std::min(text.find_first_not_of('\0'), text.size()));
      if (text.empty()) return;
      at_start = false;
    }
    const auto first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return;
    const bool may_delimit = first_line || delimited;
    first_line = false;
    if (text[first] == '%' && may_delimit && trimmed(text) == "%") {
      in_tail = delimited;
      delimited = true;
      return report(EventKind::delimiter);
    }
    if (text[first] == '/') {
      deletable = saw_deletable = true;
      if (options.skip_deletable) {
        at_top = false;
        if (options.report_skipped) report(EventKind::skipped_line);
        return;
      }
    }
    read_words(first);
  }

  void read_words(std::size_t first) {
    Fault fault;
    if (lines.too_long()) {
      fault = {"E-LINELEN",
               kMaxBlockLength + 1,
               1,
               "the line is far too long",
               "LinuxCNC stops at longer lines",
               "shorten the line"};
      return refuse(fault);
    }
    std::string_view words = text;
    const bool numbered =
        first_block && (text[first] == 'O' || text[first] == 'o') && program_number(first, words);
    const auto codes = options.rotary != nullptr ? options.rotary->codes() : std::span<const TcpCode>{};
    const bool readable = read_block(words, block, fault, codes);
    const bool says_something = block.words != 0 || block.g_groups != 0 || block.m_groups != 0 || block.tcp_code >= 0;
    if (numbered && says_something) {
      fault = {"E-OWORD",
               first + 1,
               1,
               "program number together with other words",
               "only a program number alone at the start is known",
               "give it a line of its own"};
      return refuse(fault);
    }
    if (!readable) {
      fault.column += text.size() - words.size();
      return refuse(fault);
    }
    if (says_something || numbered) first_block = false;
    if (says_something) at_top = false;
    if (!control.execute(block, fault)) return refuse(fault);
    has_block = true;
    motion_given = false;
    event_index = 0;
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

  void report(EventKind kind) {
    single = Event{};
    single.kind = kind;
    single.text = kind == EventKind::delimiter ? std::string_view() : text;
    has_single = true;
  }

  void refuse(const Fault& fault) {
    refused = true;
    refusal = {Severity::error,
               fault.code,
               {name, static_cast<std::size_t>(lines.line_number()), fault.column, fault.length,
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
  std::string name;
  Options options;
  Control control;
  Block block;
  std::string_view text;  ///< current line without its end of line

  Event single;  ///< what the current line says besides its block
  bool has_single = false;
  bool has_block = false;  ///< the block in `control` is being handed out
  std::size_t event_index = 0;
  bool motion_given = false;
  const Event* current = nullptr;

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
  auto lines = LineReader::open(path, options.hashed);
  if (auto* error = std::get_if<FileError>(&lines)) return std::move(*error);
  return ProgramReader(std::make_unique<State>(std::move(std::get<LineReader>(lines)), name, setup, options));
}

ProgramReader::Item ProgramReader::next() { return state_->next(); }
const Event& ProgramReader::event() const { return *state_->current; }
const Motion& ProgramReader::motion() const { return *state_->control.motion(); }
const Diagnostic& ProgramReader::refusal() const { return state_->refusal; }
std::uint64_t ProgramReader::line() const { return state_->lines.line_number(); }
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
LineReader& ProgramReader::file() { return state_->lines; }

}  // namespace abbe::verifying
