// Subprograms of the same file that are called once: rewritten where they stand, in the state of their only
// call.

#include <fmt/format.h>

#include <utility>

#include "abbe/compensate/rewriter.h"
#include "abbe/program/subprogram.h"

namespace abbe {
namespace {

constexpr std::size_t kDeepest = 4;
/// Beyond it the first digits of P count repetitions.
constexpr double kLargestNumber = 9999;

}  // namespace

// False: refused, because the block does more than call or return.
bool Rewriter::only_changes_flow(std::string_view words) {
  int codes = 0;
  for (int i = 0; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    if (word.letter == 'M' ? ++codes == 1 : words.find(word.letter) != std::string_view::npos) continue;
    refuse(word, "E-OWORD", "a call or return of a subprogram beside other words",
           "in which order they act is not sure", "give it a block of its own");
    return false;
  }
  return true;
}

// The number of the subprogram that the block calls, once and with nothing beside it. Nothing: refused.
std::optional<int> Rewriter::called_number() {
  if (!only_changes_flow("NPL")) return std::nullopt;
  const Word* p = instruction_.find(*block_, 'P');
  const Word* l = instruction_.find(*block_, 'L');
  if (p == nullptr || p->value < 1 || p->value > kLargestNumber || p->value != static_cast<int>(p->value) ||
      (l != nullptr && l->value != 1)) {
    refuse_block("E-OWORD", "a subprogram is called more than once, or its number is not a P from 1 to 9999",
                 "each time it runs elsewhere it needs other corrections",
                 "post the calls expanded: the subprogram's blocks in place of each call");
    return std::nullopt;
  }
  const int number = static_cast<int>(p->value);
  if (!called_.insert(number).second) {
    refuse_block("E-OWORD", fmt::format("subprogram {} is called a second time", number),
                 "each time it runs elsewhere it needs other corrections",
                 "post the calls expanded: the subprogram's blocks in place of each call");
    return std::nullopt;
  }
  return number;
}

// The call is copied, the subprogram's lines are rewritten as if they stood here and kept until the file
// comes to them.
void Rewriter::run_subprogram() {
  const auto number = called_number();
  if (!number) return;
  if (depth_ == 0) call_line_ = number_;
  const auto found = find_subprogram(job_.path, *number);
  if (!found || depth_ == kDeepest || found->first_line <= call_line_) {
    refuse_block(
        "E-OWORD",
        fmt::format("subprogram {} does not stand once, behind the main program, in this file", *number),
        "what it does is not known",
        "put it behind the end of the main program, or post without subprograms");
    return;
  }
  if (Block head; read_block(found->lines.front(), head) || head.count != 1 || head.slash) {
    refuse_block("E-OWORD",
                 fmt::format("the first line of subprogram {} holds more than its number", *number),
                 "only a number alone is known", "give it a line of its own");
    return;
  }
  run_found(*found, fmt::format("subprogram {}", *number));
}

void Rewriter::run_found(const Subprogram& found, const std::string& name) {
  ++depth_;
  Block* const calling = block_;
  const KlartextContext outside = klartext_;
  klartext_ = {};
  klartext_.comma = outside.comma;
  Block block;
  Called called{found.first_line, found.first_line + found.lines.size(), found.lines.front(), {}};
  called.lines.push_back({found.lines.front(), 0, false});
  ++report_.lines_out;
  returned_ = false;
  for (std::size_t i = 1; i < found.lines.size(); ++i) {
    called.lines.push_back({found.lines[i], called.text.size(), false});
    if (returned_) {  // behind its end
      called.text += found.lines[i];
      ++report_.lines_out;
    } else {
      number_ = found.first_line + i;
      const auto error = read_line(found.lines[i], block);
      block_ = &block;
      called.lines.back().continues = block.continues;
      line(error, false, called.text);
    }
    if (ended_) {
      refuse_block("E-OWORD", "the program ends inside a subprogram", "what follows the call is then not run",
                   "end the subprogram, and the program behind the call");
      break;
    }
  }
  if (!returned_ && !findings_.refused()) {
    const char* const end = profile_.text.conversational ? "LBL 0" : "M99";
    refuse_block("E-OWORD", fmt::format("{} does not end with {}", name, end), "where it goes on is not sure",
                 "end it");
  }
  returned_ = false;
  block_ = calling;
  klartext_ = outside;
  --depth_;
  const std::uint64_t first = called.first;
  run_.emplace(first, std::move(called));
}

// LBL and CALL LBL of conversational programs: a label behind the end of the program that is called once.
void Rewriter::follow_label(std::string& out) {
  pass(out);
  if (block_->flow == Block::Flow::end) {
    returned_ = depth_ > 0;
    return;
  }
  if (block_->flow == Block::Flow::call) return call_label();
  if (called_labels_.count(std::string(block_->label)) == 0) return;
  refuse_block("E-OWORD", "the program comes to a subprogram that it has called",
               "it runs a second time, elsewhere", "put subprograms behind M30");
}

void Rewriter::call_label() {
  const std::string label(block_->label);
  if (!called_labels_.insert(label).second) {
    refuse_block("E-OWORD", fmt::format("LBL {} is called a second time", label),
                 "each time it runs elsewhere it needs other corrections",
                 "post the calls expanded: the subprogram's blocks in place of each call");
    return;
  }
  if (depth_ == 0) call_line_ = number_;
  const auto found = find_label(job_.path, label);
  if (!found || depth_ == kDeepest || found->first_line <= call_line_) {
    refuse_block("E-OWORD", fmt::format("LBL {} does not stand once, behind its call, in this file", label),
                 "what it does is not known, or it runs more than once", "put it behind M30");
    return;
  }
  run_found(*found, fmt::format("LBL {}", label));
}

// The numbers of its blocks follow those of the blocks before them in the file.
void Rewriter::renumber_called(const Called& called, std::string& out) {
  for (std::size_t i = 0; i < called.lines.size(); ++i) {
    const Called::Line& line = called.lines[i];
    const std::size_t end = i + 1 < called.lines.size() ? called.lines[i + 1].begin : called.text.size();
    const std::size_t begin = out.size();
    out += called.text.substr(line.begin, end - line.begin);
    if (line.continues || block_numbers_.renumber(line.original, begin, out)) continue;
    refuse_block("E-BLOCK", "the numbers of the blocks of a subprogram do not grow",
                 "blocks that are added must be counted", "let the control number the program anew");
  }
  counted_ = true;
}

void Rewriter::follow_flow() {
  constexpr int call = 1;
  if (instruction_.flow == call) return run_subprogram();
  if (depth_ == 0) {
    refuse_block("E-OWORD", "M99 in the main program", "it runs again and again", "end it with M30");
    return;
  }
  if (only_changes_flow("N")) returned_ = true;
}

// Behind the end of the program: what was called stands here as it was rewritten.
void Rewriter::pass_behind_end(std::string& out) {
  if (const auto run = run_.find(number_); run != run_.end()) {
    if (profile_.text.conversational)
      renumber_called(run->second, out);
    else
      out += run->second.text;
    behind_ = run->second.end;
  }
  if (number_ >= behind_) pass(out);
}

}  // namespace abbe
