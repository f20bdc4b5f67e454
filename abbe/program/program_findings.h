#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "abbe/core/diagnostic.h"
#include "abbe/program/block.h"

namespace abbe {

/// Collects what is wrong with one program: every finding with its place, at most kPerCode of a kind.
class ProgramFindings {
 public:
  static constexpr int kPerCode = 100;
  explicit ProgramFindings(std::string file) : file_(std::move(file)) {}

  /// `column` counts from 0 in the block's text.
  [[gnu::cold]] void add(Severity severity, const std::string& code, std::uint64_t line,
                         std::string_view text, std::size_t column, std::size_t length, std::string message,
                         std::string why, std::string fix);
  [[gnu::cold]] void add(const BlockError& error, std::uint64_t line, std::string_view text);

  /// Takes over what another collection found, but for findings of this code.
  void add_all_but(const ProgramFindings& other, const std::string& code);

  [[nodiscard]] bool refused() const { return errors_ > 0; }
  [[nodiscard]] const Diagnostics& list() const { return list_; }
  /// Ends the collection: adds how many findings of a kind were not listed.
  [[nodiscard]] Diagnostics take();

 private:
  std::string file_;
  Diagnostics list_;
  std::map<std::string, int> count_;
  std::uint64_t errors_ = 0;
};

}  // namespace abbe
